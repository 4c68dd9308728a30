"""decode.py: packed sample and pose blocks to flat arrays, vectorised over blocks of equal size."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gonio.protocol.generated import records

_BATCH_SAMPLES = 1 << 14  # a batch's arrays stay in the second-level cache


@dataclass
class Samples:
    """Samples of one segment, all arrays of shape (n,)."""

    samples: NDArray[np.void]  # SAMPLE_DTYPE
    number: NDArray[np.uint64]  # since START
    time_ns: NDArray[np.int64]  # controller clock, fitted sample clock; no delay corrected
    settled: NDArray[np.bool_]  # the sample clock was in use


def _runs(payloads: Sequence[bytes | memoryview]) -> Iterator[tuple[int, int]]:
    """Ranges [first, last) of neighbouring payloads of equal length."""
    lengths = np.fromiter(map(len, payloads), np.int64, len(payloads))
    edges = [0, *(np.flatnonzero(np.diff(lengths)) + 1).tolist(), len(payloads)]
    return pairwise(edges)


def decode_sample_blocks(payloads: Sequence[bytes | memoryview]) -> Samples:
    """The samples of SAMPLES payloads in order; sizes must fit the counts (the reader has checked them).

    Time of sample k of a block: first_time_ns + k * period_ns, rounded to a nanosecond.
    """
    header_size, sample_size = records.SAMPLE_BLOCK_DTYPE.itemsize, records.SAMPLE_DTYPE.itemsize
    total = sum((len(payload) - header_size) // sample_size for payload in payloads)
    out = Samples(
        np.empty(total, records.SAMPLE_DTYPE),
        np.empty(total, np.uint64),
        np.empty(total, np.int64),
        np.empty(total, bool),
    )
    done = 0
    for first, last in _runs(payloads) if payloads else ():
        count = (len(payloads[first]) - header_size) // sample_size
        if count == 0:
            continue
        block = np.dtype([("header", records.SAMPLE_BLOCK_DTYPE), ("samples", f"V{count * sample_size}")])
        offsets = np.arange(count, dtype=np.float64)
        numbers = np.arange(count, dtype=np.uint64)
        step = max(1, _BATCH_SAMPLES // count)
        for start in range(first, last, step):
            batch = np.frombuffer(b"".join(payloads[start : min(start + step, last)]), block)
            header = batch["header"]
            part = slice(done, done + len(batch) * count)
            done = part.stop
            out.samples[part].view(f"V{count * sample_size}")[...] = batch["samples"]
            np.add(header["first_sample"][:, None], numbers, out=out.number[part].reshape(-1, count))
            offset_ns = header["period_ns"][:, None] * offsets
            time_ns = out.time_ns[part].reshape(-1, count)
            time_ns[...] = np.rint(offset_ns, out=offset_ns)
            time_ns += header["first_time_ns"][:, None]
            settled = (header["flags"] & records.SAMPLE_BLOCK_CLOCK_UNSETTLED) == 0
            out.settled[part].reshape(-1, count)[...] = (settled & (header["window"] > 0))[:, None]
    return out


def decode_pose_blocks(payloads: Sequence[bytes | memoryview]) -> NDArray[np.void]:
    """The poses of POSES payloads in order, POSE_DTYPE, shape (n,)."""
    size = records.POSE_BLOCK_DTYPE.itemsize
    return np.frombuffer(b"".join(memoryview(payload)[size:] for payload in payloads), records.POSE_DTYPE)


def decode_pose_sigmas(payloads: Sequence[bytes | memoryview]) -> NDArray[np.float32]:
    """Standard uncertainty of each pose's sync_time_ns in us, as its block's header has it, shape (n,)."""
    size = records.POSE_BLOCK_DTYPE.itemsize
    headers = np.frombuffer(b"".join(payload[:size] for payload in payloads), records.POSE_BLOCK_DTYPE)
    return np.repeat(headers["sync_stamp_sigma_us"], headers["count"])
