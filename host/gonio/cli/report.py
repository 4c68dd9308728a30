"""report.py: commands that judge and show: validate, report."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

import json
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from gonio.cli.device import JsonOption
from gonio.cli.places import check_inputs, check_outputs


class Profile(StrEnum):
    """Who is to read the file."""

    WINDOW = "window"
    RADIANCE = "radiance"


def register(app: typer.Typer) -> None:
    """Add the commands of this module."""
    app.command("validate")(validate)
    app.command("report")(report)


def validate(
    file: Annotated[Path, typer.Argument(metavar="FILE.xml")],
    profile: Annotated[
        Profile, typer.Option(help="Whose rules: WINDOW wants every field and matrix, Radiance what it loads.")
    ] = Profile.WINDOW,
    as_json: JsonOption = False,
) -> None:
    """Check BSDF XML, Klems matrices or a tensor tree: schema, units, sides, basis, sums, negative values, reciprocity.

    Exit status: 0 good (there may be notes), 1 errors or warnings, 2 unreadable.
    """
    from gonio.formats.validate import validate as check

    check_inputs(file)
    findings = check(file, profile.value)
    typer.echo(json.dumps(findings.as_json()) if as_json else findings.text())
    raise typer.Exit(findings.exit_status)


def report(
    file: Annotated[Path, typer.Argument(metavar="BSDF.h5", help="What reduce wrote.")],
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE.html",
            help="The report; written whole or not at all, replaces an older one.",
        ),
    ] = None,
    scenario: Annotated[
        Path | None, typer.Option(metavar="SCENARIO.toml", help="Show the truth of this simulated sample beside it.")
    ] = None,
    summary: Annotated[
        Path | None,
        typer.Option(metavar="FILE.json", help="Also write integrals and peaks as JSON: measured, truth, differences."),
    ] = None,
    budget: Annotated[
        bool, typer.Option("--budget", help="Print the uncertainty budget also where a report is written.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the budget as one JSON object.")] = False,
) -> None:
    """Print the uncertainty budget, largest contribution first; write a self-contained HTML report."""
    from gonio.cli.sources import check_dataset
    from gonio.dataset.nexus import read_dataset

    check_inputs(file, scenario)
    check_outputs(output, summary, inputs=[file, scenario])
    check_dataset(file)
    dataset = read_dataset(file)
    truth = None
    if scenario:
        from gonio.simulate.closed_form import Truth

        truth = Truth.from_scenario(scenario)
    if output:
        from gonio.report.html import write_report

        write_report(dataset, output, truth=truth)
    if summary:
        from gonio.report.summary import write_summary

        write_summary(dataset, summary, truth=truth)
    if budget or as_json or not (output or summary):
        from gonio.report import budget as budgets

        typer.echo(json.dumps(budgets.as_json(dataset), allow_nan=False) if as_json else budgets.as_text(dataset))
    if not as_json:
        for written in (output, summary):
            if written:
                typer.echo(written)
