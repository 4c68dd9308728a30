"""exporting.py: what export does with a model: matrices, trees, and points of it."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from gonio.cli.options import angles
from gonio.cli.saying import say
from gonio.units.errors import UsageError

if TYPE_CHECKING:
    from gonio.dataset.bsdf import Dataset, Side, Symmetry
    from gonio.dataset.scattering import Bsdf


@dataclass(frozen=True)
class ModelOptions:
    """Options of export that a model needs."""

    channel: str | None = None
    front: "Side | None" = None
    symmetry: "Symmetry | None" = None
    assume_flat: bool = False
    rescale: bool = False
    solar_spectrum: str | None = None
    solar_band: tuple[str, ...] = ()
    xyz: str | None = None
    cells: Path | None = None
    # Of trees.
    resolution: int | None = None
    leaves: int | None = None
    size_mb: float | None = None
    percent: float | None = None
    material: Path | None = None


def opened(file: Path, options: ModelOptions) -> "Bsdf":
    """The model in a file, or fitted to a dataset. UsageError for files of averages: these are converted."""
    from gonio.cli.sources import kind_of, open_bsdf

    kind = kind_of(file)
    if kind in ("matrices", "tree"):
        raise UsageError(f"{file}: is a simulation file already: gonio convert brings it into another basis")
    if kind == "dataset":
        from gonio.dataset.nexus import read_dataset
        from gonio.formats.pab.raw_signal import refuse_raw

        refuse_raw([d for d in read_dataset(file).distributions if options.channel in (None, d.channel)])
    wanted: list[str] | None = None
    if options.xyz is not None:
        wanted = list(dict.fromkeys((_xyz(options.xyz) or {}).values()))
    elif options.channel is not None:
        wanted = [options.channel]
    if options.solar_spectrum is not None:
        wanted = None  # every channel may have a share of the sun
    return open_bsdf(file, symmetry=options.symmetry, front=options.front, channels=wanted)


def export_matrices(file: Path, output: Path, basis: str, options: ModelOptions) -> None:
    """WINDOW XML whose cells are averages over both patches."""
    from gonio.formats.window import from_model as klems_model

    bsdf, notes = _with_solar(opened(file, options), options)
    channels = klems_model.channels_of(bsdf, channel=options.channel, xyz=_xyz(options.xyz))
    what = klems_model.ModelFile(channels, options.assume_flat, options.rescale, tuple(notes))
    made = klems_model.write(bsdf, output, what, basis=basis, front=options.front, cells=options.cells)
    say(*(line for line in made.remarks() if not line.startswith("gonio-validity")))
    typer.echo(output)
    if options.cells is not None:
        typer.echo(options.cells)


def export_tree(file: Path, output: Path, dimensions: int, options: ModelOptions) -> None:
    """Tensor tree XML."""
    from gonio.formats.tensor.write import write_tensor
    from gonio.formats.window.from_model import channels_of

    bsdf, notes = _with_solar(opened(file, options), options)
    xyz = _xyz(options.xyz)
    wanted: dict[str, str] = {}
    if xyz is not None:
        wanted = {f"CIE-{letter}": name for letter, name in xyz.items()}
    elif len(bsdf.channels) > 1 or options.channel is not None:
        wanted = dict(channels_of(bsdf, channel=options.channel).items())
    if options.assume_flat and "Visible" in wanted:
        wanted.setdefault("Solar", wanted["Visible"])
        notes.append("Solar: copied from Visible (declared spectrally flat).")
    bsdf = replace(bsdf, validity=(*bsdf.validity, *notes))
    remarks = write_tensor(
        bsdf,
        output,
        dimensions=dimensions,
        resolution=options.resolution,
        leaves=options.leaves,
        size_mb=options.size_mb,
        percent=options.percent,
        front=options.front,
        channels=wanted or None,
        rescale=options.rescale,
        material=options.material,
        cells=options.cells,
    )
    say(*notes, *remarks)
    for path in (output, options.material, options.cells):
        if path is not None:
            typer.echo(path)


def points_of_model(file: Path, incident: list[str], step_deg: float | None, options: ModelOptions) -> "Dataset":
    """A model's values as points, for the incident directions named or else those that were measured."""
    from gonio.formats import model_points

    bsdf = opened(file, options)
    chosen = [angles(text) for text in incident] or model_points.measured_incidents(bsdf)
    step = model_points.DEFAULT_STEP_DEG if step_deg is None else step_deg
    dataset = model_points.sampled(bsdf, chosen, step_deg=step, channel=options.channel)
    say(f"values of the model for {len(chosen)} incident directions, every {step:g} degrees; flagged as simulated.")
    return dataset


def _with_solar(bsdf: "Bsdf", options: ModelOptions) -> tuple["Bsdf", list[str]]:
    if options.solar_spectrum is None:
        if options.solar_band:
            raise UsageError("--solar-band goes with --solar-spectrum astm-g173 or a FILE.csv")
        return bsdf, []
    from gonio.formats.solar.weighted import with_solar

    if options.assume_flat:
        raise UsageError("--assume-flat copies a block, --solar-spectrum computes it: give one of them")
    if options.channel is not None and options.channel in bsdf.channels and options.channel.lower() == "solar":
        raise UsageError("--solar-spectrum computes the channel solar: leave --channel solar away")
    bsdf, weights = with_solar(bsdf, options.solar_spectrum, dict(_band(text) for text in options.solar_band))
    return bsdf, [weights.sentence()]


def _band(text: str) -> tuple[str, tuple[float, float]]:
    from gonio.formats.solar.weights import range_nm

    name, mark, span = text.rpartition("=")
    band = range_nm(span)
    if not mark or not name or band is None:
        raise UsageError(f"--solar-band {text}: write CHANNEL=FROM-TO in nm, as in visible=380-780")
    return name, band


def _xyz(text: str | None) -> dict[str, str] | None:
    if text is None:
        return None
    found = dict(part.partition("=")[::2] for part in text.split(","))
    if sorted(found) != ["X", "Y", "Z"] or not all(found.values()):
        raise UsageError(f"--xyz {text}: write X=CHANNEL,Y=CHANNEL,Z=CHANNEL")
    return found
