"""xml_guard.py: parses foreign XML without entities, document types, deep nesting or oversized files."""

import xml.etree.ElementTree as ET
from pathlib import Path
from xml.parsers import expat

from gonio.units.errors import UsageError

MAX_BYTES = 64 * 2**20
MAX_DEPTH = 32
_BYTE_ORDER_MARKS = (b"\xff\xfe", b"\xfe\xff", b"\xef\xbb\xbf")


def read_limited(path: Path, max_bytes: int | None = None) -> bytes:
    """Content of a file, UsageError when it is missing, no file or larger than `max_bytes` (MAX_BYTES)."""
    max_bytes = max_bytes or MAX_BYTES
    try:
        with path.open("rb") as file:
            content = file.read(max_bytes + 1)
    except OSError as error:
        raise UsageError(f"{path}: cannot be read, {error.strerror}: check name and rights") from error
    if len(content) > max_bytes:
        raise UsageError(f"{path}: larger than {max_bytes // 2**20} MiB and not read: is it the right file?")
    return content


def parse(content: bytes, name: str) -> tuple[ET.Element, int]:
    """Root element, tags as `{namespace}local`, and the number of stray bytes found before the first `<`.

    Raises UsageError for anything that is not one well-formed document within the limits.
    """
    stray = 0
    if not content.startswith(_BYTE_ORDER_MARKS):
        start = content.find(b"<?xml")
        start = start if 0 < start < 4096 else content.find(b"<")
        stray = max(start, 0)
    builder = ET.TreeBuilder()
    depth = 0

    def begin(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > MAX_DEPTH:
            raise UsageError(f"{name}: elements are nested deeper than {MAX_DEPTH}; this is no WINDOW file")
        builder.start(_clark(tag), {_clark(key): value for key, value in attributes.items()})

    def finish(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(_clark(tag))

    def refuse(*_: object) -> None:
        raise UsageError(f"{name}: document types and entities are not accepted; remove the <!DOCTYPE ...>")

    try:
        parser = expat.ParserCreate(namespace_separator="}")
        parser.buffer_text = True
        parser.StartElementHandler = begin
        parser.EndElementHandler = finish
        parser.CharacterDataHandler = builder.data
        parser.StartDoctypeDeclHandler = refuse
        parser.Parse(content[stray:], True)
        return builder.close(), stray
    except expat.ExpatError as error:
        raise UsageError(f"{name}: not readable as XML, {error}; cut off, damaged or something else?") from error
    except (ValueError, LookupError, AssertionError) as error:  # unknown encodings, names that Python cannot hold
        raise UsageError(f"{name}: not readable as XML, {error}") from error


def _clark(name: str) -> str:
    return "{" + name if "}" in name else name


def local(element: ET.Element) -> str:
    """Tag without namespace."""
    return element.tag.rpartition("}")[2]


def children(element: ET.Element, name: str) -> list[ET.Element]:
    """Direct children of that local name, in any namespace."""
    return [child for child in element if local(child) == name]


def child(element: ET.Element, name: str) -> ET.Element | None:
    found = children(element, name)
    return found[0] if found else None


def text_of(element: ET.Element | None, name: str) -> str:
    """Text of a direct child, whitespace collapsed; empty when there is none."""
    found = None if element is None else child(element, name)
    return " ".join((found.text or "").split()) if found is not None else ""
