"""importing.py: import: files of other programs and instruments to one dataset."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gonio.cli.options import Front, OutputOption, angles
from gonio.cli.places import check_inputs, check_outputs
from gonio.cli.saying import say
from gonio.units.errors import UsageError

if TYPE_CHECKING:
    from gonio.dataset.bsdf import Dataset, Side


class ImportFormat(StrEnum):
    """What import can read."""

    AUTO = "auto"
    PAB = "pab"
    NIST = "nist"
    CSV = "csv"
    WINDOW = "window"
    TENSOR = "tensor"


_XML = (ImportFormat.WINDOW.value, ImportFormat.TENSOR.value)


def register(app: typer.Typer) -> None:
    """Add the command of this module."""
    app.command("import")(import_points)


def import_points(
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILE...", help="Points or BSDF XML; of pab text all files of one sample together."),
    ],
    *,
    output: OutputOption,
    kind: Annotated[
        ImportFormat,
        typer.Option(
            "--format",
            help="auto: by content. pab: text of pab goniophotometers. nist: BRDF table as NIST publishes it. csv: "
            "columns theta_i_deg, phi_i_deg, theta_s_deg, phi_s_deg, dsf_per_sr or bsdf_per_sr. window: XML with Klems "
            "matrices, a distribution per incident patch. tensor: XML with a tensor tree, at --incident directions.",
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
    incident: Annotated[
        list[str] | None,
        typer.Option(
            metavar="THETA,PHI",
            help="tensor: incident direction; may be repeated. Default: every 10 degrees of theta_i from both sides, "
            "for a tree without symmetry every 45 degrees of phi_i too.",
        ),
    ] = None,
    front: Annotated[
        Front | None,
        typer.Option(help="window, tensor: side that the sample's front faces; goes before what the file says."),
    ] = None,
    sample_name: Annotated[
        str | None, typer.Option("--sample-name", metavar="NAME", help="Goes before what the files say.")
    ] = None,
) -> None:
    """Read measured points of another instrument, or a BSDF file, into a dataset. Points are then reduced."""
    from gonio.dataset.nexus import write_dataset

    check_inputs(*files, beam)
    check_outputs(output, inputs=[*files, beam])
    if p_i is not None and beam is not None:
        raise UsageError("--p-i and --beam both state P_i: give one of them")
    found = {_format(file) if kind is ImportFormat.AUTO else kind.value for file in files}
    if len(found) > 1:
        raise UsageError(f"the files have different formats ({', '.join(sorted(found))}): import them one by one")
    chosen = found.pop()
    if chosen not in _XML and front is not None:
        raise UsageError(f"{files[0]}: --front is for XML: other files say it themselves or not at all; leave it away")
    if chosen != ImportFormat.TENSOR.value and incident:
        raise UsageError(f"{files[0]}: --incident is for a tensor tree: leave it away")
    if chosen in _XML:
        if len(files) > 1 or p_i is not None or beam is not None:
            raise UsageError(f"{files[0]}: of BSDF XML one file at a time is imported, without --p-i and --beam")
        dataset = _from_xml(files[0], chosen, None if front is None else front.value, incident)
    elif chosen == "pab":
        from gonio.formats.pab import dataset as pab_dataset

        dataset = pab_dataset.read(files, p_i=p_i, beam=beam)
        say(*pab_dataset.remarks(dataset))
    else:
        from gonio.formats.tables import csv_read
        from gonio.formats.tables import nist as nist_csv

        if len(files) > 1:
            raise UsageError(f"{files[1]}: only pab text is several files of one dataset: import one table at a time")
        if p_i is not None or beam is not None:
            raise UsageError(f"{files[0]}: a {chosen} table is normalised already: leave --p-i and --beam away")
        dataset = nist_csv.read(files[0]) if chosen == "nist" else csv_read.read(files[0])
    if sample_name is not None:
        dataset.sample_name = sample_name
    write_dataset(dataset, output)
    typer.echo(output)


def _format(file: Path) -> str:
    from gonio.formats.detect import beginning_of, looks_like_xml, point_format
    from gonio.formats.tensor.read import is_tensor

    if not looks_like_xml(beginning_of(file)):
        return point_format(file)
    return ImportFormat.TENSOR.value if is_tensor(file) else ImportFormat.WINDOW.value


def _from_xml(file: Path, chosen: str, front: "Side | None", incident: list[str] | None) -> "Dataset":
    """With integrals: the cells are the file's own, there is nothing to reduce."""
    from gonio.reduce.integrals.hemispheres import evaluated

    if chosen == ImportFormat.WINDOW.value:
        from gonio.formats.window import dataset as window_dataset

        dataset, remarks = window_dataset.read_dataset(file, front)
    else:
        from gonio.formats.tensor import dataset as tree_dataset

        dataset, remarks = tree_dataset.read_dataset(file, front, [angles(text) for text in incident or []] or None)
    for distribution in dataset.distributions:
        evaluated(distribution).into(distribution)
    say(*remarks)
    return dataset
