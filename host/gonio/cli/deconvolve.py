"""deconvolve.py: the command deconvolve: beam and aperture taken out of what was measured about a direction."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from gonio.cli.options import OutputOption
from gonio.cli.places import check_inputs, check_outputs


class About(StrEnum):
    """The direction, ideal for each incident direction."""

    MIRROR = "mirror"
    THROUGH = "through"


def register(app: typer.Typer) -> None:
    """Add the command of this module."""
    app.command("deconvolve")(deconvolve)


def deconvolve(
    file: Annotated[Path, typer.Argument(metavar="BSDF.h5", help="What reduce wrote, the free beam in it.")],
    output: OutputOption,
    about: Annotated[About, typer.Option(help="The peak's direction.")] = About.MIRROR,
    radius: Annotated[
        float, typer.Option(metavar="DEG", help="Of the disc; the peak and its feet should lie within.")
    ] = 4.0,
) -> None:
    """Take the measured beam out of a peak; the noise that this costs is in the file, and printed.

    The result holds the disc alone, on a grid; neighbours are correlated. The measurement itself stays as it is.
    """
    from gonio.dataset.nexus import read_dataset, write_dataset
    from gonio.reduce.signature.sharpened import sharpened

    check_inputs(file)
    check_outputs(output, inputs=[file])
    dataset = sharpened(read_dataset(file), about.value, radius)
    for record in dataset.provenance["deconvolved"]:
        noise, hidden = record["height_noise_per_sr"], record["height_smoothing_per_sr"]
        typer.echo(
            f"gonio: incident {record['incident']}: height {record['height_per_sr']:.5g} 1/sr, noise {noise:.2g}, "
            f"smoothing {hidden:.2g} (k = 1), misfit {record['misfit']:.2f} of the noise",
            err=True,
        )
    write_dataset(dataset, output)
    typer.echo(output)
