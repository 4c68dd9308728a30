"""compared_data.py: small datasets for the tests of comparisons: equal cells, a known DSF, noise and effects drawn."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Distribution, PointFlag
from gonio.geometry.directions import angle_between_deg, angles_deg_from_unit, unit_from_angles_deg

FloatArray = NDArray[np.float64]
INCIDENT = (30.0, 0.0)


def lattice(count: int) -> FloatArray:
    """Fibonacci lattice, unit vectors (count, 3); every point has 4 pi / count."""
    k = np.arange(count) + 0.5
    z = 1.0 - 2.0 * k / count
    phi = np.pi * (1.0 + 5.0**0.5) * k
    r = np.sqrt(1.0 - z**2)
    return np.stack((r * np.cos(phi), r * np.sin(phi), z), axis=1)


def smooth_per_sr(unit: FloatArray) -> FloatArray:
    """A wide lobe about the mirror direction of INCIDENT on a white ground, over 0 everywhere."""
    apart = np.radians(angle_between_deg(unit, unit_from_angles_deg(30.0, 180.0)))
    return np.asarray(0.1 + 0.05 * unit[:, 2] + 2.0 * np.exp(-0.5 * (apart / np.radians(12.0)) ** 2))


def distribution(
    unit: FloatArray,
    dsf_per_sr: FloatArray,
    *,
    u_rel: float = 0.0,
    effects: Mapping[str, FloatArray] | None = None,
    incident: tuple[float, float] = INCIDENT,
    channel: str = "visible",
) -> Distribution:
    """Points (n, 3) with values (n,) and their independent relative uncertainty; nothing is drawn."""
    n = len(unit)
    theta, phi = angles_deg_from_unit(unit)
    return Distribution(
        *incident,
        theta_deg=theta,
        phi_deg=phi,
        dsf_per_sr=np.array(dsf_per_sr, dtype=np.float64),
        variance_per_sr2=(u_rel * np.asarray(dsf_per_sr)) ** 2,
        signal=np.asarray(dsf_per_sr) * 1e5,
        normalisation=np.ones(n),
        count=np.ones(n, dtype=np.int32),
        flags=np.zeros(n, dtype=np.uint16),
        solid_angle_sr=np.full(n, 4.0 * np.pi / n),
        time_ns=np.zeros(n, dtype=np.int64),
        channel=channel,
        p_i=1e5,
        effects=dict(effects or {}),
    )


def drawn(clean: Distribution, rng: np.random.Generator, causes: Mapping[str, float] | None = None) -> Distribution:
    """The distribution with its noise drawn and every effect moved by `causes` standard deviations, drawn if absent."""
    moved = clean.dsf_per_sr + np.sqrt(clean.variance_per_sr2) * rng.standard_normal(len(clean.theta_deg))
    for name, column in clean.effects.items():
        moved = moved + column * (causes or {}).get(name, rng.standard_normal())
    return replace(clean, dsf_per_sr=moved)


def masked(whole: Distribution, where: NDArray[np.bool_]) -> Distribution:
    """With the points `where` (n,) shadowed."""
    flags = np.where(where, np.uint16(PointFlag.SHADOWED), whole.flags).astype(np.uint16)
    return replace(whole, flags=flags, dsf_per_sr=np.where(where, np.nan, whole.dsf_per_sr))


def dataset(*distributions: Distribution, instrument: str | None = None) -> Dataset:
    """A dataset; `instrument` stands for the instrument file's text."""
    return Dataset(list(distributions), provenance={} if instrument is None else {"instrument_text": instrument})


def of(function: Callable[[FloatArray], FloatArray], unit: FloatArray, u_rel: float = 0.0) -> Distribution:
    """A distribution that takes its values from a function of direction."""
    return distribution(unit, function(unit), u_rel=u_rel)
