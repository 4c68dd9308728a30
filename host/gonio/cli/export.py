"""export.py: export: a dataset or a model written for other programs."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gonio.cli.exporting import ModelOptions, export_matrices, export_tree, points_of_model
from gonio.cli.options import DeclaredSymmetry, Front, Resolution
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
    TENSOR3 = "tensor3"
    TENSOR4 = "tensor4"
    CSV = "csv"
    PAB = "pab"
    NIST = "nist"


class Fill(StrEnum):
    """Where values of incident patches come from."""

    MODEL = "model"
    NONE = "none"
    NEAREST = "nearest"


def register(app: typer.Typer) -> None:
    """Add the command of this module."""
    app.command("export")(export)


def export(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="A dataset that reduce wrote, or a model that fit wrote.")
    ],
    *,
    kind: Annotated[
        ExportFormat,
        typer.Option(
            "--format",
            help="klems-full, klems-half, klems-quarter: WINDOW XML for WINDOW and Radiance. tensor3 (isotropic), "
            "tensor4: Radiance's tensor tree. csv: all points. pab: text for Radiance's pabopto2bsdf, one file per "
            "incident direction and pair of hemispheres. nist: table of the BRDF in reflection.",
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
        typer.Option(metavar="NAME", help="Channel to write; klems, tensor: as visible, unless it is called solar."),
    ] = None,
    front: Annotated[
        Front | None,
        typer.Option(help="klems, tensor, pab: side that the front faces; goes before what the file says."),
    ] = None,
    symmetry: Annotated[
        DeclaredSymmetry | None,
        typer.Option(help="klems, tensor: what is declared of the sample; before what the file says."),
    ] = None,
    fill: Annotated[
        Fill | None,
        typer.Option(
            help="klems: model (default): every cell is the average of the fitted model over both patches. none, "
            "nearest: averages of the measured points; other incident patches are zero or take the nearest theta_i."
        ),
    ] = None,
    assume_flat: Annotated[
        bool,
        typer.Option(
            "--assume-flat",
            help="klems, tensor: the sample scatters all wavelengths alike; copies the one measured block (visible or "
            "solar) to the other, recorded in <Comments>.",
        ),
    ] = False,
    uncertainty: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.csv",
            help="klems with --fill none or nearest: also write every patch's standard uncertainty (k = 1) and its "
            "correlated parts by effect.",
        ),
    ] = None,
    cells: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.csv",
            help="klems, tensor: also write every cell with its origin: measured, interpolated, extrapolated, absent.",
        ),
    ] = None,
    rescale: Annotated[
        bool,
        typer.Option(
            "--rescale", help="klems, tensor: where more light leaves than arrives, scale it to all, and record it."
        ),
    ] = False,
    solar_spectrum: Annotated[
        str | None,
        typer.Option(
            metavar="astm-g173|FILE.csv",
            help="klems, tensor: solar is the channels' mean, weighted by this spectrum of sunlight. A file has "
            "columns wavelength_nm and irradiance (any unit), or wavelength_nm and share.",
        ),
    ] = None,
    solar_band: Annotated[
        list[str] | None,
        typer.Option(metavar="CHANNEL=FROM-TO", help="Band of a channel in nm, where its name does not say it."),
    ] = None,
    xyz: Annotated[
        str | None,
        typer.Option(metavar="X=NAME,Y=NAME,Z=NAME", help="klems, tensor: colour from the channels of CIE X, Y and Z."),
    ] = None,
    resolution: Resolution = None,
    leaves: Annotated[int | None, typer.Option(min=1, help="tensor: most leaves of the file.")] = None,
    size_mb: Annotated[float | None, typer.Option(metavar="MB", help="tensor: most size of the file.")] = None,
    percent: Annotated[
        float | None, typer.Option(help="tensor: share of a full tree's leaves to take away, as Radiance's -t does.")
    ] = None,
    material: Annotated[
        Path | None, typer.Option(metavar="FILE.rad", help="tensor: also write the material that uses the file.")
    ] = None,
    incident: Annotated[
        list[str] | None,
        typer.Option(metavar="THETA,PHI", help="csv, pab, nist of a model: incident direction; default: the measured."),
    ] = None,
    step: Annotated[
        float | None, typer.Option(metavar="DEG", help="csv, pab, nist of a model: step of the grid; default 2.5.")
    ] = None,
) -> None:
    """Write a dataset or a model for another program. What was filled, copied or left out is said on standard error."""
    klems, tensor = kind.value.startswith("klems-"), kind.value.startswith("tensor")
    of_points = fill in (Fill.NONE, Fill.NEAREST)
    options = ModelOptions(
        channel,
        None if front is None else front.value,
        None if symmetry is None else symmetry.value,
        assume_flat,
        rescale,
        solar_spectrum,
        tuple(solar_band or ()),
        xyz,
        cells,
        resolution,
        leaves,
        size_mb,
        percent,
        material,
    )
    _check(kind, options, fill=fill, uncertainty=uncertainty, of_grid=bool(incident) or step is not None)
    check_inputs(file)
    check_outputs(*([] if kind is ExportFormat.PAB else [output]), uncertainty, cells, material, inputs=[file])
    if klems and not of_points:
        export_matrices(file, output, kind.value, options)
    elif tensor:
        export_tree(file, output, int(kind.value[-1]), options)
    elif klems:
        _export_measured(file, output, kind, options, fill=fill or Fill.NONE, uncertainty=uncertainty)
    else:
        _export_points(_points(file, incident or [], step, options), file, output, kind, options)


def _check(
    kind: ExportFormat, options: ModelOptions, *, fill: Fill | None, uncertainty: Path | None, of_grid: bool
) -> None:
    """UsageError for options that do not go together."""
    klems, tensor = kind.value.startswith("klems-"), kind.value.startswith("tensor")
    if uncertainty is not None and not klems:
        raise UsageError(f"--uncertainty goes with a klems format: {kind.value} has none; leave it away")
    if uncertainty is not None and fill in (None, Fill.MODEL):
        raise UsageError("--uncertainty is of averages of measured points: give --fill none or --fill nearest with it")
    if fill is not None and not klems:
        raise UsageError(f"--fill goes with a klems format: leave it away for {kind.value}")
    of_trees = {
        "--resolution": options.resolution,
        "--leaves": options.leaves,
        "--size-mb": options.size_mb,
        "--percent": options.percent,
        "--material": options.material,
    }
    of_models = {
        "--cells": options.cells,
        "--rescale": options.rescale or None,
        "--solar-spectrum": options.solar_spectrum,
        "--solar-band": options.solar_band or None,
        "--xyz": options.xyz,
        "--symmetry": options.symmetry,
    }
    for name, value in of_trees.items():
        if value is not None and not tensor:
            raise UsageError(f"{name} goes with tensor3 and tensor4: leave it away for {kind.value}")
    for name, given in of_models.items():
        if given is None:
            continue
        if klems and fill in (Fill.NONE, Fill.NEAREST):
            raise UsageError(f"{name} goes with --fill model: averages of measured points have none")
        if not klems and not tensor and name != "--symmetry":
            raise UsageError(f"{name} goes with klems and tensor formats: leave it away for {kind.value}")
    if of_grid and (klems or tensor):
        raise UsageError(
            f"--incident and --step go with csv, pab and nist of a model: leave them away for {kind.value}"
        )


def _points(file: Path, incident: list[str], step: float | None, options: ModelOptions) -> "Dataset":
    """Points of a dataset as they are; of a model on a grid, also where --incident or --step ask for it."""
    from gonio.cli.sources import kind_of
    from gonio.dataset.nexus import read_dataset

    if kind_of(file) == "dataset" and not incident and step is None:
        if options.symmetry is not None:
            raise UsageError("--symmetry goes with a fitted model: points are written as they are; leave it away")
        return read_dataset(file)
    return points_of_model(file, incident, step, options)


def _export_measured(
    file: Path, output: Path, kind: ExportFormat, options: ModelOptions, *, fill: Fill, uncertainty: Path | None
) -> None:
    from gonio.cli.sources import kind_of
    from gonio.dataset.nexus import read_dataset
    from gonio.formats.window import write as window_xml

    if kind_of(file) != "dataset":
        raise UsageError(f"{file}: is no dataset: --fill {fill.value} averages measured points; give --fill model")
    written = window_xml.write(
        read_dataset(file),
        output,
        basis=kind.value,
        front=options.front,
        fill=fill.value,  # type: ignore[arg-type]
        assume_flat=options.assume_flat,
        channel=options.channel,
        uncertainty=uncertainty,
    )
    say(*written.remarks())
    typer.echo(output)
    if uncertainty is not None:
        typer.echo(uncertainty)


def _export_points(dataset: "Dataset", file: Path, output: Path, kind: ExportFormat, options: ModelOptions) -> None:
    if kind is ExportFormat.PAB:
        _export_pab(dataset, file, output, options)
        return
    if kind is ExportFormat.CSV:
        from gonio.formats.tables import csv_write as csv_points

        csv_points.write(dataset, output, channel=options.channel)
    else:
        from gonio.formats.tables import nist as nist_csv

        _, left_out = nist_csv.write(dataset, output, channel=options.channel)
        if left_out:
            say(f"{left_out} points left out: masked, in transmission or at grazing.")
    typer.echo(output)


def _export_pab(dataset: "Dataset", file: Path, output: Path, options: ModelOptions) -> None:
    from gonio.formats.pab import write as pab_write

    if not output.is_dir():
        check_outputs(output, inputs=[file])
    written = pab_write.write(dataset, output, front=options.front, channel=options.channel)
    say(*written.remarks)
    for path in written.paths:
        typer.echo(path)
