"""test_scatter_tables.py: datasets and WINDOW files as tables to draw from: map, energy, sides, light through them."""

from pathlib import Path

import numpy as np
import pytest

from gonio.cli import main
from gonio.dataset.bsdf import Dataset, Distribution, PointFlag
from gonio.dataset.nexus import read_dataset, write_dataset
from gonio.formats.window import read as window_reader
from gonio.geometry.cells import solid_angles_sr
from gonio.geometry.directions import angles_deg_from_unit, unit_from_angles_deg
from gonio.simulate.directions import rings
from gonio.simulate.tables import cell_of, shirley_chiu, table_of_dataset, table_of_window
from gonio.units.errors import UsageError

SEATEX = Path(__file__).parents[1] / "data" / "window_xml" / "46016_SEATEX_Midnight.xml"
RHO, TAU = 0.5, 0.2


def dataset(theta_i_deg: float, lobe_deg: tuple[float, float], channel: str = "visible") -> Dataset:
    """Lambertian on both sides, and a lobe of integral 0.1 that is 5 degrees wide."""
    unit = rings(4.0)
    omega = solid_angles_sr(unit)
    same_side = (unit[:, 2] > 0.0) == (theta_i_deg <= 90.0)
    dsf = np.where(same_side, RHO, TAU) / np.pi * np.abs(unit[:, 2])
    lobe = np.exp(-0.5 * (np.degrees(np.arccos(np.clip(unit @ unit_from_angles_deg(*lobe_deg), -1, 1))) / 5.0) ** 2)
    dsf += 0.1 * lobe / (lobe @ omega)
    theta, phi = angles_deg_from_unit(unit)
    n = len(unit)
    return Dataset(
        [
            Distribution(
                theta_i_deg,
                0.0,
                theta,
                phi,
                dsf,
                np.zeros(n),
                dsf,
                np.ones(n),
                np.ones(n, np.int32),
                np.full(n, PointFlag.MEASURED, np.uint16),
                omega,
                np.zeros(n, np.int64),
                channel=channel,
            )
        ]
    )


def test_the_map_and_its_inverse() -> None:
    """Points of a cell lie in it, and the map keeps areas: the mean of z over equal projected areas is 2/3."""
    inside = shirley_chiu(16, 3)
    row, column = cell_of(inside.reshape(-1, 3), 16)
    np.testing.assert_array_equal(row, np.repeat(np.arange(16), 16 * 9))
    np.testing.assert_array_equal(column, np.tile(np.repeat(np.arange(16), 9), 16))
    assert np.linalg.norm(inside, axis=-1) == pytest.approx(np.ones(inside.shape[:-1]))
    assert inside[..., 2].mean() == pytest.approx(2.0 / 3.0, abs=2e-3)
    assert inside[0, 8, 4, 1] < -0.9  # row by row along y
    assert inside[8, 0, 4, 0] < -0.9


@pytest.mark.parametrize("back", [False, True])
def test_a_dataset_keeps_energy_and_place(back: bool) -> None:
    theta_i = 140.0 if back else 40.0
    table = table_of_dataset(dataset(theta_i, (theta_i, 120.0)), "visible", "none", "x.h5", cells=32)
    (entry,) = table.entries
    assert (entry.back, entry.theta_deg) == (back, pytest.approx(40.0))
    each = np.pi / 32**2
    assert entry.reflected.sum() * each == pytest.approx(RHO + 0.1, rel=0.002)
    assert entry.transmitted.sum() * each == pytest.approx(TAU, rel=0.002)
    brightest = shirley_chiu(32)[np.unravel_index(np.argmax(entry.reflected), (32, 32))][0]
    seen_from_there = unit_from_angles_deg(40.0, -120.0 if back else 120.0)  # y turns over on the back
    assert brightest @ seen_from_there > np.cos(np.radians(4.0))


def test_a_band_finds_its_channel_or_the_only_one() -> None:
    both = dataset(0.0, (0.0, 0.0), "visible")
    both.distributions += dataset(0.0, (40.0, 0.0), "near-infrared").distributions
    bright = table_of_dataset(both, "near-infrared", "none", "x.h5", cells=16).entries[0].reflected
    assert np.argmax(bright.max(axis=0)) > 9
    with pytest.raises(UsageError, match=r'x\.h5: has no channel "uv"'):
        table_of_dataset(both, "uv", "none", "x.h5")


def test_a_window_file_keeps_its_hemispherical_values() -> None:
    window = window_reader.read(SEATEX)
    table = table_of_window(SEATEX, "visible", "none", cells=64)
    assert len(table.entries) == 2 * 145
    each = np.pi / 64**2
    for process, part in (("Transmission", "transmitted"), ("Reflection", "reflected")):
        front = window.hemispherical("Visible", process, "Front")  # type: ignore[arg-type]
        found = np.array([getattr(entry, part).sum() * each for entry in table.entries if not entry.back])
        assert found == pytest.approx(front, abs=1e-9)


def test_light_on_a_sheet_of_measured_stuff_comes_out_as_measured(tmp_path: Path) -> None:
    """Tabulated from a dataset, traced, read again: reflectance, transmittance and the lobe are the dataset's."""
    write_dataset(dataset(40.0, (40.0, 120.0)), tmp_path / "stuff.h5")
    scenario = tmp_path / "sheet.toml"
    scenario.write_text(
        '[sample]\nkind = "sheet"\nmaterial = "stuff"\n'
        '[materials.stuff]\nkind = "tabulated"\nfile = "stuff.h5"\nfollow = "none"\n'
        "[photons]\ncount = 200000\n[readings]\nincident = [[40, 0]]\nstep_deg = 5\n"
    )
    assert main.run(["simulate", str(scenario), "-o", str(tmp_path / "sim.h5")]) == 0
    (found,) = read_dataset(tmp_path / "sim.h5").distributions
    for name, expected in (("rho", RHO + 0.1), ("tau", TAU)):
        assert found.integrals[f"{name}_measured"] == pytest.approx(expected, abs=4.0 * found.integrals[f"{name}_u"])
    brightest = np.argmax(found.dsf_per_sr)
    where = unit_from_angles_deg(found.theta_deg[brightest], found.phi_deg[brightest])
    assert where @ unit_from_angles_deg(40.0, 120.0) > np.cos(np.radians(6.0))
