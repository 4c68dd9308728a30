"""scatter_plane.py: both sides of a comparison in the plane of incidence, where paper [0] table 4 judges a model."""

import numpy as np
from numpy.typing import NDArray

from gonio.compare import metrics
from gonio.compare.judge import shares_within_percent
from gonio.compare.result import Metric, Profile, Region
from gonio.compare.values import Values, difference_u_per_sr
from gonio.geometry.directions import angles_deg_from_unit

FloatArray = NDArray[np.float64]

REACH_DEG, STEP_DEG = 85.0, 0.1


def plane_angles_deg() -> FloatArray:
    """-85 to 85 degrees in steps of 0.1, shape (1701,)."""
    half = round(REACH_DEG / STEP_DEG)
    return np.asarray(np.arange(-half, half + 1) * STEP_DEG)


def plane_directions(incident_theta_deg: float, incident_phi_deg: float, region: Region) -> FloatArray:
    """Unit vectors (1701, 3) of the plane's angles, on the side of the incident direction ("reflection") or not."""
    incident_up = incident_theta_deg <= 90.0
    normal = 1.0 if incident_up == (region == "reflection") else -1.0
    angle, phi = np.radians(plane_angles_deg()), np.radians(incident_phi_deg)
    across = -np.sin(angle)  # the mirror direction lies opposite the source
    return np.stack((across * np.cos(phi), across * np.sin(phi), normal * np.cos(angle)), axis=1)


def profile(region: Region, directions: FloatArray, a: Values, b: Values, floor_per_sr: float) -> Profile | None:
    """The profile with its CV(RMSD) and shares; None where the two have no angle in common. Values stand at
    `directions` (1701, 3)."""
    used = np.isfinite(a.dsf_per_sr) & np.isfinite(b.dsf_per_sr)
    if not used.any():
        return None
    a_dsf, b_dsf, u = a.dsf_per_sr[used], b.dsf_per_sr[used], difference_u_per_sr(a, b)[used]
    rmsd, explained, mean_a = metrics.rms(b_dsf - a_dsf), metrics.rms(u), metrics.mean(a_dsf)
    over = a_dsf >= floor_per_sr
    theta_deg, phi_deg = angles_deg_from_unit(directions)
    return Profile(
        region=region,
        angle_deg=plane_angles_deg(),
        theta_deg=theta_deg,
        phi_deg=phi_deg,
        a_per_sr=a.dsf_per_sr,
        b_per_sr=b.dsf_per_sr,
        u_a_per_sr=a.u_per_sr,
        u_b_per_sr=b.u_per_sr,
        used=used,
        cv_rmsd=Metric(
            value=metrics.cv_rmsd(rmsd, mean_a),
            from_uncertainty=metrics.cv_rmsd(explained, mean_a),
            in_u=rmsd / explained if rmsd is not None and explained else None,
        ),
        within_percent=shares_within_percent(a_dsf[over], b_dsf[over]),
        under_floor=int((~over).sum()),
    )
