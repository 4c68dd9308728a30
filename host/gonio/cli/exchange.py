"""exchange.py: commands between a dataset and the files of other programs: export, import."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gonio.cli.options import Front, OutputOption
from gonio.cli.places import check_inputs, check_outputs
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


class ImportFormat(StrEnum):
    """What import can read."""

    AUTO = "auto"
    PAB = "pab"
    NIST = "nist"
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
            _say(f"{left_out} points left out: masked, in transmission or at grazing.")
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
        _say(*written.remarks())
    typer.echo(output)
    if uncertainty is not None:
        typer.echo(uncertainty)


def _export_pab(dataset: "Dataset", file: Path, output: Path, channel: str | None, front: Front | None) -> None:
    from gonio.formats import pab_write

    if not output.is_dir():
        check_outputs(output, inputs=[file])
    written = pab_write.write(dataset, output, front=None if front is None else front.value, channel=channel)
    _say(*written.remarks)
    for path in written.paths:
        typer.echo(path)


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
        _say(*pab_dataset.remarks(dataset))
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


def _say(*remarks: str) -> None:
    for remark in remarks:
        typer.echo(f"gonio: {remark}", err=True)
