"""bundle.py: a scenario with all files that it names, so that it can travel to another machine and be opened there."""

import hashlib
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import Any

from gonio.simulate.tables import Table, read_tables
from gonio.units.errors import UsageError

INSTRUMENT = "axes.toml"  # beside a scenario: its instrument, unless it names another


@dataclass(frozen=True)
class Bundle:
    """`scenario` and the other files by their path relative to the scenario's folder, and the tables that Python has
    read for data-driven materials, by band and file name. `seed` None: the scenario's own."""

    scenario: str
    files: dict[str, bytes]
    tables: dict[str, dict[str, Table]] = field(repr=False)
    seed: int | None

    @property
    def digest(self) -> str:
        """SHA-256 over names, contents and seed."""
        state = hashlib.sha256(f"{self.scenario} {self.seed}".encode())
        for name, content in sorted(self.files.items()):
            state.update(f"{name} {len(content)} ".encode() + content)
        return state.hexdigest()

    @property
    def text(self) -> str:
        """The scenario file."""
        return self.files[self.scenario].decode()

    def hashes(self) -> dict[str, str]:
        """SHA-256 of every file."""
        return {name: hashlib.sha256(content).hexdigest() for name, content in sorted(self.files.items())}

    def unpack(self, folder: Path) -> Path:
        """Write the files below `folder`, as they lay about the scenario; the path of the scenario there."""
        up = max(sum(part == ".." for part in PurePosixPath(name).parts) for name in self.files)
        home = folder.joinpath(*(["s"] * up))
        for name, content in self.files.items():
            target = home / name
            target.resolve().parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)
        return home / self.scenario


def read_document(path: Path) -> dict[str, Any]:
    """The TOML of a scenario. Raises UsageError, naming the file."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise UsageError(f"{path}: cannot read the scenario ({error}): check name and syntax") from error


def pack(path: Path, seed: int | None, bands: tuple[str, ...]) -> Bundle:
    """The scenario file and every file beside it that one of its values names. Raises UsageError."""
    document = read_document(path)
    folder = path.parent
    files = {path.name: path.read_bytes()}
    for name in (INSTRUMENT, *_texts(document)):
        if not PurePosixPath(name).is_absolute() and _is_file(folder / name):
            files[name] = (folder / name).read_bytes()
    return Bundle(path.name, files, {band: read_tables(document, folder, band) for band in bands}, seed)


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict | list):
        for part in value.values() if isinstance(value, dict) else value:
            yield from _texts(part)


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a text too long for a name
        return False


class Unpacked:
    """A bundle's files in a folder of their own, as long as this object lives."""

    def __init__(self, bundle: Bundle) -> None:
        self._folder = TemporaryDirectory(prefix="gonio-")
        self.scenario = bundle.unpack(Path(self._folder.name))
