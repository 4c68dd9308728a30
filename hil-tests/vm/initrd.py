"""initrd.py: the initial root of the virtual machine: static busybox, the init script, and what a lane preloads."""

import gzip
import re
import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path

HERE = Path(__file__).resolve().parent
_FOLDERS = ("bin", "dev", "proc", "sys", "run", "tmp", "host")
_LIBRARY = re.compile(r"(?:=> )?(/\S+) \(0x[0-9a-f]+\)")


class InitrdError(Exception):
    """The initial root cannot be made; the text says what to do."""


def initrd(preload: Iterable[Path] = (), start: str | None = None) -> bytes:
    """A gzipped cpio archive (newc). `preload`: files, at their own paths; programs bring their libraries."""
    busybox = shutil.which("busybox")
    if busybox is None:
        raise InitrdError("the virtual machine needs busybox: apt install busybox-static")
    archive = _Archive()
    for folder in _FOLDERS:
        archive.folder(folder)
    archive.file("bin/busybox", Path(busybox).read_bytes(), 0o755)
    archive.file("init", (HERE / "init.sh").read_bytes(), 0o755)
    if start is not None:
        archive.file("start.sh", start.encode(), 0o755)
    for path in _with_libraries(preload):
        archive.file(str(path).lstrip("/"), path.read_bytes(), path.stat().st_mode & 0o777)
    return gzip.compress(archive.end(), compresslevel=1, mtime=0)


def _with_libraries(files: Iterable[Path]) -> list[Path]:
    found: dict[Path, None] = {}
    for path in files:
        found[path] = None
        if path.read_bytes()[:4] == b"\x7fELF":
            said = subprocess.run(["ldd", str(path)], capture_output=True, text=True, check=False).stdout
            if "not found" in said:
                raise InitrdError(f"{path}: a library is missing: {said.strip()}")
            found.update((Path(name), None) for name in _LIBRARY.findall(said))
    return list(found)


class _Archive:
    """cpio, format newc: numbers as eight hexadecimal digits, names and contents padded to four bytes."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._inode = 0
        self._folders: set[str] = set()

    def folder(self, name: str) -> None:
        """A directory and those above it, once."""
        for depth in range(1, name.count("/") + 2):
            part = "/".join(name.split("/")[:depth])
            if part and part not in self._folders:
                self._folders.add(part)
                self._entry(part, b"", 0o040755)

    def file(self, name: str, content: bytes, mode: int) -> None:
        """A regular file."""
        if "/" in name:
            self.folder(name.rsplit("/", 1)[0])
        self._entry(name, content, 0o100000 | mode)

    def end(self) -> bytes:
        """The whole archive."""
        self._entry("TRAILER!!!", b"", 0)
        return b"".join(self._parts)

    def _entry(self, name: str, content: bytes, mode: int) -> None:
        self._inode += 1
        encoded = name.encode() + b"\0"
        fields = (self._inode, mode, 0, 0, 1, 0, len(content), 0, 0, 0, 0, len(encoded), 0)
        head = b"070701" + b"".join(b"%08X" % field for field in fields) + encoded
        self._parts += [head, b"\0" * (-len(head) % 4), content, b"\0" * (-len(content) % 4)]
