"""test_tensor_radiance.py: Radiance reads our tensor trees: every value is the truth's exact average over its cell."""

import re
from pathlib import Path

import numpy as np
import pytest
from lopsided import Lopsided, ask_radiance, concentric_disc, midpoints, unit_of

from benchmarks.models.samples import RetroCoating
from gonio.dataset.bsdf import Side
from gonio.dataset.scattering import Bsdf, FloatArray
from gonio.formats.tensor.read import read_tensor
from gonio.formats.tensor.square import square_from_disc
from gonio.formats.tensor.write import write_tensor
from gonio.geometry.directions import angles_deg_from_unit, unit_from_angles_deg

pytestmark = pytest.mark.judge
READING = 5e-4  # Radiance perturbs what it reads by about 2e-4


def to_sample(unit: FloatArray, front_faces: Side) -> FloatArray:
    """From Radiance's frame: half a turn about y where the front faces the exterior."""
    return unit if front_faces == "interior" else unit * np.array([-1.0, 1.0, -1.0])


@pytest.mark.parametrize("front_faces", ["exterior", "interior"])
def test_an_asymmetric_sample_in_all_four_components(tmp_path: Path, front_faces: Side) -> None:
    truth = Lopsided()
    path = tmp_path / "t4.xml"
    level = 3
    write_tensor(
        Bsdf({"visible": truth}, front_faces=front_faces), path, dimensions=4, resolution=level, leaves=4 * 8**4
    )
    directions = [(40.0, 30.0), (25.0, 200.0), (62.0, 285.0)]
    queries, expected = [], []
    for theta_i, phi_i in directions:
        for lit in (-1.0, 1.0):
            for out in (-1.0, 1.0):
                for theta_o, phi_o in ((35.0, 100.0), (50.0, 340.0), (12.0, 215.0)):
                    angles = [
                        theta_i if lit > 0 else 180 - theta_i,
                        phi_i,
                        theta_o if out > 0 else 180 - theta_o,
                        phi_o,
                    ]
                    queries.append(angles)
                    source, leaving = unit_from_angles_deg([angles[0], angles[2]], [phi_i, phi_o])
                    # The incident pair is negated; both cells are squares of equal projected solid angle.
                    cell_i = np.floor(square_from_disc(-source[:2]) * (1 << level)).astype(np.int64)
                    cell_o = np.floor(square_from_disc(leaving[:2]) * (1 << level)).astype(np.int64)
                    incident = unit_of(-concentric_disc(midpoints(cell_i, level, 10)), lit)
                    outgoing = unit_of(concentric_disc(midpoints(cell_o, level, 30)), out)
                    which = np.repeat(np.arange(100), 900)
                    every = np.tile(outgoing, (100, 1))
                    dsf = truth.dsf_per_sr(to_sample(incident, front_faces), to_sample(every, front_faces), which)
                    expected.append(float(np.mean(dsf / np.abs(every[:, 2]))))
    found = np.array(ask_radiance(path, queries)["values"])
    np.testing.assert_allclose(found, expected, rtol=READING + 3e-4)  # and what the plain sum leaves
    assert np.std(expected) > 0.5 * np.mean(expected)
    # Our own reader, in the sample's frame, to the last digit that Radiance leaves alone.
    bsdf, findings = read_tensor(path)
    assert not findings.items
    assert bsdf.front_faces == front_faces
    angles = np.array(queries)
    source = to_sample(unit_from_angles_deg(angles[:, 0], angles[:, 1]), front_faces)
    leaving = to_sample(unit_from_angles_deg(angles[:, 2], angles[:, 3]), front_faces)
    own = bsdf.channels["visible"].dsf_per_sr(source, leaving, np.arange(len(source)))
    np.testing.assert_allclose(own / np.abs(leaving[:, 2]), found, rtol=READING)


@pytest.mark.parametrize("front_faces", ["exterior", "interior"])
def test_an_isotropic_sample_in_three_dimensions(tmp_path: Path, front_faces: Side) -> None:
    truth = RetroCoating(retro_sigma_deg=8.0, retro_per_sr=3.0)
    path = tmp_path / "t3.xml"
    level = 5
    bsdf = Bsdf({"visible": truth}, front_faces=front_faces, symmetry="isotropic")
    write_tensor(bsdf, path, dimensions=3, resolution=level, leaves=1 << 14)
    lit = -1.0 if front_faces == "exterior" else 1.0
    queries, expected = [], []
    for theta_i, phi_i in ((33.0, 0.0), (58.0, 130.0), (12.0, 250.0)):
        for aside in (0.0, 20.0, 100.0, 178.0, 250.0):
            for theta_o in (10.0, 31.0, 55.0):
                angles = [theta_i, phi_i, theta_o, (phi_i + aside) % 360.0]
                if lit < 0:
                    angles = [180.0 - angles[0], angles[1], 180.0 - angles[2], angles[3]]
                queries.append(angles)
                # Turned about z until the light comes from -x, and -incident lies on +x.
                at = unit_from_angles_deg(theta_o, 180.0 + aside)
                cell_o = np.floor(square_from_disc(at[:2]) * (1 << level)).astype(np.int64)
                cell_i = np.floor((0.5 - 0.5 * np.sin(np.radians(theta_i))) * (1 << level))
                ring = 1.0 - 2.0 * (cell_i + (np.arange(40) + 0.5) / 40) / (1 << level)
                incident = unit_of(np.stack((-ring, 0 * ring), axis=1), lit)
                outgoing = unit_of(concentric_disc(midpoints(cell_o, level, 20)), lit)
                which = np.repeat(np.arange(40), 400)
                every = np.tile(outgoing, (40, 1))
                dsf = truth.dsf_per_sr(to_sample(incident, front_faces), to_sample(every, front_faces), which)
                share = np.repeat(ring / ring.sum(), 400) / 400
                expected.append(float(np.sum(share * dsf / np.abs(every[:, 2]))))
    found = np.array(ask_radiance(path, queries)["values"])
    np.testing.assert_allclose(found, expected, rtol=READING + 3e-4)
    own, _ = read_tensor(path)
    angles = np.array(queries)
    source = to_sample(unit_from_angles_deg(angles[:, 0], angles[:, 1]), front_faces)
    leaving = to_sample(unit_from_angles_deg(angles[:, 2], angles[:, 3]), front_faces)
    values = own.channels["visible"].dsf_per_sr(source, leaving, np.arange(len(source))) / np.abs(leaving[:, 2])
    np.testing.assert_allclose(values, found, rtol=READING)


def test_the_retro_coating_of_the_judges(tmp_path: Path) -> None:
    """A small file of k = 8: peak, scatter plane and hemispherical value through Radiance."""
    truth = RetroCoating()
    bsdf = Bsdf({"visible": truth}, front_faces="interior", symmetry="isotropic")
    path = tmp_path / "retro.xml"
    write_tensor(bsdf, path, dimensions=3, resolution=8, size_mb=1.0)
    assert 0.9e6 < path.stat().st_size <= 1.0e6
    signed = np.radians(np.arange(-850, 851, 5) / 10.0)
    outgoing = np.stack((-np.sin(signed), 0.0 * signed, np.cos(signed)), axis=1)
    theta, phi = angles_deg_from_unit(outgoing)
    polar, azimuth = np.meshgrid(
        (np.arange(900) + 0.5) * np.pi / 1800, (np.arange(900) + 0.5) * np.pi / 450, indexing="ij"
    )
    sphere = np.stack((np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)), axis=-1)
    for theta_i in (30.0, 45.0, 60.0):
        incident = unit_from_angles_deg([theta_i], [0.0])
        expected = truth.dsf_per_sr(incident, outgoing)
        queries = [[theta_i, 0.0, float(t), float(p)] for t, p in zip(theta, phi, strict=True)]
        answer = ask_radiance(path, queries, [[theta_i, 0.0]])
        found = np.array(answer["values"]) * outgoing[:, 2]
        assert found.max() > 0.88 * expected.max()
        assert np.sqrt(np.mean((found - expected) ** 2)) / expected.mean() < 1.5
        assert np.mean(np.abs(found - expected) <= 0.1 * expected) > 0.88
        light = (
            np.sum(truth.dsf_per_sr(incident, sphere.reshape(-1, 3)) * np.sin(polar).ravel())
            * np.pi
            / 1800
            * np.pi
            / 450
        )
        assert answer["hemi"][0] == pytest.approx(float(light), rel=2e-3)


def test_colour_of_three_channels(tmp_path: Path) -> None:
    """X, Y, Z come back from Radiance's sharp RGB as what Y and chromaticity say."""
    channels = {"x": Lopsided(tint=0.9), "y": Lopsided(), "z": Lopsided(tint=0.4)}
    path = tmp_path / "colour.xml"
    wanted = {"CIE-X": "x", "CIE-Y": "y", "CIE-Z": "z"}
    bsdf = Bsdf(dict(channels), front_faces="interior")
    write_tensor(bsdf, path, dimensions=4, resolution=3, leaves=8000, channels=wanted)
    text = path.read_text()
    assert [text.count(f">{name}<") for name in ("Visible", "CIE-u", "CIE-v")] == [4, 4, 4]
    found, _ = read_tensor(path)
    incident, outgoing = unit_from_angles_deg([40.0], [30.0]), unit_from_angles_deg([20.0, 130.0], [10.0, 70.0])
    y = found.channels["visible"].dsf_per_sr(incident, outgoing)
    # u' and v' are everywhere the same here: one leaf each.
    assert len(set(re.findall(r"<ScatteringData>(\{[.\d]+\})</", text))) == 2
    np.testing.assert_allclose(found.channels["CIE-X"].dsf_per_sr(incident, outgoing), 0.9 * y, rtol=3e-4)
    np.testing.assert_allclose(found.channels["CIE-Z"].dsf_per_sr(incident, outgoing), 0.4 * y, rtol=3e-4)
    queries = [[40.0, 30.0, 20.0, 10.0], [40.0, 30.0, 130.0, 70.0]]
    plane = y / np.abs(outgoing[:, 2])
    np.testing.assert_allclose(
        ask_radiance(path, queries)["values"], plane, rtol=2e-3
    )  # through RGB of single precision
