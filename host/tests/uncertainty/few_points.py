"""few_points.py: nine points with four shared errors, small enough to be judged point by point."""

import numpy as np

from gonio.dataset.bsdf import Distribution, PointFlag

N = 9
EFFECTS = ("lamp", "p_i", "axis arm azimuth", "stray_light")


def distribution(seed: int) -> Distribution:
    """Nine points with four shared errors; the last one is masked."""
    rng = np.random.default_rng(seed)
    dsf = rng.uniform(0.05, 0.4, N)
    flags = np.zeros(N, dtype=np.uint16)
    flags[-1] = PointFlag.SHADOWED
    dsf[-1] = np.nan
    variance = (0.02 * dsf) ** 2
    effects = {
        "lamp": 5e-3 * dsf,
        "p_i": -8e-3 * dsf,
        "axis arm azimuth": 4e-3 * rng.standard_normal(N) + 0.0 * dsf,
        "stray_light": 1e-3 + 0.0 * dsf,
    }
    return Distribution(
        incident_theta_deg=30.0,
        incident_phi_deg=0.0,
        theta_deg=np.linspace(0.0, 80.0, N),
        phi_deg=np.full(N, 180.0),
        dsf_per_sr=dsf,
        variance_per_sr2=variance,
        signal=np.ones(N),
        normalisation=np.ones(N),
        count=np.ones(N, dtype=np.int32),
        flags=flags,
        solid_angle_sr=rng.uniform(0.1, 0.5, N),
        time_ns=np.zeros(N, dtype=np.int64),
        effects=effects,
    )
