"""nexus.py: a dataset as HDF5 in NeXus form: one NXentry per distribution, point lists in NXdata, exactly."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import h5py

from gonio.dataset.bsdf import Dataset
from gonio.dataset.nexus_entry import (
    SAMPLE_FIELDS,
    add_group,
    begin_points,
    read_entry,
    read_text,
    write_entry,
    write_sample,
)
from gonio.dataset.nexus_points import PointPacker, PointWriter
from gonio.dataset.written_whole import written_whole
from gonio.units.errors import UsageError

__all__ = [
    "FORMAT",
    "PointPacker",
    "begin_points",
    "read_dataset",
    "read_provenance",
    "read_scattering",
    "write_dataset",
]
FORMAT = 2
_READABLE = (1, 2)
_T = TypeVar("_T")


def write_dataset(dataset: Dataset, path: Path, packer: PointPacker | None = None) -> None:
    """Write `dataset` to `path`: beside it first, then in its place. `packer`: see begin_points. Raises UsageError if
    the folder takes no file and ValueError if the arrays of a distribution differ in shape."""
    if packer is None:
        with PointPacker() as own:
            write_dataset(dataset, path, own)
        return
    with written_whole(path, "dataset") as file, PointWriter(packer) as writer:
        _write_root(file, dataset, writer)


def read_dataset(path: Path) -> Dataset:
    """Read what write_dataset wrote. Raises UsageError for a missing, foreign, newer or damaged file."""
    return _open(path, _read_root)


def read_scattering(path: Path) -> Dataset:
    """The same for models: directions, DSF, variance, flags and solid angles are read; of the other columns there are
    neither values nor effects (nexus_entry.read_entry), and no free beam. Raises UsageError as read_dataset does."""
    return _open(path, lambda file: _read_root(file, scattering_only=True))


def read_provenance(path: Path) -> dict[str, Any]:
    """The provenance alone, without the points. Raises UsageError as read_dataset does."""
    return _open(path, _read_provenance)


def _open(path: Path, read: Callable[[h5py.File], _T]) -> _T:
    """Run `read` on the open file; whatever is wrong with the file becomes one sentence."""
    if not path.is_file():
        raise UsageError(f"{path}: no such file: give a dataset that gonio reduce or gonio import wrote")
    try:
        with h5py.File(path, "r") as file:
            found = file.attrs.get("gonio_format")
            if found is None:
                raise UsageError(f"{path}: HDF5, but not a gonio dataset: give a file that gonio reduce wrote")
            if int(found) not in _READABLE:
                raise UsageError(f"{path}: dataset format {found}; this gonio reads 1 to {FORMAT}: update gonio")
            return read(file)
    except (OSError, KeyError, ValueError, TypeError, RuntimeError) as error:
        reason = str(error).strip("'\"").splitlines()[0]
        raise UsageError(f"{path}: foreign, truncated or damaged ({reason}): reduce or copy it again") from error


def _write_root(file: h5py.File, dataset: Dataset, writer: PointWriter) -> None:
    file.attrs["NX_class"] = "NXroot"
    file.attrs["creator"] = "gonio"
    file.attrs["gonio_format"] = FORMAT
    general = add_group(file, "dataset", "NXentry")
    general["title"] = dataset.sample_name
    process = add_group(general, "process", "NXprocess")
    process["program"] = "gonio"
    process["provenance_json"] = json.dumps(dataset.provenance, allow_nan=False)
    process["provenance_json"].attrs["type"] = "application/json"
    write_sample(general, dataset)
    names = [f"incident_{number:04d}" for number in range(len(dataset.distributions))]
    for name, distribution in zip(names, dataset.distributions, strict=True):
        write_entry(file, name, distribution, dataset, writer)
    if dataset.beam is not None:
        write_entry(file, "beam", dataset.beam, None, writer)
    file.attrs["default"] = names[0] if names else "dataset"


def _read_root(file: h5py.File, *, scattering_only: bool = False) -> Dataset:
    general = file["dataset"]
    sample = general["sample"]
    described: dict[str, Any] = {name: read_text(sample, name) for name in SAMPLE_FIELDS}
    names = sorted((name for name in file if name.startswith("incident_")), key=lambda name: int(name[9:]))
    return Dataset(
        distributions=[read_entry(file[name], scattering_only=scattering_only) for name in names],
        sample_name=read_text(sample, "name"),
        thickness_mm=float(sample["thickness"][()]) if "thickness" in sample else None,
        provenance=_read_provenance(file),
        beam=read_entry(file["beam"]) if "beam" in file and not scattering_only else None,
        **described,
    )


def _read_provenance(file: h5py.File) -> dict[str, Any]:
    provenance = json.loads(read_text(file["dataset/process"], "provenance_json"))
    return provenance if isinstance(provenance, dict) else {}
