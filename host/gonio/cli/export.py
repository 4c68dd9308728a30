"""export.py: export: a dataset or a model written for other programs."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gonio.cli.options import Front
from gonio.cli.places import check_inputs, check_outputs
from gonio.cli.saying import say
from gonio.units.errors import UsageError

if TYPE_CHECKING:
    from gonio.dataset.bsdf import Dataset


class ExportFormat(StrEnum):
    """What export can write."""

    KLEMS_FULL = "klems-full"
    KLEMS_HALF = "klems-half"
    KLEMS_QUARTER = "klems-quarter"
    CSV = "csv"
    PAB = "pab"
    NIST = "nist"


class Fill(StrEnum):
    """What stands in patches that were not measured."""

    NONE = "none"
    NEAREST = "nearest"


def register(app: typer.Typer) -> None:
    """Add the command of this module."""
    app.command("export")(export)


def export(
    file: Annotated[Path, typer.Argument(metavar="BSDF.h5", help="What reduce wrote.")],
    *,
    kind: Annotated[
        ExportFormat,
        typer.Option(
            "--format",
            help="klems-full, klems-half, klems-quarter: WINDOW XML for WINDOW and Radiance. csv: all points. pab: "
            "text for Radiance's pabopto2bsdf, one file per incident direction and pair of hemispheres. nist: table of "
            "the BRDF in reflection.",
        ),
    ],
    output: Annotated[
        Path,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE",
            help="Written whole or not at all; replaces an older file. pab: a folder, made if missing, or NAME.txt, "
            "with which all names begin.",
        ),
    ],
    channel: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Channel to write; klems: as visible, unless it is called solar."),
    ] = None,
    front: Annotated[
        Front | None, typer.Option(help="klems, pab: side that the front faces; goes before what the dataset says.")
    ] = None,
    fill: Annotated[
        Fill,
        typer.Option(
            help="klems: incident patches without a measurement are zero or take the nearest measured theta_i."
        ),
    ] = Fill.NONE,
    assume_flat: Annotated[
        bool,
        typer.Option(
            "--assume-flat",
            help="klems: the sample scatters all wavelengths alike; copies the one measured block (visible or "
            "solar) to the other, recorded in <Comments>.",
        ),
    ] = False,
    uncertainty: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.csv",
            help="klems: also write every patch's standard uncertainty (k = 1) and its correlated parts by effect.",
        ),
    ] = None,
) -> None:
    """Write a dataset for another program. What was filled, copied or left out is said on standard error."""
    from gonio.dataset.nexus import read_dataset

    klems = kind.value.startswith("klems-")
    if uncertainty is not None and not klems:
        raise UsageError(f"--uncertainty goes with a klems format: {kind.value} has none; leave it away")
    check_inputs(file)
    check_outputs(*([] if kind is ExportFormat.PAB else [output]), uncertainty, inputs=[file])
    dataset = read_dataset(file)
    if kind is ExportFormat.PAB:
        _export_pab(dataset, file, output, channel, front)
        return
    if kind is ExportFormat.CSV:
        from gonio.formats import csv_points

        csv_points.write(dataset, output, channel=channel)
    elif kind is ExportFormat.NIST:
        from gonio.formats import nist_csv

        _, left_out = nist_csv.write(dataset, output, channel=channel)
        if left_out:
            say(f"{left_out} points left out: masked, in transmission or at grazing.")
    else:
        from gonio.formats import window_xml

        written = window_xml.write(
            dataset,
            output,
            basis=kind.value,
            front=None if front is None else front.value,
            fill=fill.value,
            assume_flat=assume_flat,
            channel=channel,
            uncertainty=uncertainty,
        )
        say(*written.remarks())
    typer.echo(output)
    if uncertainty is not None:
        typer.echo(uncertainty)


def _export_pab(dataset: "Dataset", file: Path, output: Path, channel: str | None, front: Front | None) -> None:
    from gonio.formats import pab_write

    if not output.is_dir():
        check_outputs(output, inputs=[file])
    written = pab_write.write(dataset, output, front=None if front is None else front.value, channel=channel)
    say(*written.remarks)
    for path in written.paths:
        typer.echo(path)
