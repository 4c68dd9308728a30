"""test_model_file.py: models written and read: the same answers bit for bit, and files that are refused."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from sampled_nodes import Moving, dataset, spread, towards

from gonio.dataset.nexus import write_dataset
from gonio.dataset.scattering import Bsdf
from gonio.model.analytic import fit_family
from gonio.model.fitted import fit_bsdf
from gonio.model.model_file import is_model, read_model, write_model
from gonio.units.errors import UsageError

_MEASURED = dataset(Moving(), [(t, p) for t in (10.0, 30.0, 50.0) for p in (0.0, 90.0)], symmetry="quadrilateral")


@pytest.fixture(scope="module")
def model() -> Bsdf:
    return fit_bsdf(_MEASURED)


def _answers(bsdf: Bsdf) -> np.ndarray:
    incident = np.array([towards(t, p) for t, p in ((10.0, 0.0), (22.0, 200.0), (71.0, 45.0), (140.0, 0.0))])
    unit = spread(300)
    which = np.repeat(np.arange(4), 300)
    scattering = bsdf.channels["visible"]
    outgoing = np.tile(unit, (4, 1))
    return np.stack((scattering.dsf_per_sr(incident, outgoing, which), scattering.origin(incident, outgoing, which)))


def test_a_model_answers_as_before_bit_for_bit(model: Bsdf, tmp_path: Path) -> None:
    path = tmp_path / "model.h5"
    write_model(model, path)
    assert is_model(path)
    again = read_model(path)
    np.testing.assert_array_equal(_answers(again), _answers(model))
    assert again.validity == model.validity
    assert again.measured == model.measured
    assert again.provenance == model.provenance
    assert (again.sample_name, again.symmetry, again.front_faces) == ("known", "quadrilateral", model.front_faces)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("method", ["auto", "lobes-opposite-rest", "blend-same"])
def test_an_isotropic_model_too(method: str, tmp_path: Path) -> None:
    isotropic = fit_bsdf(dataset(Moving(), [(t, 0.0) for t in (10.0, 30.0, 50.0)]), method=method)
    write_model(isotropic, tmp_path / "model.h5")
    np.testing.assert_array_equal(_answers(read_model(tmp_path / "model.h5")), _answers(isotropic))


def test_an_analytic_model_too(tmp_path: Path) -> None:
    family = fit_family(dataset(Moving(), [(t, 0.0) for t in (10.0, 30.0, 50.0)]), "gaussian")
    write_model(family, tmp_path / "model.h5")
    np.testing.assert_array_equal(_answers(read_model(tmp_path / "model.h5")), _answers(family))


def test_a_changed_file_is_refused(model: Bsdf, tmp_path: Path) -> None:
    path = tmp_path / "model.h5"
    for change in ("value", "attribute", "missing"):
        write_model(model, path)
        with h5py.File(path, "r+") as file:
            node = file["channels/000/components/front reflection/nodes/00001"]
            if change == "value":
                node["background"][2, 2] += 1e-3
            elif change == "attribute":
                node.attrs["scale"] = 2.0
            else:
                del node["background"]
        with pytest.raises(UsageError, match="changed after it was written"):
            read_model(path)


def test_foreign_newer_and_damaged_files_are_refused(model: Bsdf, tmp_path: Path) -> None:
    path = tmp_path / "model.h5"
    with pytest.raises(UsageError, match="no such file"):
        read_model(path)
    path.write_bytes(b"not HDF5")
    assert not is_model(path)
    with pytest.raises(UsageError, match="damaged"):
        read_model(path)
    write_dataset(_MEASURED, path)
    assert not is_model(path)
    with pytest.raises(UsageError, match="not a model"):
        read_model(path)
    write_model(model, path)
    with h5py.File(path, "r+") as file:
        file.attrs["gonio_model"] = 99
    with pytest.raises(UsageError, match="model format 99"):
        read_model(path)
    write_model(model, path)
    whole = path.read_bytes()
    for share in (0.2, 0.6, 0.95):
        path.write_bytes(whole[: int(share * len(whole))])
        with pytest.raises(UsageError):
            read_model(path)


def test_a_folder_that_takes_no_file(model: Bsdf, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="cannot write"):
        write_model(model, tmp_path / "nowhere" / "model.h5")
    assert list(tmp_path.iterdir()) == []
