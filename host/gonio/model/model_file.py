"""model_file.py: models as HDF5: what was fitted, whole and exact, so that a file answers as the model did.

Layout: attributes gonio_model (version) and digest (SHA-256 over all that follows); dataset "header" (JSON: sample,
integrals, validity, provenance); group channels/<number> with attribute name and either "family" (JSON of an analytic
model) or components/<name>/ with attribute scheme, "signs", "bound" and nodes/<number>/ with the arrays of a Node.
"""

import hashlib
import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeVar

import h5py
import numpy as np

from gonio.dataset.scattering import Bsdf, MeasuredIntegral, Scattering
from gonio.dataset.written_whole import written_whole
from gonio.model.analytic import AnalyticScattering
from gonio.model.between.energy import Bound
from gonio.model.between.resolve import Resolver
from gonio.model.between.scheme import named
from gonio.model.channel import Fitted, FittedComponent
from gonio.model.nodes.node import Node
from gonio.model.nodes.points import COMPONENTS
from gonio.model.nodes.symmetry import Images
from gonio.units.errors import UsageError

FORMAT = 1
_ARRAYS = ("incident", "centre", "log_peak", "log_covariance", "background", "coverage")
_NUMBERS = ("points", "integral", "stated", "stated_u", "scale")
_T = TypeVar("_T")


def write_model(bsdf: Bsdf, path: Path) -> None:
    """Write a Bsdf of fitted or analytic channels: beside its place first. UsageError if the folder takes no file;
    TypeError for a channel of another kind (it has a file of its own already)."""
    with written_whole(path, "model") as file:
        file.attrs["creator"] = "gonio"
        file.attrs["gonio_model"] = FORMAT
        _put_text(file, "header", _header(bsdf))
        channels = file.create_group("channels")
        for number, (name, channel) in enumerate(bsdf.channels.items()):
            group = channels.create_group(f"{number:03d}")
            group.attrs["name"] = name
            _write_channel(group, channel)
        file.attrs["digest"] = _digest(file)


def read_model(path: Path) -> Bsdf:
    """Read what write_model wrote. UsageError for a missing, foreign, newer, changed or damaged file."""
    return _open(path, _read)


def is_model(path: Path) -> bool:
    """Whether this is a model's file, of whatever version."""
    try:
        with h5py.File(path, "r") as file:
            return "gonio_model" in file.attrs
    except OSError:
        return False


def _open(path: Path, read: Callable[[h5py.File], _T]) -> _T:
    if not path.is_file():
        raise UsageError(f"{path}: no such file: give a model that gonio fit wrote")
    try:
        with h5py.File(path, "r") as file:
            found = file.attrs.get("gonio_model")
            if found is None:
                raise UsageError(f"{path}: not a model: give a file that gonio fit wrote")
            if int(found) != FORMAT:
                raise UsageError(f"{path}: model format {found}; this gonio reads {FORMAT}: update gonio or fit again")
            if file.attrs.get("digest") != _digest(file):
                raise UsageError(f"{path}: was changed after it was written: fit again")
            return read(file)
    except (OSError, KeyError, ValueError, TypeError, RuntimeError, AttributeError, IndexError) as error:
        reason = (str(error).strip("'\"").splitlines() or [type(error).__name__])[0]
        raise UsageError(f"{path}: foreign, truncated or damaged ({reason}): fit or copy it again") from error


def _digest(file: h5py.File) -> str:
    """Over names, attributes and contents of everything below the root, in order of names."""
    sum_ = hashlib.sha256()

    def add(name: str, item: Any) -> None:
        sum_.update(name.encode() + b"\0")
        for key in sorted(item.attrs):
            sum_.update(f"{key}={item.attrs[key]}".encode() + b"\0")
        if isinstance(item, h5py.Dataset):
            array = np.asarray(item[()])
            sum_.update(f"{array.dtype.str}{array.shape}".encode())
            sum_.update(np.ascontiguousarray(array).tobytes())

    file.visititems(add)
    return sum_.hexdigest()


def _put(group: h5py.Group, name: str, array: Any) -> None:
    data = np.asarray(array)
    packed = {"compression": "gzip", "compression_opts": 4, "shuffle": True} if data.size > 64 else {}
    group.create_dataset(name, data=data, **packed)


def _put_text(group: h5py.Group, name: str, value: Any) -> None:
    text = json.dumps(value, allow_nan=False).encode()
    _put(group, name, np.frombuffer(text, dtype=np.uint8))


def _text(group: h5py.Group, name: str) -> Any:
    return json.loads(np.asarray(group[name][()], dtype=np.uint8).tobytes())


def _header(bsdf: Bsdf) -> dict[str, Any]:
    return {
        "sample_name": bsdf.sample_name,
        "manufacturer": bsdf.manufacturer,
        "front_faces": bsdf.front_faces,
        "symmetry": bsdf.symmetry,
        "polarisation": bsdf.polarisation,
        "thickness_mm": bsdf.thickness_mm,
        "band_nm": {name: list(band) for name, band in bsdf.band_nm.items()},
        "measured": [asdict(m) for m in bsdf.measured],
        "validity": list(bsdf.validity),
        "provenance": bsdf.provenance,
    }


def _write_channel(group: h5py.Group, channel: Scattering) -> None:
    if isinstance(channel, AnalyticScattering):
        _put_text(group, "family", channel.to_json())
        return
    if not isinstance(channel, Fitted):
        raise TypeError(f"{type(channel).__name__} is no model")
    for component, model in channel.components.items():
        own = group.create_group(f"components/{component.name}")
        resolver = model.resolver
        own.attrs["scheme"] = resolver.scheme.name
        own.attrs["symmetry"] = resolver.images.symmetry
        _put(own, "signs", np.array(resolver.images.signs, dtype=np.int64))
        _put(own, "node_integral", model.bound.node_integral)
        if model.bound.table is not None:
            _put(own, "bound", model.bound.table)
        for number, node in enumerate(resolver.nodes):
            place = own.create_group(f"nodes/{number:05d}")
            for name in _ARRAYS:
                _put(place, name, getattr(node, name))
            for name in _NUMBERS:
                place.attrs[name] = getattr(node, name)
            for index, patch in enumerate(node.patch):
                _put(place, f"patch/{index:03d}", patch)


def _read(file: h5py.File) -> Bsdf:
    header = _text(file, "header")
    header["band_nm"] = {name: tuple(band) for name, band in header["band_nm"].items()}
    header["measured"] = tuple(MeasuredIntegral(**m) for m in header["measured"])
    header["validity"] = tuple(header["validity"])
    groups = [file["channels"][key] for key in sorted(file["channels"])]
    return Bsdf(channels={str(g.attrs["name"]): _read_channel(g) for g in groups}, **header)


def _read_channel(group: h5py.Group) -> Scattering:
    if "family" in group:
        return AnalyticScattering.from_json(_text(group, "family"))
    found = group["components"]
    return Fitted({c: _read_component(found[c.name]) for c in COMPONENTS if c.name in found})


def _read_component(group: h5py.Group) -> FittedComponent:
    signs = tuple((int(x), int(y)) for x, y in group["signs"][()])
    nodes = [_read_node(group["nodes"][key]) for key in sorted(group["nodes"])]
    resolver = Resolver(nodes, Images(group.attrs["symmetry"], signs), named(group.attrs["scheme"]))
    table = group["bound"][()] if "bound" in group else None
    return FittedComponent(resolver, Bound(group["node_integral"][()], table))


def _read_node(group: h5py.Group) -> Node:
    patch = tuple(group["patch"][key][()] for key in sorted(group["patch"])) if "patch" in group else ()
    found: dict[str, Any] = {name: group[name][()] for name in _ARRAYS}
    found |= {name: float(group.attrs[name]) for name in _NUMBERS}
    return Node(**{**found, "points": int(found["points"]), "patch": patch})
