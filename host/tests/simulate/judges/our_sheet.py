"""our_sheet.py: scenarios of ours for the judges, traced: readings of even caps, sums of the two hemispheres."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gonio.simulate import _photons

FloatArray = NDArray[np.float64]
SOURCES = Path(__file__).resolve().parents[4]


def sheet_scenario(material: str, *, sample: str = 'kind = "sheet"', diameter_mm: float = 1.0) -> str:
    """`material`: the keys of [materials.m]. A thin, nearly parallel beam: places on the receiver are directions."""
    return f"""seed = 3
[sample]
{sample}
material = "m"
[materials.m]
{material}
[beam]
diameter_mm = {diameter_mm}
edge_deg = 0.0
[source]
opening_angle_deg = 0.05
"""


def goniophotometer(text: str, incident_deg: tuple[float, float], where: Path) -> _photons.Goniophotometer:
    path = where / "scenario.toml"
    path.write_text(text)
    scenario = _photons.Scenario(str(path), str(SOURCES), {})
    return _photons.Goniophotometer(scenario, scenario.bands[0][0], *incident_deg)


def readings(
    twin: _photons.Goniophotometer, directions: FloatArray, half_angle_rad: float, photons: int
) -> tuple[FloatArray, FloatArray, NDArray[np.uint64]]:
    """DSF and standard error [1/sr] and hits of caps about unit vectors (n, 3)."""
    weight, square, hits, balance = twin.read(directions, half_angle_rad, 0, photons, 2, _photons.Watch())
    assert balance["lost"] == 0
    dsf, error, _, hits = _photons.estimate(weight, square, hits, photons, half_angle_rad)
    return dsf, error, hits


def reflected_and_transmitted(twin: _photons.Goniophotometer, photons: int) -> tuple[float, float]:
    """Shares of the light; the binomial standard error of each is at most 0.5 / sqrt(photons)."""
    poles = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    weight, _, _, balance = twin.read(poles, np.pi / 2, 0, photons, 2, _photons.Watch())
    assert balance["lost"] == 0
    return float(weight[0]) / balance["emitted"], float(weight[1]) / balance["emitted"]
