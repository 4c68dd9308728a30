"""free_beam.py: P_i from a scan of the unobstructed beam that another instrument wrote."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from gonio.dataset.bsdf import Distribution, PointFlag
from gonio.formats.pab.text import PabFile
from gonio.geometry.cells import covered_cells_sr
from gonio.geometry.directions import angles_deg_from_unit, tangent_frame, unit_from_angles_deg
from gonio.units.errors import UsageError

EDGE = 0.9  # of the scan's radius: what is read farther out is skirt or offset
WIDEST_DEG = 45.0  # a scan that reaches farther from its own centre is no beam


@dataclass(frozen=True)
class FreeBeam:
    """P_i [signal sr], its relative standard uncertainty, and the scan about the beam's own axis."""

    p_i: float
    p_i_u_rel: float
    scan: Distribution
    provenance: dict[str, Any]


def free_beam(file: PabFile, unit: str) -> FreeBeam:
    """P_i = sum E_j Omega_j over the points of a scan, whose cells end where the points do.

    Nothing is subtracted. The stated uncertainty is what the scan's border still reads, taken over the whole scan: an
    offset or a skirt that the scan cut off. Raises UsageError where the scan is no beam.
    """
    vectors = unit_from_angles_deg(file.theta_deg, file.phi_deg)
    signal = file.values[:, 0]
    omega, _ = covered_cells_sr(vectors)
    p_i = float(signal @ omega)
    if not p_i > 0.0:
        raise UsageError(f"{file.name}: P_i is {p_i:g}: the scan of the free beam saw no light or is a single line")
    axis = (signal * omega) @ vectors
    length = float(np.linalg.norm(axis))
    if not length > 0.0:
        raise UsageError(f"{file.name}: the light has no direction: this is no scan of a free beam")
    axis /= length
    e1, e2, _ = tangent_frame(axis)
    across = np.hypot(vectors @ e1, vectors @ e2)
    polar = np.arctan2(across, vectors @ axis)
    widest_deg = float(np.degrees(polar.max()))
    if widest_deg > WIDEST_DEG:
        raise UsageError(
            f"{file.name}: reaches {widest_deg:.0f} degrees from the beam's axis: this is no scan of a beam"
        )
    edge = polar > EDGE * polar.max()
    rest = float(omega[edge].sum())
    skirt = float(signal[edge] @ omega[edge]) / rest * float(omega.sum()) if rest > 0.0 else 0.0
    theta_deg, phi_deg = angles_deg_from_unit(axis)
    azimuth_deg = np.mod(np.degrees(np.arctan2(vectors @ e2, vectors @ e1)), 360.0)
    n = len(signal)
    u_rel = abs(skirt) / p_i
    scan = Distribution(
        incident_theta_deg=0.0,
        incident_phi_deg=0.0,
        theta_deg=np.degrees(polar),
        phi_deg=azimuth_deg,
        dsf_per_sr=signal / p_i,
        variance_per_sr2=np.zeros(n),
        signal=signal,
        normalisation=np.ones(n),
        count=np.ones(n, dtype=np.int32),
        flags=np.full(n, PointFlag.MEASURED, dtype=np.uint16),
        solid_angle_sr=omega,
        time_ns=np.zeros(n, dtype=np.int64),
        p_i=p_i,
        p_i_u_rel=u_rel,
        signal_unit=unit,
    )
    facts = {
        "file": file.name,
        "sha256": file.sha256,
        "points": n,
        "p_i": p_i,
        "p_i_u_rel": u_rel,
        "axis_deg": [float(theta_deg), float(phi_deg)],
    }
    return FreeBeam(p_i, u_rel, scan, facts)
