"""test_tensor_two_peaks.py: Radiance reads a lopsided sample's tree of four dimensions: averages over its cells."""

from pathlib import Path

import numpy as np
import pytest
from lopsided import ask_radiance, concentric_disc, midpoints, unit_of

from benchmarks.models.samples import Facet, TwoPeaked
from gonio.dataset.scattering import Bsdf
from gonio.formats.tensor.square import square_from_disc
from gonio.formats.tensor.write import write_tensor
from gonio.geometry.directions import angles_deg_from_unit, unit_from_angles_deg

pytestmark = pytest.mark.judge
LEVEL = 3  # of which all cells are written: finer trees take minutes
READING = 5e-4  # Radiance perturbs what it reads by about 2e-4
SUMS = 2e-3  # what the plain sums leave


def test_two_peaks_of_facets(tmp_path: Path) -> None:
    """On both lobes and beside them, for light from four sides: up and down, left and right told apart."""
    truth = TwoPeaked(facets=(Facet(3.0, 2.4, 9.0), Facet(-14.0, 1.2, 10.0)))
    path = tmp_path / "two.xml"
    bsdf = Bsdf({"visible": truth}, front_faces="interior", symmetry="bilateral")
    write_tensor(bsdf, path, dimensions=4, resolution=LEVEL, leaves=16**LEVEL)
    queries, expected = [], []
    for theta_i, phi_i in ((20.0, 10.0), (19.0, 100.0), (33.0, 200.0), (22.0, 280.0)):
        source = unit_from_angles_deg([theta_i], [phi_i])
        lobes = np.concatenate([facet.centre(source) for facet in truth.facets])
        for leaving in (*lobes, lobes.sum(axis=0), unit_from_angles_deg(25.0, phi_i)):
            out = leaving / np.linalg.norm(leaving)
            theta_o, phi_o = angles_deg_from_unit(out[None])
            queries.append([theta_i, phi_i, float(theta_o[0]), float(phi_o[0])])
            cell_i = np.floor(square_from_disc(-source[0, :2]) * (1 << LEVEL)).astype(np.int64)
            cell_o = np.floor(square_from_disc(out[:2]) * (1 << LEVEL)).astype(np.int64)
            incident = unit_of(-concentric_disc(midpoints(cell_i, LEVEL, 10)), 1.0)
            outgoing = np.tile(unit_of(concentric_disc(midpoints(cell_o, LEVEL, 20)), 1.0), (100, 1))
            dsf = truth.dsf_per_sr(incident, outgoing, np.repeat(np.arange(100), 400))
            expected.append(float(np.mean(dsf / outgoing[:, 2])))
    found = np.array(ask_radiance(path, queries)["values"])
    np.testing.assert_allclose(found, expected, rtol=READING + SUMS)
    assert np.std(expected) > 0.3 * np.mean(expected)
