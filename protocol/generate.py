"""generate.py: writes the C and Python forms of records.toml, and the schema hash both sides compare."""

import argparse
import hashlib
import tomllib
from pathlib import Path

HERE = Path(__file__).parent
SCHEMA_FILES = ("gonio.proto", "gonio.options", "records.toml")
TYPES = {  # record type: (C type, numpy type, bytes)
    "u8": ("uint8_t", "u1", 1),
    "u16": ("uint16_t", "<u2", 2),
    "u32": ("uint32_t", "<u4", 4),
    "u64": ("uint64_t", "<u8", 8),
    "i16": ("int16_t", "<i2", 2),
    "i32": ("int32_t", "<i4", 4),
    "i64": ("int64_t", "<i8", 8),
    "f32": ("float", "<f4", 4),
    "f64": ("double", "<f8", 8),
}


def schema_hash() -> int:
    """First eight bytes of SHA-256 over the schema files (line ends and comments included), big-endian."""
    digest = hashlib.sha256()
    for name in SCHEMA_FILES:
        digest.update(name.encode() + b"\0" + (HERE / name).read_bytes() + b"\0")
    return int.from_bytes(digest.digest()[:8], "big")


def parse_field(text: str) -> tuple[str, int, str]:
    """Split "i32[4]: what it is" into type, array length (0 for a scalar) and description."""
    kind, _, doc = text.partition(":")
    base, _, rest = kind.strip().partition("[")
    length = int(rest.rstrip("]")) if rest else 0
    if base not in TYPES:
        raise SystemExit(f"records.toml: unknown type {base!r} in {text!r}")
    return base, length, doc.strip()


def fields_of(name: str, table: dict) -> list[tuple[str, str, int, str]]:
    """Fields of one record as (name, type, array length, description); checks the stated size."""
    fields = [(key, *parse_field(text)) for key, text in table.items() if key not in ("doc", "size")]
    size = sum(TYPES[base][2] * max(length, 1) for _, base, length, _ in fields)
    if size != table["size"]:
        raise SystemExit(f"records.toml: [{name}] says {table['size']} bytes, its fields take {size}")
    return fields


def c_header(schema: dict) -> str:
    lines = [
        "/* gonio_records.h: generated from protocol/records.toml by protocol/generate.py. */",
        "#ifndef GONIO_RECORDS_H",
        "#define GONIO_RECORDS_H",
        "#include <stdint.h>",
        "",
        f"#define GN_SCHEMA_HASH UINT64_C(0x{schema_hash():016x})",
        "",
    ]
    for name, table in schema.items():
        if table.get("constants"):
            prefix = "GN_" + {"frame_kinds": "FRAME"}.get(name, name.removesuffix("_flags").upper())
            lines += [f"#define {prefix}_{key} {value}u" for key, value in table.items() if key != "constants"]
            lines.append("")
            continue
        lines += [f"/* {table['doc']} */", f"struct __attribute__((packed)) gn_{name} {{"]
        for key, base, length, doc in fields_of(name, table):
            array = f"[{length}]" if length else ""
            lines.append(f"    {TYPES[base][0]} {key}{array}; /* {doc} */")
        lines += ["};", f"#define GN_{name.upper()}_SIZE {table['size']}u"]
        lines += ["#ifndef __cplusplus", f'_Static_assert(sizeof(struct gn_{name}) == {table["size"]}, "gn_{name}");']
        lines += ["#endif", ""]
    lines += ["#endif", ""]
    return "\n".join(lines)


def python_module(schema: dict) -> str:
    lines = [
        '"""records.py: generated from protocol/records.toml by protocol/generate.py."""',
        "",
        "import numpy as np",
        "",
        f"SCHEMA_HASH = 0x{schema_hash():016X}",
    ]
    for name, table in schema.items():
        if table.get("constants"):
            prefix = {"frame_kinds": "FRAME"}.get(name, name.removesuffix("_flags").upper())
            lines += [""] + [f"{prefix}_{key} = {value}" for key, value in table.items() if key != "constants"]
            continue
        lines += ["", f"{name.upper()}_DTYPE = np.dtype(", "    ["]
        for key, base, length, doc in fields_of(name, table):
            shape = f", ({length},)" if length else ""
            lines.append(f'        ("{key}", "{TYPES[base][1]}"{shape}),  # {doc}')
        lines += ["    ]", ")"]
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--c", type=Path, help="C header to write")
    parser.add_argument("--python", type=Path, help="Python module to write")
    arguments = parser.parse_args()
    schema = tomllib.loads((HERE / "records.toml").read_text())
    for target, text in ((arguments.c, c_header), (arguments.python, python_module)):
        if target:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text(schema))


if __name__ == "__main__":
    main()
