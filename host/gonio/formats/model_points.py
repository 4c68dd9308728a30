"""model_points.py: a model's values as points of a dataset, for formats that hold points."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Distribution, PointFlag
from gonio.dataset.scattering import Bsdf, Scattering
from gonio.geometry.directions import unit_from_angles_deg
from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]

DEFAULT_STEP_DEG = 2.5


def measured_incidents(bsdf: Bsdf) -> list[tuple[float, float]]:
    """Incident directions (theta, phi) [deg] that the model rests on. UsageError where it does not say them."""
    found = sorted({(m.incident_theta_deg, m.incident_phi_deg) for m in bsdf.measured})
    if not found:
        raise UsageError("the model does not say which incident directions were measured: give --incident THETA,PHI")
    return found


def sampled(
    bsdf: Bsdf,
    incidents: Sequence[tuple[float, float]],
    *,
    step_deg: float = DEFAULT_STEP_DEG,
    channel: str | None = None,
) -> Dataset:
    """Values of all channels, or of one, for these incident directions (theta, phi) [deg] on a regular grid: rows at
    odd halves of the step in theta, columns at its multiples in phi. Solid angles are those of the grid's cells.

    Points are flagged as simulated and have no uncertainty. Hemispheres that the model does not have are left out.
    UsageError for an unknown channel and a step that does not divide 90 degrees.
    """
    if channel is not None and channel not in bsdf.channels:
        raise UsageError(f"no channel {channel!r}; there is {', '.join(bsdf.channels)}")
    if not 0.1 <= step_deg <= 30.0 or abs(90.0 / step_deg - round(90.0 / step_deg)) > 1e-9:
        raise UsageError(f"a step of {step_deg:g} degrees does not divide 90 degrees (0.1 to 30)")
    edges = np.linspace(0.0, 180.0, 2 * round(90.0 / step_deg) + 1)
    columns = round(360.0 / step_deg)
    theta, phi = (
        grid.ravel()
        for grid in np.meshgrid(0.5 * (edges[1:] + edges[:-1]), np.arange(columns) * step_deg, indexing="ij")
    )
    cell = np.repeat(-np.diff(np.cos(np.radians(edges))) * np.radians(step_deg), columns)
    names = list(bsdf.channels) if channel is None else [channel]
    parts = [
        replace(part, wavelength_nm=_wavelength_nm(bsdf, name))
        for name in names
        for incident in incidents
        if (part := _distribution(bsdf.channels[name], name, incident, theta, phi, cell)) is not None
    ]
    if not parts:
        raise UsageError("the model has no value for any of these incident directions")
    sampled_at = {"step_deg": step_deg, "incident_deg": [list(i) for i in incidents]}
    return bsdf.as_dataset(parts, {"sampled": sampled_at})


def _wavelength_nm(bsdf: Bsdf, channel: str) -> float | None:
    """Of a channel of one wavelength."""
    low, high = bsdf.band_nm.get(channel, (0.0, 1.0))
    return low if low == high else None


def _distribution(
    scattering: Scattering,
    name: str,
    incident: tuple[float, float],
    theta: FloatArray,
    phi: FloatArray,
    cell_sr: FloatArray,
) -> Distribution | None:
    source = unit_from_angles_deg(np.array([incident[0]]), np.array([incident[1]]))
    values = scattering.dsf_per_sr(source, unit_from_angles_deg(theta, phi))
    there = np.isfinite(values)
    n = int(np.count_nonzero(there))
    if n == 0:
        return None
    return Distribution(
        *incident,
        theta_deg=theta[there],
        phi_deg=phi[there],
        dsf_per_sr=values[there],
        variance_per_sr2=np.full(n, np.nan),
        signal=values[there].copy(),
        normalisation=np.ones(n),
        count=np.zeros(n, dtype=np.int32),
        flags=np.full(n, PointFlag.SIMULATED, dtype=np.uint16),
        solid_angle_sr=cell_sr[there],
        time_ns=np.zeros(n, dtype=np.int64),
        channel=name,
        p_i=1.0,
    )
