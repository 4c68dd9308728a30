"""test_pab_judge.py: Radiance's own pabopto2bsdf loads what we write, and its tree has the lobes where they are.

Radiance fits lobes and interpolates between incident directions: heights are judged loosely, directions sharply.
"""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyradiance
import pytest
from synthetic_bsdf import distribution, sphere_points, spiral_about

from gonio.dataset.bsdf import Dataset
from gonio.formats.pab import write as pab_write
from gonio.geometry.directions import angle_between_deg, unit_from_angles_deg

pytestmark = pytest.mark.judge

PROGRAMS = Path(pyradiance.__file__).parent / "bin"
QUERY = """
import json, sys
import pyradiance.bsdf as b
job = json.load(sys.stdin)
sd = b.load_file(job["path"])
print(json.dumps({
    "values": [float(b.query(sd, *q)[1]) for q in job["queries"]],
    "hemi": [float(b.direct_hemi(sd, *q, b.SAMPLE_ALL)) for q in job["hemi"]],
}))
"""
SIGMA_DEG = 8.0
Direction = tuple[float, float]


def run(arguments: list[str], output: Path) -> None:
    paths = {"RAYPATH": str(PROGRAMS.parent / "lib"), "PATH": f"{PROGRAMS}{os.pathsep}{os.environ['PATH']}"}
    with output.open("wb") as file:
        done = subprocess.run(
            [str(PROGRAMS / arguments[0]), *arguments[1:]],
            stdout=file,
            stderr=subprocess.PIPE,
            env=os.environ | paths,
            check=False,
        )
    assert done.returncode == 0, done.stderr.decode()


def radiance(
    files: list[Path], queries: list[list[float]], hemi: list[Direction], tmp_path: Path, *, resolution: int = 5
) -> dict[str, Any]:
    """Values of the tensor tree that Radiance makes of one set of files, in its frame."""
    fit, tree = tmp_path / "fit.sir", tmp_path / "tree.xml"
    run(["pabopto2bsdf", "-n", "2", *map(str, files)], fit)
    run(["bsdf2ttree", "-g", str(resolution), "-t", "90", str(fit)], tree)
    job = json.dumps({"path": str(tree), "queries": queries, "hemi": hemi})
    done = subprocess.run([sys.executable, "-c", QUERY], input=job, capture_output=True, text=True, check=True)
    return dict(json.loads(done.stdout))


def with_lobe(incident: Direction, lobe: Direction, energy: float) -> Any:
    """A Gaussian lobe over 5 % of Lambertian light, on the lobe's side only."""
    front = lobe[0] < 90
    units = np.concatenate([sphere_points(3000), spiral_about(*lobe, 2.5 * SIGMA_DEG, 2.0)])
    sigma = np.radians(SIGMA_DEG)

    def dsf(u: np.ndarray[Any, np.dtype[np.float64]]) -> np.ndarray[Any, np.dtype[np.float64]]:
        off = np.radians(angle_between_deg(u, unit_from_angles_deg(*lobe)))
        peak = energy / (2 * np.pi * sigma**2) * np.exp(-0.5 * (off / sigma) ** 2)
        return np.asarray(np.where((u[:, 2] > 0) == front, peak + 0.05 / np.pi * np.abs(u[:, 2]), 0.0))

    return distribution(incident, units, dsf)


def turned(direction: Direction, front_faces: str) -> list[float]:
    """Radiance's frame, written independently of klems.py: about y by half a turn."""
    x, y, z = unit_from_angles_deg(*direction)
    x, z = (x, z) if front_faces == "interior" else (-x, -z)
    return [float(np.degrees(np.arccos(z))), float(np.degrees(np.arctan2(y, x))) % 360]


@pytest.mark.parametrize(
    ("front_faces", "behind", "kind"),
    [
        ("interior", False, "front_reflection"),
        ("exterior", False, "back_reflection"),
        ("interior", True, "front_transmission"),
        ("exterior", True, "back_transmission"),
    ],
)
def test_lobes_of_an_isotropic_sample_have_their_place_height_and_energy(
    tmp_path: Path, front_faces: Any, behind: bool, kind: str
) -> None:
    """The lobe lies 40 degrees to one side of the plane of incidence: a mirrored azimuth or a wrong side shows."""
    cases = []
    for theta in (0.0, 20.0, 40.0, 60.0):
        out = max(theta, 15.0)
        cases.append(((theta, 30.0), (180.0 - out if behind else out, 30.0 + 180.0 + 40.0)))
    dataset = Dataset([with_lobe(i, o, 0.3) for i, o in cases], "asymmetric", front_faces, symmetry="isotropic")
    paths = [p for p in pab_write.write(dataset, tmp_path / "set").paths if p.name.startswith(f"{kind}_t")]
    assert len(paths) == len(cases)
    queries = []
    for incident, (theta, phi) in cases[1:]:
        wrong = [(theta, phi - 80.0), (theta, phi + 180.0), (theta, phi - 90.0), (180.0 - theta, phi)]
        queries += [[*turned(incident, front_faces), *turned(o, front_faces)] for o in [(theta, phi), *wrong]]
    found = radiance(paths, queries, [tuple(turned(i, front_faces)) for i, _ in cases[1:]], tmp_path)  # type: ignore[misc]
    for number, (_, (theta, phi)) in enumerate(cases[1:]):
        value, *others = found["values"][5 * number : 5 * number + 5]
        peak = 0.3 / (2 * np.pi * np.radians(SIGMA_DEG) ** 2) / abs(np.cos(np.radians(theta))) + 0.05 / np.pi
        assert value == pytest.approx(peak, rel=0.4), (theta, phi)  # a tree's cells are as wide as the lobe
        assert max(others) < 0.05 * peak
        assert found["hemi"][number] == pytest.approx(0.35, rel=0.05)


def test_up_is_up(tmp_path: Path) -> None:
    """At normal incidence the lobe has its absolute azimuth; turned by a right angle or mirrored it lies elsewhere.
    Oblique light without a lobe makes the sample anisotropic for Radiance."""
    lobe = (40.0, 250.0)
    cases = [((40.0, phi), (40.0, 0.0), 0.0) for phi in (45.0, 135.0, 225.0, 315.0)]
    cases.append(((0.0, 0.0), lobe, 0.3))
    dataset = Dataset([with_lobe(*case) for case in cases], "up", "exterior")
    paths = [p for p in pab_write.write(dataset, tmp_path / "set").paths if p.name.startswith("back_reflection_t")]
    normal = turned((0.0, 0.0), "exterior")
    azimuths = (250.0, 160.0, 70.0, 340.0, 290.0, 110.0, 200.0)
    queries = [[*normal, *turned((lobe[0], azimuth), "exterior")] for azimuth in azimuths]
    value, *others = radiance(paths, queries, [], tmp_path, resolution=4)["values"]
    assert value > 0.5
    assert max(others) < 0.2 * value
