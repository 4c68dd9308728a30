"""importing.py: import: files of other programs and instruments to one dataset."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from gonio.cli.options import OutputOption
from gonio.cli.places import check_inputs, check_outputs
from gonio.cli.saying import say
from gonio.units.errors import UsageError


class ImportFormat(StrEnum):
    """What import can read."""

    AUTO = "auto"
    PAB = "pab"
    NIST = "nist"
    CSV = "csv"


def register(app: typer.Typer) -> None:
    """Add the command of this module."""
    app.command("import")(import_points)


def import_points(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE...", help="Points; of pab text all files of one sample together.")
    ],
    *,
    output: OutputOption,
    kind: Annotated[
        ImportFormat,
        typer.Option(
            "--format",
            help="auto: by content. pab: text of pab goniophotometers. nist: BRDF table as NIST publishes it. csv: "
            "columns theta_i_deg, phi_i_deg, theta_s_deg, phi_s_deg, dsf_per_sr or bsdf_per_sr.",
        ),
    ] = ImportFormat.AUTO,
    p_i: Annotated[
        float | None,
        typer.Option("--p-i", metavar="VALUE", help="pab, raw signal: P_i of the beam, in the signal's unit times sr."),
    ] = None,
    beam: Annotated[
        Path | None,
        typer.Option("--beam", metavar="FILE", help="pab, raw signal: scan of the free beam that gives P_i."),
    ] = None,
    sample_name: Annotated[
        str | None, typer.Option("--sample-name", metavar="NAME", help="Goes before what the files say.")
    ] = None,
) -> None:
    """Read measured points of another instrument into a dataset; then reduce it."""
    from gonio.dataset.nexus import write_dataset
    from gonio.formats.detect import point_format

    check_inputs(*files, beam)
    check_outputs(output, inputs=[*files, beam])
    if p_i is not None and beam is not None:
        raise UsageError("--p-i and --beam both state P_i: give one of them")
    found = {point_format(file) if kind is ImportFormat.AUTO else kind.value for file in files}
    if len(found) > 1:
        raise UsageError(f"the files have different formats ({', '.join(sorted(found))}): import them one by one")
    chosen = found.pop()
    if chosen == "pab":
        from gonio.formats import pab_dataset

        dataset = pab_dataset.read(files, p_i=p_i, beam=beam)
        say(*pab_dataset.remarks(dataset))
    else:
        from gonio.formats import csv_read, nist_csv

        if len(files) > 1:
            raise UsageError(f"{files[1]}: only pab text is several files of one dataset: import one table at a time")
        if p_i is not None or beam is not None:
            raise UsageError(f"{files[0]}: a {chosen} table is normalised already: leave --p-i and --beam away")
        dataset = nist_csv.read(files[0]) if chosen == "nist" else csv_read.read(files[0])
    if sample_name is not None:
        dataset.sample_name = sample_name
    write_dataset(dataset, output)
    typer.echo(output)
