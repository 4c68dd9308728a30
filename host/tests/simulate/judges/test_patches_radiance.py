"""test_patches_radiance.py: Radiance's BSDF reader answers what was simulated: slats that redirect light upwards."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from mirror_slats import SLATS

from gonio.cli import main
from gonio.formats.window.klems import BASES

pytestmark = pytest.mark.judge

# A process of its own: the reader can crash when one process loads many files.
ASK = """
import json, sys
import pyradiance.bsdf as b
job = json.load(sys.stdin)
sd = b.load_file(job["path"])
parts = (b.SAMPLE_ALL & ~b.SAMPLE_R, b.SAMPLE_ALL & ~b.SAMPLE_T)
print(json.dumps({
    "values": [float(b.query(sd, *q)[1]) for q in job["queries"]],
    "hemi": [[b.direct_hemi(sd, *i, part) for part in parts] for i in job["incident"]],
}))
"""


@pytest.mark.parametrize("front", ["exterior", "interior"])
@pytest.mark.parametrize("theta_deg", [40.0, 140.0])
def test_radiance_finds_the_redirected_light_above(tmp_path: Path, front: str, theta_deg: float) -> None:
    """Light from above and from the right, on the front (40 degrees) or on the back (140), leaves straight on and, by
    the mirrors that face up, upwards; light from below only straight on. Directions of ours, turned by hand."""
    (tmp_path / "slats.toml").write_text(SLATS)
    path = tmp_path / "slats.xml"
    told = ["--format", "klems-full", "--front", front, "--photons", "20000"]
    assert main.run(["simulate", str(tmp_path / "slats.toml"), "-o", str(path), *told]) == 0

    def turned(theta: float, phi: float) -> list[float]:
        return [theta, phi % 360] if front == "interior" else [180 - theta, (180 - phi) % 360]

    above, below, through = (theta_deg, 60.0), (theta_deg, 300.0), 180 - theta_deg
    asked = [
        (above, (through, 240.0)),  # straight on
        (above, (through, 120.0)),  # redirected
        (above, (through, 60.0)),
        (above, (through, 300.0)),
        (above, (theta_deg, 300.0)),
        (below, (through, 120.0)),  # straight on
        (below, (through, 240.0)),  # would be redirected
    ]
    job = {
        "path": str(path),
        "queries": [[*turned(*i), *turned(*o)] for i, o in asked],
        "incident": [turned(*above), turned(*below)],
    }
    done = subprocess.run(
        [sys.executable, "-c", ASK], input=json.dumps(job), capture_output=True, text=True, check=True
    )
    answer = json.loads(done.stdout)
    # Over the patch, weighted by the cosine: share of the light that meets a slat, tan of its elevation.
    theta, phi = np.radians([np.linspace(35, 45, 400), np.linspace(52.5, 67.5, 400)])
    met = float(np.sum(np.sin(theta) ** 2) * np.mean(np.sin(phi)) / np.sum(np.sin(theta) * np.cos(theta)))
    size = float(BASES["klems-full"].projected_solid_angle_sr[BASES["klems-full"].patch_of(40.0, 60.0)])
    straight, redirected = (1 - met) / size, 0.7 * met / size
    expected = [straight, redirected, 0, 0, 0, straight, 0]
    assert answer["values"] == pytest.approx(expected, abs=0.05 * straight)
    assert answer["hemi"][0] == pytest.approx([1 - 0.3 * met, 0.0], abs=0.02)
    assert answer["hemi"][1] == pytest.approx([1 - met, 0.0], abs=0.02)
