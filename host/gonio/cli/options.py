"""options.py: options that several commands share."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

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
