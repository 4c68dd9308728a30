"""convert.py: convert: a simulation file in another angle basis, its integrals kept."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gonio.cli.options import Front, OutputOption, Resolution
from gonio.cli.places import check_inputs, check_outputs
from gonio.cli.saying import say
from gonio.units.errors import UsageError

if TYPE_CHECKING:
    from gonio.dataset.bsdf import Side
    from gonio.dataset.scattering import Bsdf
    from gonio.formats.findings import Findings


class ConvertFormat(StrEnum):
    """What convert can write."""

    KLEMS_FULL = "klems-full"
    KLEMS_HALF = "klems-half"
    KLEMS_QUARTER = "klems-quarter"
    TENSOR3 = "tensor3"
    TENSOR4 = "tensor4"


def register(app: typer.Typer) -> None:
    """Add the command of this module."""
    app.command("convert")(convert)


def convert(
    file: Annotated[Path, typer.Argument(metavar="FILE.xml", help="WINDOW XML with Klems matrices, or a tensor tree.")],
    *,
    kind: Annotated[
        ConvertFormat,
        typer.Option("--format", help="Klems basis, or tensor tree of 3 (isotropic samples) or 4 dimensions."),
    ],
    output: OutputOption,
    front: Annotated[
        Front | None, typer.Option(help="Side that the sample's front faces; goes before what the file says.")
    ] = None,
    rescale: Annotated[
        bool, typer.Option("--rescale", help="Where more light leaves than arrives, scale it to all, and record it.")
    ] = False,
    resolution: Resolution = None,
    size_mb: Annotated[float | None, typer.Option(metavar="MB", help="tensor: most size of the file.")] = None,
) -> None:
    """Bring a simulation file into another basis. Every band is converted; what is odd about the file is said."""
    check_inputs(file)
    check_outputs(output, inputs=[file])
    bsdf, findings = _read(file, None if front is None else front.value)
    notes = [f"Of {findings.source}: {f.where}: {f.message}" for f in findings.of("error", "warning")]
    if kind.value.startswith("klems-"):
        _to_matrices(bsdf, output, kind.value, notes, rescale=rescale)
    else:
        limits = resolution, size_mb
        _to_tree(bsdf, output, int(kind.value[-1]), limits, notes, rescale=rescale)
    typer.echo(output)


def _read(file: Path, front: "Side | None") -> tuple["Bsdf", "Findings"]:
    from gonio.cli.sources import kind_of

    kind = kind_of(file)
    if kind == "matrices":
        from gonio.formats.window.scattering import window_bsdf

        return window_bsdf(file, front)
    if kind == "tree":
        from gonio.formats.tensor.read import read_tensor

        return read_tensor(file, front)
    raise UsageError(f"{file}: is no simulation file: gonio export writes those from datasets and models")


def _to_matrices(bsdf: "Bsdf", output: Path, basis: str, notes: list[str], *, rescale: bool) -> None:
    from gonio.formats import conversion
    from gonio.formats.window import from_model as klems_model
    from gonio.formats.window.klems import basis_named
    from gonio.formats.window.matrices import Band

    named: dict[str, Band] = {"visible": "Visible", "solar": "Solar", "CIE-X": "CIE-X", "CIE-Z": "CIE-Z"}
    channels = {named[name]: name for name in bsdf.channels if name in named}
    notes += [
        f"Channel {name} is left out: WINDOW XML has no such band." for name in bsdf.channels if name not in named
    ]
    if not channels:
        raise UsageError(f"{output}: none of {', '.join(bsdf.channels)} is a band of WINDOW XML")
    what = klems_model.ModelFile(channels, rescale=rescale, notes=tuple(notes))
    made = klems_model.write(bsdf, output, what, basis=basis, averages=conversion.averages(bsdf, basis_named(basis)))
    say(*(line for line in made.remarks() if not line.startswith("gonio-validity")))


def _to_tree(
    bsdf: "Bsdf",
    output: Path,
    dimensions: int,
    limits: tuple[int | None, float | None],
    notes: list[str],
    *,
    rescale: bool,
) -> None:
    from gonio.formats.tensor.write import write_tensor

    wanted = {"Visible": "visible", "Solar": "solar"}
    if "CIE-X" in bsdf.channels and "CIE-Z" in bsdf.channels:
        wanted = {"CIE-X": "CIE-X", "CIE-Y": "visible", "CIE-Z": "CIE-Z", "Solar": "solar"}
    channels = {band: name for band, name in wanted.items() if name in bsdf.channels}
    notes += [
        f"Channel {name} is left out: it is no band of a tensor tree."
        for name in bsdf.channels
        if name not in channels.values()
    ]
    described = replace(bsdf, validity=(*bsdf.validity, *notes))
    remarks = write_tensor(
        described,
        output,
        dimensions=dimensions,
        resolution=limits[0],
        size_mb=limits[1],
        channels=channels,
        rescale=rescale,
    )
    say(*notes, *remarks)
    say(*_changes(bsdf, output))


def _changes(bsdf: "Bsdf", output: Path) -> list[str]:
    """How far the tree's hemispherical values depart from the file's, averaged over Klems patches."""
    import numpy as np

    from gonio.formats import conversion
    from gonio.formats.tensor.read import read_tensor
    from gonio.formats.window.klems import basis_named

    basis = basis_named("klems-full")
    tree, _ = read_tensor(output, bsdf.front_faces)
    before, after = conversion.averages(bsdf, basis), conversion.averages(tree, basis)
    lines = []
    for name in before.keys() & after.keys():
        for key in sorted(before[name].matrices.keys() & after[name].matrices.keys()):
            old, new = (basis.projected_solid_angle_sr @ found[name].matrices[key] for found in (before, after))
            if old.any():
                change = float(np.abs(new - old).max() / old.max())
                lines.append(f"{name} {key[0]} {key[1]}: hemispherical values change by up to {100 * change:.2f} %.")
    return sorted(lines)
