"""exchange.py: commands between a dataset and the files of other programs: export, import."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from gonio.cli.options import Front, OutputOption
from gonio.cli.places import check_inputs, check_outputs


class ExportFormat(StrEnum):
    """What export can write."""

    KLEMS_FULL = "klems-full"
    CSV = "csv"


class Fill(StrEnum):
    """What stands in patches that were not measured."""

    NONE = "none"
    NEAREST = "nearest"


def register(app: typer.Typer) -> None:
    """Add the commands of this module."""
    app.command("export")(export)
    app.command("import")(import_points)


def export(
    file: Annotated[Path, typer.Argument(metavar="BSDF.h5", help="What reduce wrote.")],
    *,
    kind: Annotated[
        ExportFormat, typer.Option("--format", help="klems-full: WINDOW XML for WINDOW and Radiance. csv: all points.")
    ],
    output: OutputOption,
    channel: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Channel to write; klems-full: as visible, unless it is called solar."),
    ] = None,
    front: Annotated[
        Front | None, typer.Option(help="klems-full: side that the front faces; goes before what the dataset says.")
    ] = None,
    fill: Annotated[
        Fill,
        typer.Option(
            help="klems-full: incident patches without a measurement are zero or take the nearest measured theta_i."
        ),
    ] = Fill.NONE,
    assume_flat: Annotated[
        bool,
        typer.Option(
            "--assume-flat",
            help="klems-full: the sample scatters all wavelengths alike; copies the one measured block (visible or "
            "solar) to the other, recorded in <Comments>.",
        ),
    ] = False,
) -> None:
    """Write a dataset for another program. What was filled, copied or left at zero is said on standard error."""
    from gonio.dataset.nexus import read_dataset

    check_inputs(file)
    check_outputs(output, inputs=[file])
    dataset = read_dataset(file)
    if kind is ExportFormat.CSV:
        from gonio.formats import csv_points

        csv_points.write(dataset, output, channel=channel)
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
        )
        for remark in written.remarks():
            typer.echo(f"gonio: {remark}", err=True)
    typer.echo(output)


def import_points(
    file: Annotated[Path, typer.Argument(metavar="FILE.csv", help="BRDF table as NIST publishes it.")],
    output: OutputOption,
) -> None:
    """Read measured points of another instrument into a dataset; then reduce it."""
    from gonio.dataset.nexus import write_dataset
    from gonio.formats import nist_csv

    check_inputs(file)
    check_outputs(output, inputs=[file])
    write_dataset(nist_csv.read(file), output)
    typer.echo(output)
