"""material.py: a file of Radiance with the materials that use a BSDF file."""

import re
from pathlib import Path


def material_text(xml: Path, *, view_through: bool) -> bytes:
    """Radiance scene text, UTF-8. A BSDF; where light goes straight through also an aBSDF, which keeps views sharp."""
    name = re.sub(r"[^A-Za-z0-9_]", "_", xml.stem) or "sample"
    lines = [
        f"# How to use {xml.name}. A surface's normal points into the room (Radiance's +z of the BSDF);",
        "# the three numbers behind the file are its up direction, here z: where a surface lies, its normal is z, take",
        "# another. BSDF has a thickness before the file: 0 is none.",
        "",
        f"void BSDF {name}",
        f"6 0 {xml.name} 0 0 1 .",
        "0",
        "0",
    ]
    if view_through:
        lines += [
            "",
            "# Light that passes straight through stays sharp: for view through the sample and for the sun's shadows.",
            f"void aBSDF {name}_seen_through",
            f"5 {xml.name} 0 0 1 .",
            "0",
            "0",
        ]
    return ("\n".join(lines) + "\n").encode()
