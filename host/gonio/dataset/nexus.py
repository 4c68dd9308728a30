"""nexus.py: a dataset as HDF5 in NeXus form: one NXentry per distribution, point lists in NXdata, exactly."""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import h5py
import numpy as np

from gonio.dataset.bsdf import Dataset, Distribution, PointFlag
from gonio.dataset.nexus_axes import write_axes
from gonio.units.errors import UsageError

FORMAT = 1
# Field of Distribution: (name in NXdata, units, stored type).
POINT_FIELDS = {
    "theta_deg": ("theta", "deg", "f8"),
    "phi_deg": ("phi", "deg", "f8"),
    "dsf_per_sr": ("dsf", "1/sr", "f8"),
    "variance_per_sr2": ("dsf_variance", "1/sr^2", "f8"),
    "signal": ("signal", "counts", "f8"),
    "normalisation": ("normalisation", "", "f8"),
    "count": ("count", "", "i4"),
    "flags": ("flags", "", "u2"),
    "solid_angle_sr": ("solid_angle", "sr", "f8"),
    "time_ns": ("time", "ns", "i8"),
}
SCALAR_FIELDS = {
    "incident_theta_deg": ("incident_theta", "deg"),
    "incident_phi_deg": ("incident_phi", "deg"),
    "p_i": ("p_i", "counts*sr"),
    "p_i_u_rel": ("p_i_u_rel", ""),
    "wavelength_nm": ("incident_wavelength", "nm"),
}
SAMPLE_FIELDS = ("front_faces", "polarisation", "symmetry", "manufacturer")
# Below this many points compression and its chunk index cost more than they save.
_COMPRESS_FROM = 2048
_T = TypeVar("_T")


def write_dataset(dataset: Dataset, path: Path) -> None:
    """Write `dataset` to `path`: beside it first, then in its place. Raises UsageError if the folder takes no file and
    ValueError if the arrays of a distribution differ in shape."""
    beside = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with h5py.File(beside, "w") as file:
            _write_root(file, dataset)
        with beside.open("rb") as written:
            os.fsync(written.fileno())
        os.replace(beside, path)
    except OSError as error:
        raise UsageError(f"{path}: cannot write the dataset ({error}): check folder, rights and space") from error
    finally:
        beside.unlink(missing_ok=True)


def read_dataset(path: Path) -> Dataset:
    """Read what write_dataset wrote. Raises UsageError for a missing, foreign, newer or damaged file."""
    return _open(path, _read_root)


def _open(path: Path, read: Callable[[h5py.File], _T]) -> _T:
    """Run `read` on the open file; whatever is wrong with the file becomes one sentence."""
    if not path.is_file():
        raise UsageError(f"{path}: no such file: give a dataset that gonio reduce or gonio import wrote")
    try:
        with h5py.File(path, "r") as file:
            found = file.attrs.get("gonio_format")
            if found is None:
                raise UsageError(f"{path}: HDF5, but not a gonio dataset: give a file that gonio reduce wrote")
            if int(found) != FORMAT:
                raise UsageError(f"{path}: dataset format {found}; this gonio reads {FORMAT}: update gonio")
            return read(file)
    except (OSError, KeyError, ValueError, TypeError, RuntimeError) as error:
        reason = str(error).strip("'\"").splitlines()[0]
        raise UsageError(f"{path}: foreign, truncated or damaged ({reason}): reduce or copy it again") from error


def _write_root(file: h5py.File, dataset: Dataset) -> None:
    file.attrs["NX_class"] = "NXroot"
    file.attrs["creator"] = "gonio"
    file.attrs["gonio_format"] = FORMAT
    general = _group(file, "dataset", "NXentry")
    general["title"] = dataset.sample_name
    process = _group(general, "process", "NXprocess")
    process["program"] = "gonio"
    process["provenance_json"] = json.dumps(dataset.provenance)
    process["provenance_json"].attrs["type"] = "application/json"
    _write_sample(general, dataset)
    names = [f"incident_{number:04d}" for number in range(len(dataset.distributions))]
    for name, distribution in zip(names, dataset.distributions, strict=True):
        _write_distribution(file, name, distribution, dataset)
    if dataset.beam is not None:
        _write_distribution(file, "beam", dataset.beam, None)
    file.attrs["default"] = names[0] if names else "dataset"


def _group(parent: h5py.Group, name: str, nx_class: str) -> h5py.Group:
    group = parent.create_group(name)
    group.attrs["NX_class"] = nx_class
    return group


def _scalar(parent: h5py.Group, name: str, value: Any, units: str) -> None:
    parent[name] = value
    if units:
        parent[name].attrs["units"] = units


def _write_sample(entry: h5py.Group, dataset: Dataset) -> h5py.Group:
    sample = _group(entry, "sample", "NXsample")
    sample["name"] = dataset.sample_name
    for name in SAMPLE_FIELDS:
        sample[name] = getattr(dataset, name)
    if dataset.thickness_mm is not None:
        _scalar(sample, "thickness", float(dataset.thickness_mm), "mm")
    return sample


def _write_distribution(file: h5py.File, name: str, distribution: Distribution, dataset: Dataset | None) -> None:
    """One NXentry. `dataset` is None for the free beam, which has no sample in it."""
    entry = _group(file, name, "NXentry")
    entry.attrs["default"] = "data"
    theta, phi = distribution.incident_theta_deg, distribution.incident_phi_deg
    entry["title"] = "free beam" if dataset is None else f"DSF at incident theta {theta:g}, phi {phi:g} degrees"
    data = _group(entry, "data", "NXdata")
    data.attrs["signal"] = "dsf"
    data.attrs["axes"] = ["theta", "phi"]  # two coordinates of one dimension: a point list
    data.attrs["theta_indices"] = 0
    data.attrs["phi_indices"] = 0
    points = len(distribution.theta_deg)
    for field, (stored, units, kind) in POINT_FIELDS.items():
        values = np.asarray(getattr(distribution, field))
        if values.shape != (points,):
            raise ValueError(f"{field} has shape {values.shape}, theta_deg has ({points},)")
        _write_points(data, stored, values.astype(kind), units)
    _write_points(data, "dsf_errors", np.sqrt(distribution.variance_per_sr2), "1/sr")
    data["flags"].attrs["bits"] = [f"{flag.value} {flag.name}" for flag in PointFlag]
    instrument = _group(entry, "instrument", "NXinstrument")
    beam = _group(instrument, "beam", "NXbeam")
    beam["channel"] = distribution.channel
    for field, (stored, units) in SCALAR_FIELDS.items():
        value = getattr(distribution, field)
        if value is not None:
            _scalar(beam, stored, float(value), units)
    _group(instrument, "detector", "NXdetector")["data"] = data["signal"]
    integrals = _group(entry, "integrals", "NXcollection")
    integrals["name"] = np.array(list(distribution.integrals), dtype=h5py.string_dtype())
    integrals["value"] = np.array(list(distribution.integrals.values()), dtype=np.float64)
    if dataset is not None:
        sample = _write_sample(entry, dataset)
        write_axes(instrument, sample, distribution, dataset.provenance)


def _write_points(group: h5py.Group, name: str, values: Any, units: str) -> None:
    large = len(values) >= _COMPRESS_FROM
    options = {"compression": "gzip", "compression_opts": 1, "shuffle": True, "fletcher32": True} if large else {}
    group.create_dataset(name, data=values, **options)
    if units:
        group[name].attrs["units"] = units


def _read_root(file: h5py.File) -> Dataset:
    general = file["dataset"]
    sample = general["sample"]
    described: dict[str, Any] = {name: _text(sample, name) for name in SAMPLE_FIELDS}
    names = sorted((name for name in file if name.startswith("incident_")), key=lambda name: int(name[9:]))
    return Dataset(
        distributions=[_read_distribution(file[name]) for name in names],
        sample_name=_text(sample, "name"),
        thickness_mm=float(sample["thickness"][()]) if "thickness" in sample else None,
        provenance=json.loads(_text(general["process"], "provenance_json")),
        beam=_read_distribution(file["beam"]) if "beam" in file else None,
        **described,
    )


def _text(group: h5py.Group, name: str) -> str:
    return str(group[name].asstr()[()])


def _read_distribution(entry: h5py.Group) -> Distribution:
    beam, data, integrals = entry["instrument/beam"], entry["data"], entry["integrals"]
    values: dict[str, Any] = {
        field: float(beam[name][()]) for field, (name, _) in SCALAR_FIELDS.items() if name in beam
    }
    for field, (name, _, kind) in POINT_FIELDS.items():
        values[field] = data[name][...].astype(kind, copy=False)
    results = (float(value) for value in integrals["value"][...])
    return Distribution(
        **values,
        channel=_text(beam, "channel"),
        integrals=dict(zip(integrals["name"].asstr()[...], results, strict=True)),
    )
