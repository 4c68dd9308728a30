"""test_nexus.py: exact round trip, what a NeXus reader finds, and files that are not ours."""

from dataclasses import fields
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Distribution, PointFlag
from gonio.dataset.nexus import begin_points, read_dataset, read_scattering, write_dataset
from gonio.dataset.nexus_points import PointPacker, PointWriter
from gonio.geometry.directions import unit_from_angles_deg
from gonio.geometry.kinematics import Kinematics
from gonio.units.errors import UsageError
from gonio.units.instrument import load_instrument


def distribution(points: int, seed: int, **scalars: Any) -> Distribution:
    rng = np.random.default_rng(seed)
    flags = rng.choice([0, PointFlag.SHADOWED, PointFlag.INTERPOLATED_POSE], points).astype(np.uint16)
    dsf = rng.standard_normal(points)
    dsf[flags == PointFlag.SHADOWED] = np.nan
    return Distribution(
        **{"incident_theta_deg": 30.0, "incident_phi_deg": 0.1, **scalars},
        theta_deg=rng.uniform(0, 180, points),
        phi_deg=rng.uniform(0, 360, points),
        dsf_per_sr=dsf,
        variance_per_sr2=rng.random(points),
        signal=rng.standard_normal(points) * 1e6,
        normalisation=rng.uniform(0.9, 1.1, points),
        count=rng.integers(0, 100, points, dtype=np.int32),
        flags=flags,
        solid_angle_sr=rng.random(points),
        time_ns=rng.integers(-(2**62), 2**62, points),
        # Effects are stored in single precision: these are such numbers.
        effects={key: dsf.astype("f2") * np.float64(0.25) for key in ("dark", "axis arm azimuth #day 1/2", "future")},
        linear_solid_angle_sr=rng.random(points if seed % 2 else 0),
        path=rng.integers(-1, 2, points if seed % 2 else 0, dtype=np.int32),
        paths=("coarse 30/0", "mirror 30/0") if seed % 2 else (),
        signal_unit="A" if seed % 2 else "counts",
    )


def assert_same(a: Dataset, b: Dataset) -> None:
    for field in fields(Dataset):
        if field.name not in ("distributions", "beam"):
            assert getattr(a, field.name) == getattr(b, field.name)
    assert (a.beam is None) == (b.beam is None)
    pairs = list(zip(a.distributions, b.distributions, strict=True))
    if a.beam is not None and b.beam is not None:
        pairs.append((a.beam, b.beam))
    for one, other in pairs:
        for field in fields(Distribution):
            left, right = getattr(one, field.name), getattr(other, field.name)
            if isinstance(left, np.ndarray):
                assert left.dtype == right.dtype
            elif isinstance(left, dict):
                left, right = repr(left), repr(right)  # NaN equals NaN
            np.testing.assert_array_equal(left, right, err_msg=field.name)


@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    sizes=st.lists(st.integers(0, 30), max_size=12),
    text=st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"])),
    integrals=st.dictionaries(
        st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"])), st.floats(), max_size=4
    ),
    wavelength_nm=st.none() | st.floats(1.0, 3000.0),
    with_beam=st.booleans(),
)
def test_round_trip_is_exact(
    tmp_path: Path,
    *,
    sizes: list[int],
    text: str,
    integrals: dict[str, float],
    wavelength_nm: float | None,
    with_beam: bool,
) -> None:
    dataset = Dataset(
        [
            distribution(
                n,
                k,
                integrals=integrals,
                budgets={name: {"dark": 1.0 / 3.0, text: value} for name, value in integrals.items()},
                wavelength_nm=wavelength_nm,
                channel=text,
                p_i=np.nan if k == 1 else 1.0 / 3.0,
            )
            for k, n in enumerate(sizes)
        ],
        sample_name=text,
        front_faces="exterior",
        thickness_mm=wavelength_nm,
        provenance={"a": [1, 2.5, None, {"b": text}], "c": 0.1},
        beam=distribution(5, 99) if with_beam else None,
    )
    write_dataset(dataset, tmp_path / "a.h5")
    assert_same(read_dataset(tmp_path / "a.h5"), dataset)


def test_what_scatters_is_read_alone(tmp_path: Path) -> None:
    dataset = Dataset([distribution(n, n) for n in (40, 41)], "blind", beam=distribution(5, 6), symmetry="isotropic")
    write_dataset(dataset, tmp_path / "bsdf.h5")
    found = read_scattering(tmp_path / "bsdf.h5")
    assert (found.sample_name, found.symmetry, found.beam) == ("blind", "isotropic", None)
    for one, other in zip(found.distributions, dataset.distributions, strict=True):
        for name in ("theta_deg", "phi_deg", "dsf_per_sr", "variance_per_sr2", "flags", "solid_angle_sr", "integrals"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
        np.testing.assert_array_equal(one.measured, other.measured)
        assert np.isnan(one.signal).all()  # not read is no value, of as many points
        assert one.signal.shape == one.time_ns.shape == one.count.shape == one.theta_deg.shape
        assert (len(one.effects), len(one.path), len(one.paths), len(one.linear_solid_angle_sr)) == (0, 0, 0, 0)


def test_large_distribution_is_compressed_exact_and_guarded(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    dataset = Dataset([distribution(20_000, 1)])
    write_dataset(dataset, path)
    assert_same(read_dataset(path), dataset)
    with h5py.File(path) as file:
        chunk = file["incident_0000/data/dsf"].id.get_chunk_info(0)
    data = bytearray(path.read_bytes())
    data[chunk.byte_offset + chunk.size // 2] ^= 4
    path.write_bytes(data)
    with pytest.raises(UsageError, match="truncated or damaged"):
        read_dataset(path)


def test_columns_packed_ahead_are_the_same(tmp_path: Path) -> None:
    dataset = Dataset([distribution(20_000, 1), distribution(10, 2)], beam=distribution(3000, 3))
    with PointPacker() as packer:
        for one in dataset.distributions:
            begin_points(one, packer)
        write_dataset(dataset, tmp_path / "a.h5", packer)
    write_dataset(dataset, tmp_path / "b.h5")
    assert_same(read_dataset(tmp_path / "a.h5"), dataset)
    assert (tmp_path / "a.h5").stat().st_size == (tmp_path / "b.h5").stat().st_size


@pytest.mark.parametrize("points", [2047, 2048, 65_536, 70_001])
def test_packed_chunks_are_what_the_librarys_own_filters_unpack(tmp_path: Path, points: int) -> None:
    """HDF5's own filters take the chunks apart again, whole columns and parts of them."""
    rng = np.random.default_rng(points)
    columns: dict[str, NDArray[Any]] = {
        "noise": rng.standard_normal(points),
        "smooth": np.linspace(0.0, 1.0, points),
        "single": rng.standard_normal(points).astype("f4"),
        "flags": rng.choice([0, 64], points).astype("u2"),
        "zeros": np.zeros(points, dtype="i4"),
        "time": np.arange(points) * 1_000_017 + 1_700_000_000_000_000_000,
    }
    with h5py.File(tmp_path / "a.h5", "w") as file, PointPacker() as packer, PointWriter(packer) as writer:
        for name, values in columns.items():
            writer.add(file, name, values, "deg")
    with h5py.File(tmp_path / "a.h5") as file:
        for name, values in columns.items():
            np.testing.assert_array_equal(file[name][...], values, err_msg=name)
            assert file[name].dtype == values.dtype
            np.testing.assert_array_equal(file[name][points // 2 :], values[points // 2 :])
        if points >= 2048:
            assert file["time"].id.get_storage_size() < 0.2 * columns["time"].nbytes
            assert file["noise"].id.get_storage_size() < 1.01 * columns["noise"].nbytes


def test_a_failed_write_waits_for_its_threads_and_tells_the_cause(tmp_path: Path) -> None:
    def fail() -> None:
        with h5py.File(tmp_path / "a.h5", "w") as file, PointPacker() as packer, PointWriter(packer) as writer:
            writer.add(file, "a", np.zeros(200_000))
            raise RuntimeError("the cause")

    with pytest.raises(RuntimeError, match="the cause"):
        fail()


def test_format_1_is_still_read(tmp_path: Path) -> None:
    """Format 1 was format 2 without effects, budgets, paths and linear weights, in the library's own chunks."""
    source = distribution(3000, 2)
    source.effects = {}
    write_dataset(Dataset([source], sample_name="old"), tmp_path / "a.h5")
    with h5py.File(tmp_path / "a.h5", "a") as file:
        file.attrs["gonio_format"] = 1
        data = file["incident_0000/data"]
        for name in ("theta", "dsf"):
            values, units = data[name][...], data[name].attrs["units"]
            del data[name]
            data.create_dataset(name, data=values, compression="gzip", shuffle=True, fletcher32=True)
            data[name].attrs["units"] = units
    assert_same(read_dataset(tmp_path / "a.h5"), Dataset([source], sample_name="old"))


def test_effects_keep_three_digits_and_say_what_they_are(tmp_path: Path) -> None:
    source = distribution(100, 1)
    source.effects = {"gain_ratio": np.random.default_rng(4).standard_normal(100) * 1e-4}
    write_dataset(Dataset([source]), tmp_path / "a.h5")
    back = read_dataset(tmp_path / "a.h5").distributions[0]
    np.testing.assert_allclose(back.effects["gain_ratio"], source.effects["gain_ratio"], rtol=5e-4)
    with h5py.File(tmp_path / "a.h5") as file:
        column = file["incident_0000/effects/effect_000"]
        assert (column.attrs["key"], column.attrs["units"]) == ("gain_ratio", "1/sr")
        assert "ratio of the gains" in column.attrs["long_name"]
        assert file["incident_0000/data/signal"].attrs["units"] == "A"
        assert file["incident_0000/instrument/beam/p_i"].attrs["units"] == "A*sr"
    source.effects["gain_ratio"] = np.zeros(3)
    with pytest.raises(ValueError, match="'gain_ratio' has shape"):
        write_dataset(Dataset([source]), tmp_path / "b.h5")


def test_provenance_takes_no_number_that_json_lacks(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="JSON"):
        write_dataset(Dataset([], provenance={"u": float("nan")}), tmp_path / "a.h5")


def test_a_nexus_reader_finds_the_default_plot_and_the_axes(tmp_path: Path) -> None:
    """Following `default`, `signal`, `axes` and `depends_on` as the NeXus manual prescribes leads to the direction."""
    instrument = load_instrument(None)
    source = distribution(50, 3, incident_theta_deg=40.0, incident_phi_deg=70.0)
    write_dataset(Dataset([source], provenance={"instrument_text": instrument.text}), tmp_path / "a.h5")
    with h5py.File(tmp_path / "a.h5") as file:
        data = file[file.attrs["default"]][file[file.attrs["default"]].attrs["default"]]
        np.testing.assert_array_equal(data[data.attrs["signal"]][...], source.dsf_per_sr)
        assert [data[name].shape for name in data.attrs["axes"]] == [(50,), (50,)]
        assert data["theta"].attrs["units"] == "deg"
        np.testing.assert_allclose(data["dsf_errors"][...] ** 2, source.variance_per_sr2, rtol=1e-14)
        detector, at_arm = np.zeros((50, 3)), file["incident_0000/instrument/detector"]
        node = at_arm["depends_on"].asstr()[()]
        while node != ".":
            step = file[node]
            vector, value = step.attrs["vector"], step[...]
            if step.attrs["transformation_type"] == "translation":
                detector = detector + value * vector
            else:
                turn = np.radians(np.broadcast_to(value, 50))[:, None]
                along = vector * (detector @ vector)[:, None]
                detector = along + (detector - along) * np.cos(turn) + np.cross(vector, detector) * np.sin(turn)
            node = step.attrs["depends_on"]
    q_deg = np.tile([40.0, 70.0, 0.0, 0.0], (50, 1))
    outgoing = unit_from_angles_deg(source.theta_deg, source.phi_deg)
    expected = Kinematics(instrument.axes).to_lab(q_deg, outgoing) * instrument.arm_radius_mm
    np.testing.assert_allclose(detector * [-1, 1, -1], expected, atol=1e-9)


@pytest.mark.parametrize("keep", [0.0, 0.1, 0.5, 0.97])
def test_truncated_file_is_one_sentence(tmp_path: Path, keep: float) -> None:
    path = tmp_path / "a.h5"
    write_dataset(Dataset([distribution(5000, 1)]), path)
    data = path.read_bytes()
    path.write_bytes(data[: int(len(data) * keep)])
    with pytest.raises(UsageError, match=r"a\.h5: foreign, truncated or damaged") as caught:
        read_dataset(path)
    assert "\n" not in str(caught.value)


def test_foreign_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no such file"):
        read_dataset(tmp_path / "none.h5")
    (tmp_path / "text.h5").write_text("theta,phi\n")
    with pytest.raises(UsageError, match="foreign"):
        read_dataset(tmp_path / "text.h5")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["x"] = 1
    with pytest.raises(UsageError, match="not a gonio dataset"):
        read_dataset(tmp_path / "other.h5")
    with h5py.File(tmp_path / "newer.h5", "w") as file:
        file.attrs["gonio_format"] = 99
    with pytest.raises(UsageError, match="dataset format 99"):
        read_dataset(tmp_path / "newer.h5")
    with h5py.File(tmp_path / "gutted.h5", "w") as file:
        file.attrs["gonio_format"] = 1
    with pytest.raises(UsageError, match="foreign, truncated or damaged"):
        read_dataset(tmp_path / "gutted.h5")


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    write_dataset(Dataset([distribution(3, 1)]), path)
    before = path.read_bytes()
    wrong = distribution(3, 2)
    wrong.signal = wrong.signal[:2]
    with pytest.raises(ValueError, match="signal has shape"):
        write_dataset(Dataset([wrong]), path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["a.h5"]
    with pytest.raises(UsageError, match="cannot write the dataset"):
        write_dataset(Dataset([]), tmp_path / "no such folder" / "a.h5")
