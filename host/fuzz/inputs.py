"""inputs.py: what fuzz targets share: good files with a few bytes replaced, and what an error of input must be."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from gonio.units.errors import UsageError


def changed(data: bytes, seeds: Sequence[bytes]) -> bytes:
    """Mostly a good file with the input's last bytes somewhere in it; the input itself where it begins low."""
    if len(data) <= 3 or data[0] < 64:
        return data
    seed = seeds[data[0] % len(seeds)]
    at = int.from_bytes(data[1:3], "little") % len(seed)
    return seed[:at] + data[3:] + seed[at + len(data) - 3 :]


@contextmanager
def one_line() -> Iterator[None]:
    """A UsageError within is well, if it is one line."""
    try:
        yield
    except UsageError as error:
        if "\n" in str(error):
            raise ValueError("an error is one line") from error
