"""energy.py: no incident patch of a model's matrices may send out more light than it receives."""

import numpy as np

from gonio.dataset.scattering import FloatArray, IndexArray, MeasuredIntegral
from gonio.formats.findings import Findings
from gonio.formats.patches.hemispheres import Component
from gonio.formats.window.klems import KlemsBasis, LightSide
from gonio.formats.window.matrices import PROCESSES, Band, MatrixSet
from gonio.geometry.directions import unit_from_angles_deg
from gonio.units.errors import CheckFailed

ROUNDING = 1e-6
_COVERAGE = 2.0  # k of the uncertainty within which an excess is let pass


def check_side(
    block: MatrixSet,
    basis: KlemsBasis,
    band: Band,
    component: Component,
    measured: list[MeasuredIntegral],
    findings: Findings,
    *,
    isotropic: bool,
    rescale: bool,
) -> None:
    """Transmission and reflection of light that arrives at the component's side, patch by patch.

    An excess over 1 within k = 2 of its uncertainty, which is relatively that of the `measured` integrals nearest to
    the patch, becomes a finding; beyond it CheckFailed names side, column and sum. `rescale`: patches over 1 are scaled
    to 1 instead, each recorded.
    """
    side = component.side
    total = sum((basis.projected_solid_angle_sr @ block.matrices[p, side] for p in PROCESSES), np.zeros(basis.size))
    over = np.flatnonzero(total > 1.0 + ROUNDING)
    if not len(over):
        return
    if rescale:
        for process in PROCESSES:
            block.matrices[process, side][:, over] /= total[over]
        findings.add("warning", "rescaled", f"{band} {side}", _scaled(band, side, over, total))
        return
    polar, azimuth = np.radians(basis.centres_deg[over].T)
    u = total[over] * _relative_u(component.incident(polar, azimuth), measured, isotropic)
    worst = int(np.argmax(total[over] - 1.0 - _COVERAGE * u))
    column = int(over[worst])
    what = (
        f"{band} {side}, incident patch {column + 1} (theta {basis.centres_deg[column, 0]:g}, column azimuth "
        f"{basis.centres_deg[column, 1]:g}): transmission plus reflection sum to {total[column]:.4f}"
    )
    if total[column] > 1.0 + _COVERAGE * u[worst]:
        raise CheckFailed(
            f"{what}, over 1 by more than twice its uncertainty {u[worst]:.4f} ({len(over)} patches are over 1); check "
            "the reference scan, or give --rescale"
        )
    column = int(np.argmax(total))
    message = (
        f"{band} {side}: transmission plus reflection of {len(over)} incident patches sum to more than 1, at most "
        f"{total[column]:.4f} (patch {column + 1}), within twice their uncertainty; written as they are."
    )
    findings.add("warning", "energy", f"{band} {side}", message)


def _scaled(band: Band, side: LightSide, over: IndexArray, total: FloatArray) -> str:
    factors = [f"{1.0 / total[column]:.4f}" for column in over]
    runs: list[tuple[int, int, str]] = []
    for column, factor in zip(over.tolist(), factors, strict=True):
        if runs and runs[-1][1] == column and runs[-1][2] == factor:
            runs[-1] = (runs[-1][0], column + 1, factor)
        else:
            runs.append((column + 1, column + 1, factor))
    named = "; ".join(f"{a if a == b else f'{a}-{b}'}: {factor}" for a, b, factor in runs)
    return f"{band} {side}: incident patches over 1 were scaled (--rescale), patch: factor {named}."


def _relative_u(incident: FloatArray, measured: list[MeasuredIntegral], isotropic: bool) -> FloatArray:
    """Relative standard uncertainty (n,) of the sum of the measured integrals nearest to directions (n, 3), of
    isotropic samples nearest in theta; 0 if none."""
    own = [m for m in measured if m.value > 0.0]
    if not own:
        return np.zeros(len(incident))
    unit = unit_from_angles_deg(
        np.array([m.incident_theta_deg for m in own]), np.array([m.incident_phi_deg for m in own])
    )
    if isotropic:
        unit, incident = (
            np.stack((np.hypot(v[:, 0], v[:, 1]), 0.0 * v[:, 1], v[:, 2]), axis=1) for v in (unit, incident)
        )
    cosine = incident @ unit.T
    near = cosine >= cosine.max(axis=1, keepdims=True) - 1e-9
    value, u = np.array([m.value for m in own]), np.array([m.u for m in own])
    return np.asarray(np.sqrt(near @ u**2) / (near @ value))
