"""imported.py: cells and integrals for points that were not flown here."""

from dataclasses import replace

import numpy as np

from gonio.dataset.bsdf import Dataset, Distribution
from gonio.geometry.directions import unit_from_angles_deg
from gonio.reduce.coverage import REACH_FACTOR, cells_of_scattered
from gonio.reduce.integrals.hemispheres import evaluated


def reduce_dataset(dataset: Dataset, reach_factor: float = REACH_FACTOR) -> Dataset:
    """Cells, as far as `reach_factor` times the points' spacing, and integrals with their uncertainties. The DSF stays
    as it is. Points that have cells (reduced, simulated) are left alone, with all that was found in them; so are those
    that nothing has normalised yet: they get cells only."""
    if all(distribution.solid_angle_sr.any() for distribution in dataset.distributions):
        return dataset
    distributions = [_with_cells(distribution, dataset.beam, reach_factor) for distribution in dataset.distributions]
    step = {
        "name": "cells",
        "applied": True,
        "what": "cells and integrals of the points as imported",
        "parameters": {"reach_factor": reach_factor},
    }
    steps = [*dataset.provenance.get("corrections", []), step]
    return replace(dataset, distributions=distributions, provenance={**dataset.provenance, "corrections": steps})


def _with_cells(distribution: Distribution, beam: Distribution | None, reach_factor: float) -> Distribution:
    unit = unit_from_angles_deg(distribution.theta_deg, distribution.phi_deg)
    found = cells_of_scattered(unit, reach_factor)
    with_cells = replace(
        distribution,
        solid_angle_sr=found.solid_angle_sr,
        linear_solid_angle_sr=found.linear_sr,
        integrals={},
        budgets={},
    )
    evaluated(with_cells, np.abs(found.moment[:, 2]), beam).into(with_cells)
    return with_cells
