"""dataset.py: a dataset from a tensor tree: at given incident directions, a point per cell of outgoing ones."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Distribution, PointFlag, Side
from gonio.formats.tensor.flat import FlatTree
from gonio.formats.tensor.frame import Component, place_of, turned
from gonio.formats.tensor.read import read_tensor
from gonio.formats.tensor.square import cell_points, disc_from_square, on_diagonal
from gonio.formats.tensor.tree import TreeScattering, slices
from gonio.geometry.directions import angles_deg_from_unit, unit_from_angles_deg
from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]

_THETA_DEG = (0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0)
_AZIMUTHS = 8  # of a tree without symmetry
_DIGITS = 3  # that trees are written with at least
_GAUSS = 6


def read_dataset(
    path: Path, front: Side | None = None, incident_deg: Sequence[tuple[float, float]] | None = None
) -> tuple[Dataset, list[str]]:
    """A dataset of all bands and remarks, one sentence each.

    `incident_deg`: (theta, phi) in the sample frame; by default theta_i every 10 degrees up to 80 from both normals, at
    phi_i = 0 for a tree of three dimensions, else at every 45 degrees. Points stand in the tree's cells (`_middles`),
    with the cells' solid angles Omega, and DSF = B L / Omega: their sums are the file's, sum B L. Raises UsageError for
    a file that cannot be read or has nothing for a direction that was asked for.
    """
    bsdf, findings = read_tensor(path, front)
    remarks = [f"{finding.where}: {finding.message}." for finding in findings.of("error", "warning")]
    distributions: list[Distribution] = []
    for name, scattering in bsdf.channels.items():
        if not isinstance(scattering, TreeScattering):
            remarks.append(f"{name}: is left out, its tree holds chromaticities: gonio query evaluates it.")
            continue
        dimensions = next(iter(scattering.trees.values())).dimensions
        for theta, phi in incident_deg or _usual(scattering, dimensions):
            distributions.append(_distribution(scattering, name, theta, phi, path.name))
    provenance = {**bsdf.provenance, "validity": list(bsdf.validity)}
    provenance["imported"] |= {
        "points": sum(len(d.theta_deg) for d in distributions),
        "values": "averages over cells of the tree, not values of directions: DSF = B L / Omega in the cells' middle",
        "uncertainty": f"none stated in the file; variance is that of rounding to {_DIGITS} digits",
    }
    return bsdf.as_dataset(distributions, provenance), remarks


def _usual(scattering: TreeScattering, dimensions: int) -> list[tuple[float, float]]:
    """The directions of `read_dataset` from which the tree has anything."""
    azimuths = [0.0] if dimensions == 3 else [360.0 / _AZIMUTHS * step for step in range(_AZIMUTHS)]
    return [
        (polar if front else 180.0 - polar, azimuth)
        for front in (True, False)
        if any(scattering.covers(incident_front=front, outgoing_front=to_front) for to_front in (True, False))
        for polar in _THETA_DEG
        for azimuth in (azimuths if polar > 0.0 else [0.0])
    ]


def _distribution(
    scattering: TreeScattering, channel: str, theta_i_deg: float, phi_i_deg: float, name: str
) -> Distribution:
    incident = unit_from_angles_deg([theta_i_deg], [phi_i_deg])
    source = turned(incident, scattering.front_faces)
    # The horizon belongs to the sample's front.
    lit_z = (1.0 if scattering.front_faces == "interior" else -1.0) * (1.0 if incident[0, 2] >= 0.0 else -1.0)
    parts = [
        _cells(component, tree, source) for component, tree in scattering.trees.items() if component.incident_z == lit_z
    ]
    if not parts:
        raise UsageError(f"{name}: has nothing for light from ({theta_i_deg:g}, {phi_i_deg:g}): leave it out")
    unit, bsdf, ratio, omega = (np.concatenate(column) for column in zip(*parts, strict=True))
    theta_deg, phi_deg = angles_deg_from_unit(turned(unit, scattering.front_faces))
    n = len(unit)
    dsf = bsdf * ratio
    return Distribution(
        incident_theta_deg=theta_i_deg,
        incident_phi_deg=phi_i_deg % 360.0,
        theta_deg=theta_deg,
        phi_deg=phi_deg,
        dsf_per_sr=dsf,
        variance_per_sr2=_rounding_variance(bsdf) * ratio**2,
        signal=dsf.copy(),
        normalisation=np.ones(n),
        count=np.ones(n, dtype=np.int32),
        flags=np.full(n, PointFlag.MEASURED, dtype=np.uint16),
        solid_angle_sr=omega,
        time_ns=np.zeros(n, dtype=np.int64),
        channel=channel,
        signal_unit="1/sr",
    )


def _cells(
    component: Component, tree: FlatTree, source: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Middles (m, 3), in Radiance's frame, of the cells of a direction (1, 3), their BSDF, L / Omega, Omega."""
    split = tree.dimensions - 2
    _, corner, level, bsdf = slices(tree, place_of(source, source, tree.dimensions)[:, :split])
    whole = level == 0  # a tree of one value: its centre is no middle of anything
    if whole.any():
        quarters = np.array([[0.0, 0.0], [0.5, 0.0], [0.0, 0.5], [0.5, 0.5]])
        corner, level, bsdf = quarters, np.ones(4, dtype=np.int64), np.repeat(bsdf, 4)
    ratio = np.empty(len(bsdf))  # Omega / L
    for own in np.unique(level).tolist():
        index = np.round(corner * (1 << own)).astype(np.int64)
        for diagonal in (True, False):
            at = np.flatnonzero((level == own) & (on_diagonal(index, own) == diagonal))
            if len(at):
                ratio[at] = cell_points(index[at], own, _GAUSS, diagonal=diagonal)[1].sum(axis=1)
    xy = disc_from_square(_middles(corner, level, 1.0 / ratio))
    if split == 1:  # directions of T3 are turned until -incident lies on +x; back again
        across = np.hypot(source[0, 0], source[0, 1])
        c, s = (-source[0, 0] / across, -source[0, 1] / across) if across > 1e-12 else (-1.0, 0.0)
        xy = np.stack((c * xy[:, 0] - s * xy[:, 1], s * xy[:, 0] + c * xy[:, 1]), axis=1)
    z = np.sqrt(np.maximum(1.0 - np.sum(xy**2, axis=1), 0.0))
    unit = np.concatenate((xy, component.outgoing_z * z[:, None]), axis=1)
    return unit, bsdf, 1.0 / ratio, np.pi * 0.25**level * ratio


def _middles(corner: FloatArray, level: NDArray[np.int64], cosine: FloatArray) -> FloatArray:
    """Places (m, 2) within the square's cells where cos(theta) is `cosine`, its mean over the cell's solid angle: there
    the DSF B L / Omega is also B cos(theta). The larger coordinate alone is sin(theta)."""
    pair = 2.0 * (corner + 0.5 * 0.5 ** level[:, None]) - 1.0
    size = np.abs(pair)
    radius = np.sqrt(np.maximum(1.0 - cosine**2, 0.0))[:, None]
    largest = size >= size.max(axis=1, keepdims=True) - 1e-12  # both on a diagonal
    return np.asarray(0.5 + 0.5 * np.where(largest, np.copysign(radius, pair), pair))


def _rounding_variance(values: FloatArray) -> FloatArray:
    weight = 10.0 ** (np.floor(np.log10(np.maximum(values, 1e-300))) + 1.0 - _DIGITS)
    return np.asarray(np.where(values > 0.0, weight**2 / 12.0, 0.0))
