"""nexus_points.py: columns of many points in HDF5, in chunks packed here by two threads, as any HDF5 library reads."""

import zlib
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

# Below this many points compression and its chunk index cost more than they save.
_COMPRESS_FROM = 2048
_CHUNK = 1 << 16  # elements at most
_AHEAD = 1 << 28  # bytes of columns that are packed before they are wanted: memory is finite
_WORKERS = 2  # zlib and the byte shuffle run outside Python's lock
_PROBE = 4096  # bytes
_WORTH = 0.9  # of the probe's size: a byte plane that shrinks less is stored as it is
_ZLIB_HEADER = b"\x78\x01"  # deflate, window of 32 KiB, fastest


Stored = Callable[[NDArray[Any]], NDArray[Any]]


def unchanged(values: NDArray[Any]) -> NDArray[Any]:
    """A column as it is."""
    return values


class PointPacker:
    """Packs columns in threads, also before there is a file for them. Use as a context manager."""

    def __init__(self) -> None:
        self._workers = ThreadPoolExecutor(_WORKERS)
        self._begun: dict[tuple[int, Stored], tuple[NDArray[Any], Iterator[bytes]]] = {}
        self._room = _AHEAD

    def __enter__(self) -> "PointPacker":
        return self

    def __exit__(self, *_: object) -> None:
        self._workers.shutdown(cancel_futures=True)

    def begin(self, values: NDArray[Any], stored: Stored = unchanged) -> None:
        """Pack a column (n,) that will not change any more; without effect once there is no room for more."""
        if len(values) >= _COMPRESS_FROM and values.nbytes <= self._room:
            self._room -= values.nbytes
            self._begun[id(values), stored] = values, self._packed(values, stored)

    def packed(self, values: NDArray[Any], stored: Stored) -> Iterator[bytes]:
        """The chunks of a column, whether begun before or not."""
        begun = self._begun.pop((id(values), stored), None)
        return self._packed(values, stored) if begun is None else begun[1]

    def _packed(self, values: NDArray[Any], stored: Stored) -> Iterator[bytes]:
        # Executor.map submits at once; the results are taken when their turn has come.
        size = _chunk_of(len(values))
        starts = range(0, len(values), size)
        return iter(self._workers.map(lambda begin: packed(stored(values[begin : begin + size]), size), starts))


class PointWriter:
    """Writes columns; compression of one overlaps with that of the next. Use as a context manager: what is left is
    written at its end."""

    def __init__(self, packer: PointPacker) -> None:
        self._packer = packer
        self._waiting: list[tuple[h5py.Dataset, Iterator[bytes]]] = []

    def __enter__(self) -> "PointWriter":
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self._finish(keep=0)

    def add(
        self, group: h5py.Group, name: str, values: NDArray[Any], units: str = "", stored: Stored = unchanged
    ) -> h5py.Dataset:
        """A column (n,) as `group`/`name`, as `stored` makes it of parts of `values`. Large ones are shuffled and
        deflated; deflate's own checksum guards them. They are in the file once the writer is closed."""
        if len(values) < _COMPRESS_FROM:
            column = group.create_dataset(name, data=stored(values))
        else:
            column = group.create_dataset(
                name,
                values.shape,
                stored(values[:1]).dtype,
                chunks=(_chunk_of(len(values)),),
                compression="gzip",
                compression_opts=1,
                shuffle=True,
            )
            self._finish(keep=1)
            self._waiting.append((column, self._packer.packed(values, stored)))
        if units:
            column.attrs["units"] = units
        return column

    def _finish(self, *, keep: int) -> None:
        while len(self._waiting) > keep:
            column, chunks = self._waiting.pop(0)
            for number, chunk in enumerate(chunks):
                column.id.write_direct_chunk((number * column.chunks[0],), chunk)


def _chunk_of(points: int) -> int:
    """Elements per chunk: equal ones, so that little is padded."""
    return -(-points // -(-points // _CHUNK))


def packed(values: NDArray[Any], size: int) -> bytes:
    """Values (n,), padded with zeros to `size`, as HDF5's filters shuffle and gzip make them: a zlib stream (RFC 1950)
    of the first bytes of all values, then of their second bytes and so on.

    Most bytes of a measured float are noise, on which deflate spends its time in vain: those planes become stored
    blocks. Deflate blocks may follow one another whatever their kind (RFC 1951, 3.2); every plane ends on a byte.
    """
    width = values.dtype.itemsize
    planes = np.zeros((width, size), dtype=np.uint8)
    planes[:, : len(values)] = np.ascontiguousarray(values).view(np.uint8).reshape(-1, width).T
    pieces = [_ZLIB_HEADER]
    for number, plane in enumerate(planes):
        probe = plane[:_PROBE].tobytes()
        level = 1 if len(zlib.compress(probe, 1)) < _WORTH * len(probe) else 0
        deflate = zlib.compressobj(level, zlib.DEFLATED, -zlib.MAX_WBITS)
        pieces += [
            deflate.compress(plane.data),
            deflate.flush(zlib.Z_FINISH if number == width - 1 else zlib.Z_FULL_FLUSH),
        ]
    pieces.append(zlib.adler32(planes.data).to_bytes(4, "big"))
    return b"".join(pieces)
