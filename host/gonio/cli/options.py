"""options.py: options that several commands share."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from gonio.units.errors import UsageError

OutputOption = Annotated[
    Path, typer.Option("-o", "--output", metavar="FILE", help="Written whole or not at all; replaces an older file.")
]

Resolution = Annotated[
    int | None,
    typer.Option(
        min=2,
        max=9,
        help="tensor: finest cells are 2^-resolution of an axis; default: tensor3 7, tensor4 5.",
        show_default=False,
    ),
]


class Front(StrEnum):
    """Which way the sample's front faces, where the dataset does not say."""

    EXTERIOR = "exterior"
    INTERIOR = "interior"


class DeclaredSymmetry(StrEnum):
    """What the user may declare of the sample."""

    ISOTROPIC = "isotropic"
    BILATERAL = "bilateral"
    QUADRILATERAL = "quadrilateral"
    UP = "up"
    NONE = "none"


def angles(text: str) -> tuple[float, float]:
    """THETA,PHI in degrees, phi folded to 0-360. UsageError for anything else."""
    try:
        theta, phi = (float(part) for part in text.split(","))
    except ValueError:
        raise UsageError(f"{text[:40]!r} is no direction: give THETA,PHI in degrees, such as 30,180") from None
    if not (0.0 <= theta <= 180.0 and abs(phi) <= 720.0):
        raise UsageError(f"{text[:40]!r} is no direction: theta goes from 0 to 180, phi from 0 to 360 degrees")
    return theta, phi % 360.0
