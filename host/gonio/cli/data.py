"""data.py: commands on files: reduce, export, import, validate, report."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

import json
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from gonio.cli.device import JsonOption
from gonio.cli.places import check_inputs, check_outputs

OutputOption = Annotated[
    Path, typer.Option("-o", "--output", metavar="FILE", help="Written whole or not at all; replaces an older file.")
]


class ExportFormat(StrEnum):
    """What export can write."""

    KLEMS_FULL = "klems-full"
    CSV = "csv"


class Front(StrEnum):
    """Which way the sample's front faces, where the dataset does not say."""

    EXTERIOR = "exterior"
    INTERIOR = "interior"


class Fill(StrEnum):
    """What stands in patches that were not measured."""

    NONE = "none"
    NEAREST = "nearest"


class Profile(StrEnum):
    """Who is to read the file."""

    WINDOW = "window"
    RADIANCE = "radiance"


def register(app: typer.Typer) -> None:
    """Add the commands of this module."""
    app.command("reduce")(reduce)
    app.command("export")(export)
    app.command("import")(import_points)
    app.command("validate")(validate)
    app.command("report")(report)


def reduce(
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILE...", help="Raw logs (.mcap) of one scan, or one dataset that import wrote."),
    ],
    output: OutputOption,
) -> None:
    """Turn the raw log of a scan, or imported points, into a BSDF dataset.

    A scan that was resumed has several raw logs: name all of them in order, or the first one alone.
    """
    from gonio.dataset.nexus import read_dataset, write_dataset
    from gonio.rawlog.reader import read_rawlog
    from gonio.rawlog.segments import SUFFIX, existing_segments
    from gonio.reduce.pipeline import ReduceOptions, reduce_dataset, reduce_rawlog
    from gonio.units.errors import UsageError

    check_inputs(*files)
    check_outputs(output, inputs=files)
    if all(file.suffix == SUFFIX for file in files):
        paths = files
        if len(files) == 1 and len(existing_segments(files[0])) > 1:
            paths = existing_segments(files[0])
            typer.echo(f"gonio: {files[0]}: {len(paths)} segments of this scan are joined", err=True)
        log = read_rawlog(paths)
        if log.damaged:
            raise UsageError(f"{log.problem}; the file is damaged and not reduced")
        if log.problem:
            typer.echo(f"gonio: {log.problem}; continuing with them", err=True)
        dataset = reduce_rawlog(log, ReduceOptions())
    elif len(files) == 1:
        dataset = reduce_dataset(read_dataset(files[0]))
    else:
        raise UsageError("reduce takes the raw logs of one scan, or one dataset of imported points")
    write_dataset(dataset, output)
    typer.echo(output)


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


def validate(
    file: Annotated[Path, typer.Argument(metavar="FILE.xml")],
    profile: Annotated[
        Profile, typer.Option(help="Whose rules: WINDOW wants every field and matrix, Radiance what it loads.")
    ] = Profile.WINDOW,
    as_json: JsonOption = False,
) -> None:
    """Check a WINDOW XML file with Klems matrices: schema, fields, values, energy.

    Exit status: 0 good (there may be notes), 1 errors or warnings, 2 unreadable.
    """
    from gonio.formats.validate import validate as check

    check_inputs(file)
    findings = check(file, profile.value)
    typer.echo(json.dumps(findings.as_json()) if as_json else findings.text())
    raise typer.Exit(findings.exit_status)


def report(
    file: Annotated[Path, typer.Argument(metavar="BSDF.h5", help="What reduce wrote.")],
    output: OutputOption,
    scenario: Annotated[
        Path | None, typer.Option(metavar="SCENARIO.toml", help="Show the truth of this simulated sample beside it.")
    ] = None,
    summary: Annotated[
        Path | None,
        typer.Option(metavar="FILE.json", help="Also write integrals and peaks as JSON: measured, truth, differences."),
    ] = None,
) -> None:
    """Write a self-contained HTML report."""
    from gonio.dataset.nexus import read_dataset
    from gonio.report.html import write_report

    check_inputs(file, scenario)
    check_outputs(output, summary, inputs=[file, scenario])
    dataset = read_dataset(file)
    truth = None
    if scenario:
        from gonio.simulate.closed_form import Truth

        truth = Truth.from_scenario(scenario)
    write_report(dataset, output, truth=truth)
    if summary:
        from gonio.report.summary import write_summary

        write_summary(dataset, summary, truth=truth)
    typer.echo(output)
