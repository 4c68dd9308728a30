"""test_louver.py: Radiance judges the louver: mkpmap's photons, counted, and genBSDF's matrices."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from our_sheet import SOURCES, goniophotometer

from benchmarks.sim import klems, photon_map
from benchmarks.sim.directions import even_directions
from benchmarks.sim.louver import Louver
from benchmarks.sim.scene import PORT_OUTSIDE_MM, Beam
from gonio.formats.window.klems import BASES
from gonio.simulate import _photons

pytestmark = pytest.mark.judge

# The beam is wide, so that it matters little where its rim cuts the slats, and the receiver so far that places on it
# are directions: Radiance's port sends up to 10 % more light to some azimuths.
RECEIVER_MM = 20_400.0
BEAM = Beam(diameter_mm=130.0, opening_deg=0.01)
LOUVER = Louver(count=31, length_mm=300.0)
# Mirrors in facets send light into steps: 60 per section make steps of 1.2 and 2.3 degrees, and tau is within 0.1 %.
FACETS = 60
OF_FACETS = 0.003
CAP_RAD = np.radians(11.0)


@pytest.mark.parametrize(("incident_deg", "top_specularity"), [((45.0, 90.0), 1.0), ((60.0, 130.0), 0.0)])
def test_distribution_is_that_of_mkpmaps_photons(
    incident_deg: tuple[float, float], top_specularity: float, tmp_path: Path
) -> None:
    """Shares of the light in 100 caps all over the sphere and in the hemispheres; photons are counted on both sides.

    What mirrors send is not compared cap by cap: in facets it is steps, where ours is smooth.
    """
    stored, photons = 250_000, 1_500_000
    louver = replace(LOUVER, top_specularity=top_specularity)
    scene = louver.radiance(FACETS)
    scene.receiver_mm = RECEIVER_MM
    made = photon_map.make(scene, incident_deg, stored, tmp_path / "map", beam=BEAM)
    through = made.emitted * photon_map.through_port(tmp_path / "mirror", 200_000, BEAM, RECEIVER_MM)
    centres = np.concatenate([even_directions(100), [[0, 0, 1], [0, 0, -1]]])
    half_angles = np.append(np.full(100, CAP_RAD), [np.pi / 2, np.pi / 2])
    hits = made.hits()
    theirs = np.array(
        [np.sum(hits @ centre > np.cos(angle)) for centre, angle in zip(centres, half_angles, strict=True)]
    ) / through  # fmt: skip

    instrument = f"[instrument]\narm_radius_mm = {RECEIVER_MM}\ndetector_aperture_mm = 100.0\n"
    (tmp_path / "axes.toml").write_text(instrument)
    text = louver.scenario(
        photons=1,
        diameter_mm=BEAM.diameter_mm,
        stop_distance_mm=RECEIVER_MM + PORT_OUTSIDE_MM,
        opening_deg=BEAM.opening_deg,
    )
    twin = goniophotometer(text, incident_deg, tmp_path)
    held, balance = twin.store(0, photons, 2, _photons.Watch())
    assert balance["lost"] == 0
    dsf, error = np.zeros(len(centres)), np.zeros(len(centres))
    for angle in np.unique(half_angles):
        those = half_angles == angle
        cap_sr = 2 * np.pi * (1 - np.cos(angle))
        found = held.fixed(centres[those], angle, 1)
        dsf[those], error[those] = found[0] * cap_sr, found[1] * cap_sr

    of_theirs = np.sqrt(theirs * (1 - theirs) / through)
    together = np.sqrt(error**2 + of_theirs**2)
    for side in (-2, -1):  # rho, tau
        assert dsf[side] == pytest.approx(theirs[side], abs=4 * together[side] + OF_FACETS * theirs[side])
    if top_specularity > 0:
        return
    enough = (theirs[:100] * through > 50) & (dsf[:100] * photons > 50)
    deviations = ((dsf - theirs) / together)[:100][enough]
    freedom = int(np.sum(enough))
    assert freedom > 60
    assert float(np.sum(deviations**2)) < freedom + 5 * np.sqrt(2 * freedom)


def test_hemispherical_values_are_genbsdfs(tmp_path: Path) -> None:
    """Klems quarter, light from the interior on the louver's back: rho and tau of each incident patch. genBSDF's
    stratified samples err no more than independent ones: sqrt(share (1 - share) / samples)."""
    basis, samples, photons = BASES["klems-quarter"], 36, 20_000
    matrices, _ = klems.generate(
        LOUVER.radiance(20), tmp_path / "genbsdf", samples=samples, depth_mm=12.0, cell_mm=(10.0, 10.0),
        parameters=("-ab", "12"), basis="kq", front=False,
    )  # fmt: skip
    theirs = klems.shares(matrices, basis)[1].reshape(basis.size, 2, basis.size).sum(axis=2)
    path = tmp_path / "louver.toml"
    path.write_text(LOUVER.scenario(photons=1))
    scenario = _photons.Scenario(str(path), str(SOURCES), {})
    matrix = _photons.PatchMatrix(scenario, scenario.bands[0][0], basis.bounds_deg)
    ours = np.zeros((basis.size, 2))
    for patch in range(basis.size):
        reflected, transmitted, _ = matrix.column(patch, False, 0, photons, 2, _photons.Watch())
        ours[patch] = [np.sum(side[0]) / 2**24 / photons for side in (reflected, transmitted)]
    error = np.sqrt(np.maximum(ours * (1 - ours), 0.01) * (1 / samples + 1 / photons))
    assert np.all(np.abs(ours - theirs) < 4.5 * error)
    weight = basis.projected_solid_angle_sr / np.pi
    diffuse = float(np.sqrt(np.sum((weight[:, None] * error) ** 2, axis=0).max()))
    assert weight @ ours == pytest.approx(weight @ theirs, abs=4 * diffuse)
