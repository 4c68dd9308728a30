"""build.py: the trees of a sample's bands and components, grown together to what a file may hold."""

from dataclasses import dataclass, replace

import numpy as np

from gonio.dataset.bsdf import Side
from gonio.dataset.scattering import Bsdf, Scattering
from gonio.formats.tensor.cells import CellIntegrator
from gonio.formats.tensor.choose import Offered, choose
from gonio.formats.tensor.chromaticity import chromaticity
from gonio.formats.tensor.energy import check_side
from gonio.formats.tensor.forced import forced_cells
from gonio.formats.tensor.frame import Component, covered
from gonio.formats.tensor.grow import GrownTree, grow
from gonio.formats.tensor.leaves import Leaves, averaged, negatives_to_zero
from gonio.formats.tensor.measure import like_radiance, mixed
from gonio.formats.tensor.piecewise import PiecewiseIntegrator
from gonio.formats.tensor.text import foreseen_sizes, rendered
from gonio.formats.window.matrices import SIDES
from gonio.formats.window.scattering import KlemsScattering
from gonio.units.errors import UsageError

Key = tuple[str, Component]  # <Wavelength> and component
_BYTES_PER_LEAF = 5.0
_SURE = 0.998  # of a limit in bytes that is aimed at: averages are improved after their length was foreseen
_CELLS_OF_VIEW = 6.0  # standard deviations of a peak seen through that a cell must be wide
_PROBE_LEVEL = {3: 3, 4: 2}


@dataclass(frozen=True)
class Limit:
    """What a file may hold: leaves, or bytes of tree text, or the leaves left of a full tree's after a percentage."""

    leaves: int | None = None
    text_bytes: float | None = None
    percent: float | None = None


@dataclass
class Built:
    """Trees with their text. `remarks`: what was found on the way, one sentence each."""

    leaves: dict[Key, Leaves]
    text: dict[Key, str]
    remarks: list[str]
    view_through: bool


def build(
    bsdf: Bsdf,
    channels: dict[str, str],
    front_faces: Side,
    dimensions: int,
    resolution: int,
    limit: Limit,
    *,
    rescaled: bool,
) -> Built:
    """Trees of the channels, by band; CIE-X, CIE-Y and CIE-Z become Visible (Y), CIE-u and CIE-v as Radiance has them.

    Raises UsageError where nothing was measured, CheckFailed where energy exceeds 1.
    """
    bands = {"Visible" if band == "CIE-Y" else band: name for band, name in channels.items()}
    luminous = {band: name for band, name in bands.items() if band not in ("CIE-X", "CIE-Z")}
    sources = {band: bsdf.channels[name] for band, name in luminous.items()}
    trees = _planted(sources, front_faces, dimensions, resolution, as_radiance=limit.percent is not None)
    whole = list(trees.values())
    aim, most = _aim(whole, limit)
    grow(whole, aim)
    sized = limit.text_bytes is not None
    offered = [Offered(tree, foreseen_sizes(tree) if sized else None) for tree in whole]
    share = _SURE if sized else 1.0
    while True:
        leaves = {key: averaged(chosen) for key, chosen in zip(trees, choose(offered, share * most), strict=True)}
        remarks = _negatives(leaves) + _energy(leaves, luminous, bsdf, rescaled=rescaled)
        if "CIE-X" in bands:
            leaves |= _colours(leaves, bsdf.channels[bands["CIE-X"]], bsdf.channels[bands["CIE-Z"]])
        text = {key: rendered(own, small=sized) for key, own in leaves.items()}
        written = sum(map(len, text.values()))
        if not sized or written <= most or all(own.chosen.leaves == 1 for own in leaves.values()):
            break
        share *= _SURE * most / written
    remarks += _seen_through(whole)
    return Built(leaves, text, remarks, any(tree.forced.view_through for tree in whole))


def _planted(
    sources: dict[str, Scattering], front_faces: Side, dimensions: int, resolution: int, *, as_radiance: bool
) -> dict[Key, GrownTree]:
    own: dict[Key, CellIntegrator | PiecewiseIntegrator] = {
        (band, component): _integrator(scattering, component, front_faces, dimensions, resolution)
        for band, scattering in sources.items()
        for component in covered(scattering, front_faces)
    }
    if not own:
        raise UsageError("there is nothing to write: no pair of the sample's sides was measured")
    weight = like_radiance() if as_radiance else mixed(max(_hemispherical(integrator) for integrator in own.values()))
    trees = {}
    for key, integrator in own.items():
        forced = forced_cells(integrator.scattering, key[1], front_faces, dimensions, resolution)
        trees[key] = GrownTree(replace(integrator, weight=weight), resolution, forced)
        trees[key].plant()
    return trees


def _integrator(
    scattering: Scattering, component: Component, front_faces: Side, dimensions: int, resolution: int
) -> CellIntegrator | PiecewiseIntegrator:
    if isinstance(scattering, KlemsScattering) and scattering.front_faces == front_faces:
        return PiecewiseIntegrator(scattering, component, front_faces, dimensions, mixed(1.0), resolution)
    return CellIntegrator(scattering, component, front_faces, dimensions, mixed(1.0))


def _hemispherical(integrator: CellIntegrator | PiecewiseIntegrator) -> float:
    """About the bi-hemispherical reflectance or transmittance, without what narrow peaks carry."""
    level, d = _PROBE_LEVEL[integrator.dimensions], integrator.dimensions
    first = 1 << (level - 1 if d == 3 else level)
    axes = np.meshgrid(np.arange(first), *[np.arange(1 << level)] * (d - 1), indexing="ij")
    index = np.stack([axis.ravel() for axis in axes], axis=1).astype(np.int64)
    return float(np.pi * np.mean(integrator.sums(index, level).mean))


def _aim(trees: list[GrownTree], limit: Limit) -> tuple[int, float]:
    """Leaves to grow, and how many leaves, or characters, the chosen trees may have."""
    d = trees[0].dimensions
    dense = sum(2.0 ** (d * tree.resolution - (1 if d == 3 else 0)) for tree in trees)
    if limit.text_bytes is not None:
        return int(min(limit.text_bytes / _BYTES_PER_LEAF, dense)), limit.text_bytes
    most = dense * (1.0 - limit.percent / 100.0) if limit.percent is not None else float(limit.leaves or dense)
    return max(int(most), 1), max(most, 1.0)


def _seen_through(trees: list[GrownTree]) -> list[str]:
    """Radiance's aBSDF takes the brightest cells about the straight direction for the view, and samples the rest: what
    lies more than a cell aside is counted twice."""
    sigma = max((tree.forced.seen_sigma_rad or 0.0 for tree in trees), default=0.0)
    if sigma == 0.0:
        return []
    best = int(np.floor(np.log2(np.sqrt(np.pi) / (_CELLS_OF_VIEW * sigma))))
    if best >= trees[0].resolution:
        return []
    return [
        f"The peak seen through (sigma {np.degrees(sigma):.2f} degrees) reaches over several cells: Radiance's aBSDF "
        f"counts it right within some per cent with resolution {max(best, 2)} or less."
    ]


def _negatives(leaves: dict[Key, Leaves]) -> list[str]:
    remarks = []
    for (band, component), own in leaves.items():
        added = negatives_to_zero(own)
        if added > 0.0:
            remarks.append(
                f"{band} {component}: negative averages written as 0, adding {added:.2e} to the hemispherical value."
            )
    return remarks


def _energy(leaves: dict[Key, Leaves], channels: dict[str, str], bsdf: Bsdf, *, rescaled: bool) -> list[str]:
    remarks = []
    for band, name in channels.items():
        for side in SIDES:
            parts = [own for (of, component), own in leaves.items() if of == band and component.side == side]
            if parts:
                remarks += check_side(side, name, parts, bsdf, rescaled=rescaled)
    return remarks


def _colours(leaves: dict[Key, Leaves], x: Scattering, z: Scattering) -> dict[Key, Leaves]:
    return {
        (name, component): own
        for (band, component), y in leaves.items()
        if band == "Visible"
        for name, own in zip(("CIE-u", "CIE-v"), chromaticity(y, x, z), strict=True)
    }
