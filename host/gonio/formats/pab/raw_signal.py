"""raw_signal.py: points that are not normalised have no place in formats that hold a DSF or BSDF."""

from collections.abc import Iterable

import numpy as np

from gonio.dataset.bsdf import Distribution
from gonio.units.errors import UsageError


def refuse_raw(distributions: Iterable[Distribution]) -> None:
    """UsageError where a distribution holds a raw signal; only pab text can say what that is."""
    for d in distributions:
        if np.isnan(d.p_i):
            raise UsageError(
                f"incident {d.incident_theta_deg:g}/{d.incident_phi_deg:g}: the points are a raw signal (unit "
                f"{d.signal_unit}), not normalised: import them again with --beam or --p-i, or export --format pab"
            )
