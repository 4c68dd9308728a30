"""tables.py: a measured or computed BSDF (our dataset, or WINDOW XML) as a table that the photon map draws from."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from gonio.dataset.bsdf import Dataset, Distribution
from gonio.dataset.nexus import read_dataset
from gonio.formats.window import read as window_reader
from gonio.formats.window.klems import KlemsBasis, LightSide, process_of, to_radiance_deg
from gonio.formats.window.matrices import BANDS, Band
from gonio.geometry.directions import angle_between_deg, angles_deg_from_unit, fold_phi_deg, unit_from_angles_deg
from gonio.reduce.integrals.hemispheres import integrals
from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]

CELLS = 64
_FOLLOW = ("none", "mirror", "retro", "through")
_WITHIN = 3  # directions per side of a cell where a cell takes its value from the nearest points
_GRAZING = 0.02  # cosine below which a BSDF is not divided out further
_COVERED = 0.5  # of a cell: with more, its own points tell its value
_MOST_ENERGY = 1.05  # beyond it the data are wrong, and the photon map says so
_WHOLE = 0.95  # share of a hemisphere that must have been measured to tell its sum
_TURNED_DEG = 1.0  # azimuths further apart than this make a table anisotropic


@dataclass(frozen=True)
class Entry:
    """BSDF [1/sr] (cells, cells) for one incident direction, theta 0-90 from the normal of its side; see
    shirley_chiu."""

    back: bool
    theta_deg: float
    phi_deg: float
    reflected: FloatArray
    transmitted: FloatArray


@dataclass(frozen=True)
class Table:
    """What _photons.ScatterTable takes."""

    cells: int
    follow: str
    isotropic: bool
    entries: tuple[Entry, ...] = field(repr=False)


def read_tables(document: dict[str, Any], folder: Path, band: str) -> dict[str, Table]:
    """The tables of a scenario's data-driven materials for a band, by the file name in the scenario; text tables are
    left to the photon map. Raises UsageError."""
    found: dict[str, Table] = {}
    for material in _tabulated(document):
        name = material["file"]
        path = folder / name
        follow = str(material.get("follow", "none"))
        if follow not in _FOLLOW:
            raise UsageError(f'{path}: follow = "{follow}" in the scenario: must be one of {", ".join(_FOLLOW)}')
        if path.suffix == ".h5":
            found[name] = table_of_dataset(read_dataset(path), band, follow, str(path))
        elif path.suffix == ".xml":
            found[name] = table_of_window(path, band, follow)
    return found


def _tabulated(document: dict[str, Any]) -> Iterator[dict[str, Any]]:
    materials = document.get("materials", {})
    for material in materials.values() if isinstance(materials, dict) else ():
        if isinstance(material, dict) and material.get("kind") == "tabulated" and isinstance(material.get("file"), str):
            yield material


def shirley_chiu(cells: int, within: int = 1) -> FloatArray:
    """Unit vectors (cells, cells, within^2, 3), z > 0, of points spread evenly in each cell: row by row along y, then
    x.

    The square [-1, 1]^2 goes to the disc of direction cosines by Shirley and Chiu's map ("A low distortion map between
    disk and square", 1997): equal areas, so cells of equal projected solid angle pi / cells^2.
    """
    side = (np.arange(cells * within) + 0.5) / (cells * within) * 2.0 - 1.0
    b, a = np.meshgrid(side, side, indexing="ij")
    wide = np.abs(a) > np.abs(b)
    radius = np.where(wide, a, b)
    with np.errstate(invalid="ignore", divide="ignore"):
        azimuth = np.where(wide, np.pi / 4.0 * (b / a), np.pi / 2.0 - np.pi / 4.0 * (a / b))
    azimuth = np.where(radius == 0.0, 0.0, azimuth)
    x, y = radius * np.cos(azimuth), radius * np.sin(azimuth)
    unit = np.stack((x, y, np.sqrt(np.maximum(1.0 - radius**2, 0.0))), axis=-1)
    split = unit.reshape(cells, within, cells, within, 3).transpose(0, 2, 1, 3, 4)
    return np.asarray(split.reshape(cells, cells, within**2, 3))


def cell_of(unit: FloatArray, cells: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Row and column, each (n,), of the cells that hold the directions (n, 3), by (x, y) alone: the inverse map."""
    x, y = unit[:, 0], unit[:, 1]
    wide = np.abs(x) > np.abs(y)
    longer, shorter = np.where(wide, x, y), np.where(wide, y, x)
    sign = np.copysign(1.0, longer)
    along = sign * np.hypot(x, y)
    across = along * np.arctan2(sign * shorter, np.abs(longer)) * 4.0 / np.pi
    a, b = np.where(wide, along, across), np.where(wide, across, along)
    place = [np.clip(((v + 1.0) * 0.5 * cells).astype(np.intp), 0, cells - 1) for v in (b, a)]
    return place[0], place[1]


def table_of_dataset(dataset: Dataset, band: str, follow: str, source: str, cells: int = CELLS) -> Table:
    """Table of a dataset's channel named as the band, or of its only one. Raises UsageError."""
    channels = list(dict.fromkeys(d.channel for d in dataset.distributions))
    channel = band if band in channels else channels[0] if len(channels) == 1 else None
    if channel is None:
        named = ", ".join(channels) or "none"
        raise UsageError(
            f'{source}: has no channel "{band}" (it has {named}): name a [[band]] of the scenario after one'
        )
    own = [d for d in dataset.distributions if d.channel == channel]
    entries = []
    for distribution in own:
        back = distribution.incident_theta_deg > 90.0
        sums = integrals(distribution)
        up, down = (
            _of_energy(_cells_of_points(distribution, side, cells), sums, "rho" if (side < 0.0) == back else "tau")
            for side in (1.0, -1.0)
        )
        theta_deg = 180.0 - distribution.incident_theta_deg if back else distribution.incident_theta_deg
        entries.append(_entry(back, (theta_deg, distribution.incident_phi_deg), (down, up) if back else (up, down)))
    isotropic = _isotropic(dataset.symmetry, entries)
    if isotropic:  # one azimuth tells all
        entries = list({(e.back, e.theta_deg): e for e in reversed(entries)}.values())[::-1]
    return Table(cells, follow, isotropic, tuple(entries))


def _of_energy(bsdf: FloatArray, sums: dict[str, float], name: str) -> FloatArray:
    """BSDF (cells, cells) with the dataset's own hemispherical sum, where nearly all of the hemisphere was measured."""
    energy = float(bsdf.sum()) * np.pi / bsdf.size
    if energy > 0.0 and sums.get(f"{name}_measured_share", 0.0) > _WHOLE:
        return bsdf * (sums[f"{name}_estimate"] / energy)
    return bsdf


def _entry(back: bool, incident_deg: tuple[float, float], halves: tuple[FloatArray, FloatArray]) -> Entry:
    """From theta (0-90) and phi and what is reflected and transmitted, both in the sample's x and y. Data that send out
    a little more than they get, by noise, are scaled down."""
    theta_deg, phi_deg = incident_deg
    reflected, transmitted = halves
    if back:
        phi_deg, reflected, transmitted = -phi_deg, reflected[::-1], transmitted[::-1]
    energy = float(reflected.sum() + transmitted.sum()) * np.pi / reflected.size
    scale = 1.0 / energy if 1.0 < energy < _MOST_ENERGY else 1.0
    parts = [np.ascontiguousarray(scale * part) for part in (reflected, transmitted)]
    return Entry(back, float(theta_deg), float(fold_phi_deg(phi_deg)), parts[0], parts[1])


def _isotropic(symmetry: str, entries: list[Entry]) -> bool:
    """As the dataset declares, or where nothing but theta tells its incident directions apart."""
    if symmetry != "undeclared":
        return symmetry == "isotropic"
    oblique = [unit_from_angles_deg(90.0, e.phi_deg) for e in entries if e.theta_deg > 0.0]
    return all(angle_between_deg(oblique[0], other) <= _TURNED_DEG for other in oblique[1:])


def _cells_of_points(distribution: Distribution, side: float, cells: int) -> FloatArray:
    """BSDF (cells, cells) towards one side from a point list: the mean over a cell's own points where they cover half
    of it, else the values of the nearest points."""
    unit = unit_from_angles_deg(distribution.theta_deg, distribution.phi_deg)
    chosen = distribution.measured & (side * unit[:, 2] > 0.0) & np.isfinite(distribution.dsf_per_sr)
    if not chosen.any():
        return np.zeros((cells, cells))
    unit = unit[chosen]
    cosine = np.maximum(np.abs(unit[:, 2]), _GRAZING)
    bsdf = np.maximum(distribution.dsf_per_sr[chosen], 0.0) / cosine
    projected = distribution.solid_angle_sr[chosen] * cosine
    inside = shirley_chiu(cells, _WITHIN)
    inside[..., 2] *= side
    nearest = cKDTree(unit).query(inside.reshape(-1, 3))[1]
    result = bsdf[nearest].reshape(cells, cells, -1).mean(axis=-1)
    row, column = cell_of(unit, cells)
    covered, light = np.zeros((cells, cells)), np.zeros((cells, cells))
    np.add.at(covered, (row, column), projected)
    np.add.at(light, (row, column), projected * bsdf)
    own = covered > _COVERED * np.pi / cells**2
    result[own] = light[own] / covered[own]
    return np.asarray(result)


def table_of_window(path: Path, band: str, follow: str, cells: int = CELLS) -> Table:
    """Table of a WINDOW file's Klems matrices, the sample's front facing the exterior: the Solar ones for a band named
    solar or near-infrared, where the file has them, else the Visible ones. Raises UsageError."""
    window = window_reader.read(path)
    there = [name for name in BANDS if any(key[0] == name for key in window.matrices)]
    if not there:
        raise UsageError(f"{path}: holds no visible or solar matrix: name a file that does")
    wanted: Band = "Solar" if band in ("solar", "near-infrared") else "Visible"
    if wanted not in there:
        wanted = there[0]
    inside = shirley_chiu(cells, _WITHIN)
    patches = {to_room: _patches(window.basis, inside, to_room) for to_room in (True, False)}
    sides: tuple[LightSide, ...] = ("Front", "Back")
    entries = []
    for side in sides:
        for column, (polar_deg, azimuth_deg) in enumerate(window.basis.centres_deg):
            theta_r_deg = 180.0 - polar_deg if side == "Front" else polar_deg
            phi_deg = float(to_radiance_deg(theta_r_deg, azimuth_deg + 180.0, "exterior")[1])
            halves = {}
            for to_room, (patch, factor) in patches.items():
                process = process_of(side, to_room)
                matrix = window.matrices.get((wanted, process, side))
                lit = np.zeros((cells, cells)) if matrix is None else (factor * matrix[:, column])[patch].mean(axis=-1)
                halves[process] = lit
            reflected, transmitted = halves["Reflection"], halves["Transmission"]
            entries.append(_entry(side == "Back", (polar_deg, phi_deg), (reflected, transmitted)))
    return Table(cells, follow, False, tuple(entries))


def _patches(basis: KlemsBasis, inside: FloatArray, to_room: bool) -> tuple[NDArray[np.int64], FloatArray]:
    """Patch (cells, cells, n) of the points of all cells on the room's side or the other, our front facing the
    exterior; and for each patch what its points leave out or add to its projected solid angle, as a factor
    (patches,)."""
    theta_deg, phi_deg = angles_deg_from_unit(inside * [1.0, 1.0, -1.0 if to_room else 1.0])
    theta_r, phi_r = to_radiance_deg(theta_deg, phi_deg, "exterior")
    patch = basis.patch_of(np.minimum(theta_r, 180.0 - theta_r), phi_r)
    covered_sr = np.bincount(patch.ravel(), minlength=basis.size) * np.pi / patch.size
    return patch, basis.projected_solid_angle_sr / np.maximum(covered_sr, np.pi / patch.size)
