"""blocks.py: the packed payloads of SAMPLES, POSES and KNOTS frames as numpy views and bytes."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.protocol.generated import records

KNOTS_PER_FRAME = 50  # 5 kB: a frame every few seconds of path, well under the 64 KiB limit


class BlockError(ValueError):
    """A payload whose size is not that of its header's count."""


def _split(payload: memoryview | bytes, header: np.dtype[Any], record: np.dtype[Any]) -> tuple[Any, NDArray[np.void]]:
    if len(payload) < header.itemsize:
        raise BlockError(f"{len(payload)} bytes; a block's header has {header.itemsize}")
    head = np.frombuffer(payload, header, count=1)[0]
    size = header.itemsize + int(head["count"]) * record.itemsize
    if len(payload) != size:
        raise BlockError(f"{len(payload)} bytes; {int(head['count'])} records need {size}")
    return head, np.frombuffer(payload, record, offset=header.itemsize)


def sample_block(payload: memoryview | bytes) -> tuple[Any, NDArray[np.void]]:
    """Header (SAMPLE_BLOCK_DTYPE scalar) and samples (SAMPLE_DTYPE, shape (n,)), in place. Raises BlockError."""
    return _split(payload, records.SAMPLE_BLOCK_DTYPE, records.SAMPLE_DTYPE)


def pose_block(payload: memoryview | bytes) -> tuple[Any, NDArray[np.void]]:
    """Header (POSE_BLOCK_DTYPE scalar) and poses (POSE_DTYPE, shape (n,)), in place. Raises BlockError."""
    return _split(payload, records.POSE_BLOCK_DTYPE, records.POSE_DTYPE)


def knot_block(payload: memoryview | bytes) -> tuple[Any, NDArray[np.void]]:
    """Header (KNOT_BLOCK_DTYPE scalar) and knots (KNOT_DTYPE, shape (n,)), in place. Raises BlockError."""
    return _split(payload, records.KNOT_BLOCK_DTYPE, records.KNOT_DTYPE)


def knot_payload(path_id: int, first_knot: int, knots: NDArray[np.void]) -> bytes:
    """Payload of a KNOTS frame for `knots` (KNOT_DTYPE, shape (n,)), the first of which is number `first_knot`."""
    header = np.zeros(1, records.KNOT_BLOCK_DTYPE)
    header["path_id"] = path_id
    header["first_knot"] = first_knot
    header["count"] = len(knots)
    return header.tobytes() + np.ascontiguousarray(knots, records.KNOT_DTYPE).tobytes()
