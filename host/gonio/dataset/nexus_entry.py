"""nexus_entry.py: one distribution as an NXentry and back: points, effects, integrals with their budgets."""

from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Distribution, PointFlag
from gonio.dataset.effects import effect_of
from gonio.dataset.nexus_axes import write_axes
from gonio.dataset.nexus_points import PointPacker, PointWriter

# Field of Distribution: (name in NXdata, units, stored type); "signal" stands for the unit of the signal.
POINT_FIELDS = {
    "theta_deg": ("theta", "deg", "f8"),
    "phi_deg": ("phi", "deg", "f8"),
    "dsf_per_sr": ("dsf", "1/sr", "f8"),
    "variance_per_sr2": ("dsf_variance", "1/sr^2", "f8"),
    "signal": ("signal", "signal", "f8"),
    "normalisation": ("normalisation", "", "f8"),
    "count": ("count", "", "i4"),
    "flags": ("flags", "", "u2"),
    "solid_angle_sr": ("solid_angle", "sr", "f8"),
    "time_ns": ("time", "ns", "i8"),
}
SCATTERING_FIELDS = ("theta_deg", "phi_deg", "dsf_per_sr", "variance_per_sr2", "flags", "solid_angle_sr")
# Empty where they are not known; then they are not in the file.
OPTIONAL_FIELDS = {
    "linear_solid_angle_sr": ("linear_solid_angle", "sr", "f8"),
    "path": ("path", "", "i4"),
}
SCALAR_FIELDS = {
    "incident_theta_deg": ("incident_theta", "deg"),
    "incident_phi_deg": ("incident_phi", "deg"),
    "p_i": ("p_i", "signal*sr"),
    "p_i_u_rel": ("p_i_u_rel", ""),
    "wavelength_nm": ("incident_wavelength", "nm"),
}
SAMPLE_FIELDS = ("front_faces", "polarisation", "symmetry", "manufacturer")


def add_group(parent: h5py.Group, name: str, nx_class: str) -> h5py.Group:
    """A new group of a NeXus class."""
    group = parent.create_group(name)
    group.attrs["NX_class"] = nx_class
    return group


def add_scalar(parent: h5py.Group, name: str, value: Any, units: str) -> None:
    """A single value with its units."""
    parent[name] = value
    if units:
        parent[name].attrs["units"] = units


def write_sample(entry: h5py.Group, dataset: Dataset) -> h5py.Group:
    """The sample as NXsample of an entry."""
    sample = add_group(entry, "sample", "NXsample")
    sample["name"] = dataset.sample_name
    for name in SAMPLE_FIELDS:
        sample[name] = getattr(dataset, name)
    if dataset.thickness_mm is not None:
        add_scalar(sample, "thickness", float(dataset.thickness_mm), "mm")
    return sample


def begin_points(distribution: Distribution, packer: PointPacker) -> None:
    """Begin to pack the columns of a distribution whose points do not change any more; write_dataset with the same
    packer will find them ready."""
    for field, (_, _, kind) in (POINT_FIELDS | OPTIONAL_FIELDS).items():
        values = np.asarray(getattr(distribution, field))
        if values.dtype == kind:
            packer.begin(values)
    packer.begin(distribution.variance_per_sr2, np.sqrt)
    for values in distribution.effects.values():
        packer.begin(values, three_digits)


def write_entry(
    file: h5py.File, name: str, distribution: Distribution, dataset: Dataset | None, writer: PointWriter
) -> None:
    """One NXentry. `dataset` is None for the free beam, which has no sample in it. Raises ValueError if the arrays
    differ in shape."""
    entry = add_group(file, name, "NXentry")
    entry.attrs["default"] = "data"
    theta, phi = distribution.incident_theta_deg, distribution.incident_phi_deg
    entry["title"] = "free beam" if dataset is None else f"DSF at incident theta {theta:g}, phi {phi:g} degrees"
    data = _write_points(entry, distribution, writer)
    _write_effects(entry, distribution, writer)
    instrument = add_group(entry, "instrument", "NXinstrument")
    beam = add_group(instrument, "beam", "NXbeam")
    beam["channel"] = distribution.channel
    for field, (stored, units) in SCALAR_FIELDS.items():
        value = getattr(distribution, field)
        if value is not None:
            add_scalar(beam, stored, float(value), units.replace("signal", distribution.signal_unit))
    add_group(instrument, "detector", "NXdetector")["data"] = data["signal"]
    _write_integrals(entry, distribution)
    if dataset is not None:
        write_axes(instrument, write_sample(entry, dataset), distribution, dataset.provenance, writer)


def _write_points(entry: h5py.Group, distribution: Distribution, writer: PointWriter) -> h5py.Group:
    data = add_group(entry, "data", "NXdata")
    data.attrs["signal"] = "dsf"
    data.attrs["axes"] = ["theta", "phi"]  # two coordinates of one dimension: a point list
    data.attrs["theta_indices"] = 0
    data.attrs["phi_indices"] = 0
    points = len(distribution.theta_deg)
    for field, (stored, units, kind) in (POINT_FIELDS | OPTIONAL_FIELDS).items():
        values = np.asarray(getattr(distribution, field))
        if field in OPTIONAL_FIELDS and len(values) == 0 < points:
            continue
        if values.shape != (points,):
            raise ValueError(f"{field} has shape {values.shape}, theta_deg has ({points},)")
        column = values.astype(kind, copy=False)
        writer.add(data, stored, column, units if units != "signal" else distribution.signal_unit)
    writer.add(data, "dsf_errors", distribution.variance_per_sr2, "1/sr", np.sqrt)
    data["flags"].attrs["bits"] = [f"{flag.value} {flag.name}" for flag in PointFlag]
    if distribution.paths:
        _write_texts(data, "paths", list(distribution.paths))
    return data


def _write_effects(entry: h5py.Group, distribution: Distribution, writer: PointWriter) -> None:
    """Single precision, three digits of it: an effect is known to two at best, and the bytes of the rest, which are
    zero then, take no room."""
    if not distribution.effects:
        return
    effects = add_group(entry, "effects", "NXcollection")
    effects.attrs["meaning"] = "change of the DSF for one standard deviation of each systematic effect"
    for number, (key, values) in enumerate(distribution.effects.items()):
        if values.shape != distribution.theta_deg.shape:
            raise ValueError(f"effect {key!r} has shape {values.shape}, theta_deg has {distribution.theta_deg.shape}")
        column = writer.add(effects, f"effect_{number:03d}", values, "1/sr", three_digits)
        column.attrs["key"] = key
        try:
            column.attrs["long_name"] = effect_of(key).words
        except KeyError:  # of a later version
            continue


def three_digits(values: NDArray[np.float64]) -> NDArray[np.float32]:
    """Values (n,) in single precision, rounded to the first 10 of its 23 bits after the point: within 5e-4 of each."""
    bits = values.astype(np.float32).view(np.uint32)
    return ((bits + np.uint32(1 << 12)) & np.uint32(0xFFFFE000)).view(np.float32)


def _write_integrals(entry: h5py.Group, distribution: Distribution) -> None:
    integrals = add_group(entry, "integrals", "NXcollection")
    _write_texts(integrals, "name", list(distribution.integrals))
    integrals["value"] = np.array(list(distribution.integrals.values()), dtype=np.float64)
    if not distribution.budgets:
        return
    rows = [(name, effect, part) for name, parts in distribution.budgets.items() for effect, part in parts.items()]
    budgets = add_group(integrals, "budgets", "NXcollection")
    budgets.attrs["meaning"] = "contribution of each effect to the standard uncertainty of an integral"
    _write_texts(budgets, "integral", [name for name, _, _ in rows])
    _write_texts(budgets, "effect", [effect for _, effect, _ in rows])
    budgets["contribution"] = np.array([part for _, _, part in rows], dtype=np.float64)


def _write_texts(group: h5py.Group, name: str, texts: list[str]) -> None:
    group[name] = np.array(texts, dtype=h5py.string_dtype())


def read_text(group: h5py.Group, name: str) -> str:
    """A single text."""
    return str(group[name].asstr()[()])


def read_entry(entry: h5py.Group, *, scattering_only: bool = False) -> Distribution:
    """What write_entry wrote, also in format 1, which had no effects, budgets, paths and linear weights.

    scattering_only: of the columns no more than SCATTERING_FIELDS; the others are NaN or 0 and take neither time nor
    room, those that may be empty are.
    """
    beam, data = entry["instrument/beam"], entry["data"]
    values: dict[str, Any] = {
        field: float(beam[name][()]) for field, (name, _) in SCALAR_FIELDS.items() if name in beam
    }
    for field, (name, _, kind) in (POINT_FIELDS | OPTIONAL_FIELDS).items():
        if scattering_only and field not in SCATTERING_FIELDS:
            if field in POINT_FIELDS:
                unread = np.array(np.nan if kind == "f8" else 0, dtype=kind)
                values[field] = np.broadcast_to(unread, data[name].shape)
        elif field in POINT_FIELDS or name in data:
            values[field] = data[name][...].astype(kind, copy=False)
    integrals = entry["integrals"]
    budgets: dict[str, dict[str, float]] = {}
    if "budgets" in integrals:
        table = integrals["budgets"]
        rows = zip(_texts(table, "integral"), _texts(table, "effect"), table["contribution"][...], strict=True)
        for name, effect, part in rows:
            budgets.setdefault(name, {})[effect] = float(part)
    has_effects = "effects" in entry and not scattering_only
    stored = [entry["effects"][name] for name in sorted(entry["effects"])] if has_effects else []
    return Distribution(
        **values,
        channel=read_text(beam, "channel"),
        signal_unit=str(data["signal"].attrs["units"]),
        paths=tuple(_texts(data, "paths")) if "paths" in data and not scattering_only else (),
        integrals=dict(zip(_texts(integrals, "name"), map(float, integrals["value"][...]), strict=True)),
        budgets=budgets,
        effects={str(column.attrs["key"]): column[...].astype(np.float64) for column in stored},
    )


def _texts(group: h5py.Group, name: str) -> list[str]:
    return [str(text) for text in group[name].asstr()[...]]
