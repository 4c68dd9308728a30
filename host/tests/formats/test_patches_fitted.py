"""test_patches_fitted.py: patch averages of a fitted anisotropic model, whose grids have kinks, by plain sums."""

import numpy as np
import pytest
from synthetic_bsdf import distribution, sphere_points

from benchmarks.models.samples import Facet, TwoPeaked
from gonio.dataset.bsdf import Dataset, PointFlag
from gonio.dataset.scattering import FloatArray
from gonio.formats.patches import pairs
from gonio.formats.patches.hemispheres import Component
from gonio.formats.window.klems import BASES
from gonio.geometry.directions import unit_from_angles_deg
from gonio.model.fitted import fit_bsdf

BASIS = BASES["klems-quarter"]
TOLERANCE = 1e-4


@pytest.fixture(scope="module")
def component() -> Component:
    truth = TwoPeaked(facets=(Facet(3.0, 12.0, 5.0), Facet(-4.0, 2.0, 8.0)))
    units = sphere_points(5000)
    below = units[:, 2] < 0.0
    parts = []
    for incident in ((5.0, 0.0), (45.0, 0.0), (45.0, 90.0), (45.0, 180.0), (45.0, 270.0)):
        source = unit_from_angles_deg([incident[0]], [incident[1]])
        values = np.nan_to_num(truth.dsf_per_sr(source, units))
        parts.append(distribution(incident, units, lambda _, v=values: v + 1e-6))
        parts[-1].flags[below] = PointFlag.SHADOWED
    model = fit_bsdf(Dataset(parts, front_faces="interior", symmetry="none"))
    return Component(model.channels["visible"], "Reflection", "Back", "interior")


def by_midpoints(component: Component, column: int, inner: int, outer: int) -> FloatArray:
    """Averages (size,) of a column by the midpoints of inner^2 parts of its patch and outer^2 of every other one."""
    step, fine = (np.arange(inner) + 0.5) / inner, (np.arange(outer) + 0.5) / outer
    low, high, start, width = np.radians(BASIS.bounds_deg[column])
    polar, azimuth = (g.ravel() for g in np.meshgrid(low + (high - low) * step, start + width * step, indexing="ij"))
    share = np.sin(polar) * np.cos(polar) * (high - low) * width / inner**2
    bounds = np.radians(BASIS.bounds_deg)[:, :, None, None]
    polar_o = bounds[:, 0] + (bounds[:, 1] - bounds[:, 0]) * fine[:, None] + 0.0 * fine
    azimuth_o = bounds[:, 2] + bounds[:, 3] * fine + 0.0 * fine[:, None]
    area = np.sin(polar_o) * (bounds[:, 1] - bounds[:, 0]) * bounds[:, 3] / outer**2
    leaving = component.outgoing(polar_o.ravel(), azimuth_o.ravel())
    found = np.zeros(BASIS.size)
    which = np.zeros(len(leaving), dtype=np.int64)
    for row, weight in zip(component.incident(polar, azimuth), share, strict=True):
        values = component.values(row[None], leaving, which).reshape(area.shape)
        found += weight * (values * area).sum(axis=(1, 2))
    size = BASIS.projected_solid_angle_sr
    return np.asarray(found / size / size[column])


def test_columns_of_a_fitted_model_are_within_their_tolerance(component: Component) -> None:
    """Midpoints' error falls with the square of the step: two steps give the limit, and what it is worth."""
    columns = np.array([0, 5, 24])
    found, error = pairs.matrix(component, BASIS, TOLERANCE, columns)
    size = BASIS.projected_solid_angle_sr
    for column in columns.tolist():
        coarse, fine = by_midpoints(component, column, 5, 12), by_midpoints(component, column, 10, 24)
        exact = (4.0 * fine - coarse) / 3.0
        light = float(size @ exact)
        assert abs(float(size @ (found[:, column] - exact))) < TOLERANCE * light
        assert error[column] < TOLERANCE * light
        # Of the cells the sums themselves are known less well.
        assert float(size @ np.abs(found[:, column] - exact)) < 1e-3 * light
