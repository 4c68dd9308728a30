"""dataset.py: a dataset from a WINDOW file: one distribution per incident patch, a point per outgoing patch."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Distribution, PointFlag, Side
from gonio.formats.window.klems import KlemsBasis, LightSide, Process, to_radiance_deg
from gonio.formats.window.matrices import PROCESSES, SIDES, Band
from gonio.formats.window.read import WindowBsdf, read
from gonio.formats.window.scattering import KlemsScattering, bsdf_of
from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]


def read_dataset(path: Path, front: Side | None = None) -> tuple[Dataset, list[str]]:
    """A dataset of all bands (channels visible, solar, ...) and remarks, one sentence each.

    Points stand at the patches' nominal centres with the patches' solid angles Omega, and DSF = B L / Omega: their sums
    are the file's, sum B L. The variance is that of rounding to the last written digit. Matrices and columns of zeros
    that stand for nothing measured give no points. `front` as in scattering.window_bsdf. Raises UsageError for a
    file that cannot be read or holds zeros only.
    """
    window = read(path, with_rounding=True)
    bsdf, findings = bsdf_of(window, front)
    distributions: list[Distribution] = []
    remarks = [f"{finding.where}: {finding.message}." for finding in findings.of("error", "warning")]
    for scattering in bsdf.channels.values():
        if not isinstance(scattering, KlemsScattering):
            raise TypeError("a WINDOW file holds matrices")
        made, empty = _band(window, scattering)
        distributions += made
        if empty:
            remarks.append(f"{scattering.band}: {empty} incident patches hold zeros only: left out as not measured.")
    if not distributions:
        raise UsageError(f"{path.name}: all its matrices are zeros: nothing was measured")
    provenance = {**bsdf.provenance, "validity": list(bsdf.validity)}
    provenance["imported"] |= {
        "points": sum(len(d.theta_deg) for d in distributions),
        "values": "averages over pairs of patches, not values of directions: DSF = B L / Omega at the patches' centres",
        "uncertainty": "none stated in the file; variance is that of rounding to the last digit",
    }
    return bsdf.as_dataset(distributions, provenance), remarks


def solid_angle_sr(basis: KlemsBasis) -> FloatArray:
    """Plain solid angle of each patch (size,)."""
    lower, upper, _, width = np.radians(basis.bounds_deg).T
    return np.asarray((np.cos(lower) - np.cos(upper)) * width)


def _band(window: WindowBsdf, scattering: KlemsScattering) -> tuple[list[Distribution], int]:
    """Distributions of one band, and how many incident patches were left out."""
    basis, faces = window.basis, scattering.front_faces
    made, empty = [], 0
    for side in SIDES:
        there = [process for process in PROCESSES if _covered(scattering, process, side)]
        for column in range(basis.size if there else 0):
            if not any(window.matrices[scattering.band, process, side][:, column].any() for process in there):
                empty += 1
                continue
            made.append(_distribution(window, scattering.band, side, there, column, faces, scattering.channel))
    return made, empty


def _covered(scattering: KlemsScattering, process: Process, side: LightSide) -> bool:
    lit_front = (side == "Back") == (scattering.front_faces == "interior")
    return scattering.covers(incident_front=lit_front, outgoing_front=lit_front == (process == "Reflection"))


def _distribution(
    window: WindowBsdf,
    band: Band,
    side: LightSide,
    processes: list[Process],
    column: int,
    faces: Side,
    channel: str,
) -> Distribution:
    basis = window.basis
    polar, azimuth = basis.centres_deg.T
    from_exterior = side == "Front"
    polar_i, azimuth_i = basis.centres_deg[column]
    incident = to_radiance_deg(180.0 - polar_i if from_exterior else polar_i, azimuth_i + 180.0, faces)
    theta, phi, dsf, variance = [], [], [], []
    ratio = basis.projected_solid_angle_sr / solid_angle_sr(basis)
    for process in processes:
        to_interior = from_exterior == (process == "Transmission")
        theta_o, phi_o = to_radiance_deg(polar if to_interior else 180.0 - polar, azimuth, faces)
        theta.append(theta_o)
        phi.append(phi_o)
        dsf.append(window.matrices[band, process, side][:, column] * ratio)
        variance.append(window.rounding[band, process, side][:, column] * ratio**2)
    values = np.concatenate(dsf)
    n = len(values)
    return Distribution(
        incident_theta_deg=float(incident[0]),
        incident_phi_deg=float(incident[1]) if polar_i > 0.0 else 0.0,
        theta_deg=np.concatenate(theta),
        phi_deg=np.concatenate(phi),
        dsf_per_sr=values,
        variance_per_sr2=np.concatenate(variance),
        signal=values.copy(),
        normalisation=np.ones(n),
        count=np.ones(n, dtype=np.int32),
        flags=np.full(n, PointFlag.MEASURED, dtype=np.uint16),
        solid_angle_sr=np.tile(solid_angle_sr(basis), len(processes)),
        time_ns=np.zeros(n, dtype=np.int64),
        channel=channel,
        signal_unit="1/sr",
    )
