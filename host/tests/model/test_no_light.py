"""test_no_light.py: components without any light, as the transmission of an opaque sample computed without noise."""

from pathlib import Path

import numpy as np
import pytest

from gonio.cli.main import run
from gonio.dataset.bsdf import Dataset, Distribution
from gonio.dataset.nexus import write_dataset
from gonio.geometry.directions import unit_from_angles_deg
from gonio.model.model_file import read_model

_POINTS = 600


def _distribution(theta_i_deg: float, rho: float) -> Distribution:
    """Lambertian reflection of the front; transmission exactly 0."""
    cosine = 1.0 - 2.0 * (np.arange(_POINTS) + 0.5) / _POINTS
    dsf = np.where(cosine > 0.0, rho / np.pi * cosine, 0.0)
    return Distribution(
        incident_theta_deg=theta_i_deg,
        incident_phi_deg=0.0,
        theta_deg=np.degrees(np.arccos(cosine)),
        phi_deg=(np.arange(_POINTS) * 137.50776) % 360.0,
        dsf_per_sr=dsf,
        variance_per_sr2=np.zeros(_POINTS),
        signal=dsf,
        normalisation=np.ones(_POINTS),
        count=np.ones(_POINTS, dtype=np.int32),
        flags=np.zeros(_POINTS, dtype=np.uint16),
        solid_angle_sr=np.full(_POINTS, 4.0 * np.pi / _POINTS),
        time_ns=np.zeros(_POINTS, dtype=np.int64),
    )


def _written(path: Path, rho: float) -> Path:
    dataset = Dataset([_distribution(theta, rho) for theta in (0.0, 30.0, 60.0)], symmetry="isotropic")
    write_dataset(dataset, path)
    return path


@pytest.mark.parametrize("family", [[], ["lambertian"], ["abg"]])
def test_an_opaque_sample_keeps_its_reflection(tmp_path: Path, family: list[str]) -> None:
    source, target = _written(tmp_path / "opaque.h5", 0.5), tmp_path / "model.h5"
    assert run(["fit", *family, str(source), "-o", str(target)]) == 0
    scattering = read_model(target).channels["visible"]
    incident = unit_from_angles_deg([30.0], [0.0])
    front, back = scattering.dsf_per_sr(incident, unit_from_angles_deg([20.0, 160.0], [90.0, 90.0]))
    np.testing.assert_allclose(front, 0.5 / np.pi * np.cos(np.radians(20.0)), rtol=0.02)
    assert not back > 0.0  # 0, or absent


def test_a_family_of_nothing_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source, target = _written(tmp_path / "dark.h5", 0.0), tmp_path / "model.h5"
    assert run(["fit", "lambertian", str(source), "-o", str(target)]) == 2
    assert "no point has any light" in capsys.readouterr().err
    assert not target.exists()
