"""sharpened.py: a dataset of what is about one direction, with the beam's and the aperture's width taken out."""

from dataclasses import replace

import numpy as np

from gonio.dataset.bsdf import Dataset, Distribution, PointFlag
from gonio.dataset.effects import EFFECTS
from gonio.geometry.directions import unit_from_angles_deg
from gonio.reduce.coverage import cells_of_scattered
from gonio.reduce.signature.deconvolve import Deconvolved, deconvolve
from gonio.reduce.signature.profile import About
from gonio.units.errors import UsageError


def sharpened(dataset: Dataset, about: About, radius_deg: float) -> Dataset:
    """The disc of `radius_deg` about the mirror or the through direction of every incident direction, deconvolved
    (deconvolve.py): points of its grid, their noise as variance, what smoothing may hide as the effect `smoothing`.

    Each point is correlated with its neighbours: sums over them have less meaning than over what was measured, so none
    are made. Raises UsageError where the dataset holds no free beam, or nothing can be deconvolved.
    """
    if dataset.beam is None or not len(dataset.beam.theta_deg):
        raise UsageError("the dataset holds no scan of the free beam: its signature is unknown; reduce a raw log")
    distributions, records, left_out = [], [], []
    for distribution in dataset.distributions:
        where = f"{distribution.incident_theta_deg:g}/{distribution.incident_phi_deg:g}"
        try:
            found = deconvolve(distribution, dataset.beam, about, radius_deg)
        except ValueError as error:
            left_out.append(f"{where}: {error}")
            continue
        distributions.append(_of(distribution, found))
        records.append({"incident": where, "about": about, "radius_deg": radius_deg, **found.record()})
    if not distributions:
        raise UsageError(f"nothing to deconvolve: {'; '.join(left_out)}")
    notes = [*dataset.provenance.get("notes", []), *(f"not deconvolved: {reason}" for reason in left_out)]
    provenance = {**dataset.provenance, "deconvolved": records, "notes": notes}
    return replace(dataset, distributions=distributions, provenance=provenance)


def _of(distribution: Distribution, found: Deconvolved) -> Distribution:
    count = len(found.theta_deg)
    unit = unit_from_angles_deg(found.theta_deg, found.phi_deg)
    return Distribution(
        incident_theta_deg=distribution.incident_theta_deg,
        incident_phi_deg=distribution.incident_phi_deg,
        theta_deg=found.theta_deg,
        phi_deg=found.phi_deg,
        dsf_per_sr=found.dsf_per_sr,
        variance_per_sr2=found.noise_per_sr**2,
        signal=found.dsf_per_sr * distribution.p_i,
        normalisation=np.ones(count),
        count=np.ones(count, dtype=np.int32),
        flags=np.full(count, PointFlag.MEASURED, dtype=np.uint16),
        solid_angle_sr=cells_of_scattered(unit).solid_angle_sr,
        time_ns=np.zeros(count, dtype=np.int64),
        channel=distribution.channel,
        wavelength_nm=distribution.wavelength_nm,
        p_i=distribution.p_i,
        p_i_u_rel=distribution.p_i_u_rel,
        effects={EFFECTS["smoothing"].name: found.smoothing_per_sr},
    )
