"""fit.py: fit: a model that answers in all directions, from points measured for a few incident ones."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

import json
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gonio.cli.device import JsonOption
from gonio.cli.options import DeclaredSymmetry, OutputOption
from gonio.cli.places import check_inputs, check_outputs
from gonio.cli.saying import say
from gonio.units.errors import UsageError

if TYPE_CHECKING:
    from gonio.dataset.bsdf import Dataset, Symmetry
    from gonio.dataset.scattering import Bsdf
    from gonio.model.sphere_values import Band


class SphereTie(StrEnum):
    """Which of the integrating sphere's values the model's integrals are tied to."""

    TOTAL = "total"
    DIFFUSE = "diffuse"


def register(app: typer.Typer) -> None:
    """Add the command of this module."""
    app.command("fit")(fit)


def fit(
    what: Annotated[
        list[str],
        typer.Argument(
            metavar="[FAMILY] BSDF.h5",
            help="A dataset; before it, perhaps, an analytic family: lambertian, gaussian, abg, ggx, ggx-dielectric, "
            "ward-duer, or auto. Without: lobes, what is left beside them, and a ground.",
        ),
    ],
    *,
    output: OutputOption,
    symmetry: Annotated[
        DeclaredSymmetry | None,
        typer.Option(
            help="What you know of the sample; it is tested, never guessed. Up: half a turn about the normal, not "
            "mirrored. Goes before what the dataset declares."
        ),
    ] = None,
    method: Annotated[
        str,
        typer.Option(
            metavar="METHOD",
            help="auto: by leave-one-out. lobes-fixed, lobes-opposite, lobes-same: peaks are matched and moved, the "
            "ground follows nothing, the mirror or the retro direction; lobes-opposite-rest, lobes-same-rest: only "
            "what directions do not have in common follows; -pchip after the first three: a monotone cubic in theta. "
            "blend-fixed, blend-opposite, blend-same: no peaks.",
        ),
    ] = "auto",
    channel: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="Only this channel; may be repeated. Default: all.")
    ] = None,
    enforce_reciprocity: Annotated[
        bool, typer.Option("--enforce-reciprocity", help="Fit the mean of both ways of the light; recorded.")
    ] = False,
    sphere: Annotated[
        Path | None,
        typer.Option(metavar="FILE.csv", help="With a family: integrating-sphere values that integrals are tied to."),
    ] = None,
    sphere_tie: Annotated[
        SphereTie, typer.Option("--sphere-tie", help="With --sphere: total or diffuse values.")
    ] = SphereTie.TOTAL,
    sphere_band: Annotated[
        str | None, typer.Option("--sphere-band", metavar="FROM,TO", help="With --sphere: wavelengths in nm.")
    ] = None,
    back_as_front: Annotated[
        bool,
        typer.Option("--back-as-front", help="With a family: what was not measured from behind is as from the front."),
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Fit a model to a dataset and write it; gonio query and gonio export read it.

    Prints how it was chosen: leave-one-out on the data, lobes per incident direction, integrals, tests of the declared
    symmetry and of reciprocity.
    """
    from gonio.model.fit_text import text, warnings
    from gonio.model.model_file import write_model

    family, file = _named(what)
    check_inputs(file, sphere)
    check_outputs(output, inputs=[file, sphere])
    if family is None and (sphere is not None or sphere_band is not None or back_as_front):
        raise UsageError("--sphere, --sphere-band and --back-as-front are for a family: gonio fit FAMILY BSDF.h5")
    if family is not None and (method != "auto" or enforce_reciprocity):
        raise UsageError(f"--method and --enforce-reciprocity are not for a family ({family}): leave them out")
    dataset = _points(file)
    declared: Symmetry | None = None if symmetry is None else symmetry.value
    channels = tuple(channel) if channel else None
    if family is None:
        from gonio.model.fitted import fit_bsdf

        found = fit_bsdf(
            dataset,
            symmetry=declared,
            method=method,
            channels=channels,
            enforce_reciprocity=enforce_reciprocity,
        )
    else:
        from gonio.model.analytic import fit_family
        from gonio.model.sphere_values import read_sphere

        found = fit_family(
            dataset,
            family,
            sphere=None if sphere is None else read_sphere(sphere),
            sphere_tie=sphere_tie.value,
            band=_band(sphere_band),
            symmetry=declared,
            channels=channels,
            back_as_front=back_as_front,
        )
    write_model(found, output)
    record = found.provenance["model"]
    say(*warnings(record))
    if as_json:
        typer.echo(json.dumps(_as_json(found, output), allow_nan=False))
    else:
        typer.echo(text(record))
        typer.echo("\n".join(["", *found.validity, "", str(output)]))


def _named(what: list[str]) -> tuple[str | None, Path]:
    """The family, if one is named, and the file."""
    from gonio.model.analytic import FAMILIES

    if len(what) == 1:
        if what[0] in FAMILIES and not Path(what[0]).exists():
            raise UsageError(f"fit {what[0]}: name the dataset behind the family")
        return None, Path(what[0])
    if len(what) > 2:
        raise UsageError(f"{what[2]}: fit takes one file, and before it perhaps a family")
    if what[0] not in FAMILIES:
        raise UsageError(f"no family {what[0]!r}: choose one of {', '.join(FAMILIES)}, or name the file alone")
    return what[0], Path(what[1])


def _points(file: Path) -> "Dataset":
    from gonio.cli.sources import check_dataset
    from gonio.dataset.nexus import read_dataset, read_scattering

    check_dataset(file)
    dataset = read_scattering(file)
    if all(distribution.solid_angle_sr.any() for distribution in dataset.distributions):
        return dataset
    from gonio.reduce.imported import reduce_dataset  # without cells: as it was imported

    return reduce_dataset(read_dataset(file))


def _band(text: str | None) -> "Band | None":
    from gonio.model.sphere_values import Band

    if text is None:
        return None
    try:
        low, high = (float(part) for part in text.split(","))
    except ValueError as error:
        raise UsageError(f"--sphere-band {text}: give two wavelengths in nm, as 380,780") from error
    if not 0.0 < low <= high < 1e6:
        raise UsageError(f"--sphere-band {text}: not a band: give two wavelengths in nm, the smaller first")
    return Band.flat(low, high)


def _as_json(found: "Bsdf", output: Path) -> dict[str, object]:
    return {
        "output": str(output),
        "sample": found.sample_name,
        "symmetry": found.symmetry,
        "validity": list(found.validity),
        "measured": [vars(m) for m in found.measured],
        "model": found.provenance["model"],
    }
