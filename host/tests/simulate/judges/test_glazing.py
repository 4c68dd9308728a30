"""test_glazing.py: panes of glass against Fresnel, worked out here, and WINDOW's engine (pywincalc)."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from our_sheet import goniophotometer, reflected_and_transmitted, sheet_scenario

pytestmark = pytest.mark.judge
PHOTONS = 1_000_000
INDEX = 1.52
THETAS_DEG = (0.0, 45.0, 60.0, 75.0)

WINDOW = """
import json, sys
import pywincalc as p
tau, rho, count = json.loads(sys.argv[1])
measured = [p.WavelengthData(0.3 + 0.005 * i, p.OpticalMeasurementComponent(tau, tau, rho, rho)) for i in range(441)]
optical = p.ProductDataOpticalNBand(material_type=p.MaterialType.MONOLITHIC, thickness_meters=0.004,
                                    wavelength_data=measured, coated_side=p.CoatedSide.NEITHER)
pane = p.ProductDataOpticalAndThermal(optical, p.ProductDataThermal(1.0, 0.004, False, 0, 0))
gaps = [p.Layers.gap(thickness=0.012)] * (count - 1)
standard = p.load_standard(str(p.standard_path / "W5_NFRC_2003.std"))
system = p.GlazingSystem(optical_standard=standard, solid_layers=[pane] * count, gap_layers=gaps)
out = []
for theta in json.loads(sys.argv[2]):
    front = system.optical_method_results("PHOTOPIC", theta, 0).system_results.front
    out.append([front.reflectance.direct_direct, front.transmittance.direct_direct])
print(json.dumps(out))
"""


def fresnel(theta_deg: float, depth: float, polarisations: tuple[int, ...] = (0, 1)) -> tuple[float, float]:
    """Reflectance and transmittance of a pane, all reflections inside added up; depth: absorption along the normal."""
    outside = np.cos(np.radians(theta_deg))
    inside = np.sqrt(1 - (np.sin(np.radians(theta_deg)) / INDEX) ** 2)
    face = np.array([(outside - INDEX * inside) / (outside + INDEX * inside),
                     (INDEX * outside - inside) / (INDEX * outside + inside)])[list(polarisations)] ** 2  # fmt: skip
    remains = np.exp(-depth / inside)
    tau = (1 - face) ** 2 * remains / (1 - (face * remains) ** 2)
    return float(np.mean(face * (1 + remains * tau))), float(np.mean(tau))


def window(depth: float, panes: int) -> list[list[float]]:
    rho, tau = fresnel(0.0, depth)
    command = [sys.executable, "-c", WINDOW, json.dumps([tau, rho, panes]), json.dumps(THETAS_DEG)]
    return list(json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout))


@pytest.mark.parametrize("absorption_per_mm", [0.0, 0.025])
def test_a_pane_reflects_and_transmits_as_fresnel_and_window_say(absorption_per_mm: float, tmp_path: Path) -> None:
    """4 sigma of at most 0.5 / sqrt(photons). A pane as one surface and as two boundaries, the light's state followed:
    the second boundary meets light that the first has polarised."""
    material = f"index = {INDEX}\nabsorption_per_mm = {absorption_per_mm}"
    thin = sheet_scenario(f'kind = "thin-plate"\nthickness_mm = 4.0\n{material}')
    thick = sheet_scenario(
        f'kind = "dielectric"\n{material}', sample='kind = "window-glass"\nthickness_mm = 4.0\nsize_mm = 400.0'
    )
    thick += "[photons]\npolarised = true\n"
    depth = 4.0 * absorption_per_mm
    for theta_deg, judged in zip(THETAS_DEG, window(depth, 1), strict=True):
        expected = fresnel(theta_deg, depth)
        assert judged == pytest.approx(expected, abs=1e-6)
        for text in (thin, thick):
            found = reflected_and_transmitted(goniophotometer(text, (theta_deg, 0.0), tmp_path), PHOTONS)
            assert found == pytest.approx(expected, abs=4 * 0.5 / np.sqrt(PHOTONS))


def two_panes(rho: float, tau: float) -> tuple[float, float]:
    """Two equal panes, reflections between them added up."""
    between = 1 - rho * rho
    return rho + tau * tau * rho / between, tau * tau / between


def test_two_panes_follow_s_and_p_where_window_takes_their_mean(tmp_path: Path) -> None:
    """A unit as one surface of two layers. WINDOW's engine adds panes up with the mean of s and p: at 60 degrees
    tau is 0.027 below the sum of s and p each for itself, which is what we and Fresnel say."""
    depth = 0.05
    layer = f'[[materials.m.layer]]\nkind = "plate"\nindex = {INDEX}\nabsorption_per_mm = 0.0125\nthickness_mm = 4.0\n'
    text = sheet_scenario(f'kind = "layers"\n{layer}{layer}')
    for theta_deg, judged in zip(THETAS_DEG, window(depth, 2), strict=True):
        assert judged == pytest.approx(two_panes(*fresnel(theta_deg, depth)), abs=1e-6)
        expected = np.mean([two_panes(*fresnel(theta_deg, depth, (state,))) for state in (0, 1)], axis=0)
        found = reflected_and_transmitted(goniophotometer(text, (theta_deg, 0.0), tmp_path), PHOTONS)
        assert found == pytest.approx(tuple(expected), abs=4 * 0.5 / np.sqrt(PHOTONS))
