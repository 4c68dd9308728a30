"""from_model.py: the matrices of a WINDOW file from whatever answers in any direction: averages over both patches."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Side
from gonio.dataset.scattering import Bsdf, FloatArray, Origin, Scattering
from gonio.formats import atomic, validity
from gonio.formats.patches.average import TOLERANCE, Key, PatchMatrices, average
from gonio.formats.patches.hemispheres import Component
from gonio.formats.solar.weighted import Weighted
from gonio.formats.window import cells_table as klems_cells
from gonio.formats.window import energy as klems_energy
from gonio.formats.window import write as window_xml
from gonio.formats.window.klems import KlemsBasis, basis_named
from gonio.formats.window.matrices import (
    BANDS,
    MODELLED,
    PROCESSES,
    SIDES,
    Band,
    KlemsMatrices,
    MatrixSet,
    clip,
    empty_set,
)
from gonio.units.errors import UsageError

_PROBE = 0.5 / np.sqrt(3.0)  # from a patch's middle, in its widths: where the origin of a cell is asked for
XYZ: dict[str, Band] = {"X": "CIE-X", "Y": "Visible", "Z": "CIE-Z"}


@dataclass(frozen=True)
class ModelFile:
    """What to write: `channels` by band of the file; `notes` for <Comments>, one sentence each."""

    channels: Mapping[Band, str]
    assume_flat: bool = False
    rescale: bool = False
    notes: tuple[str, ...] = ()


def channels_of(bsdf: Bsdf, *, channel: str | None = None, xyz: Mapping[str, str] | None = None) -> dict[Band, str]:
    """Channel per band: `xyz` names those of X, Y and Z; `channel` the visible one (solar, if it is called so); else
    those that are called visible and solar. UsageError for what is not there."""
    found: dict[Band, str] = {}
    for name in bsdf.channels:
        for band in BANDS:
            if name.lower() == band.lower():
                found[band] = name
    if channel is not None:
        _known(bsdf, channel)
        if channel.lower() != "solar":
            found = {"Visible": channel, **{band: name for band, name in found.items() if band == "Solar"}}
        else:
            found = {"Solar": channel}
    if xyz is not None:
        for name in xyz.values():
            _known(bsdf, name)
        found |= {XYZ[letter]: name for letter, name in xyz.items()}
    if not found:
        raise UsageError(f"no channel is called visible or solar; name one with --channel: {', '.join(bsdf.channels)}")
    return found


def _known(bsdf: Bsdf, name: str) -> None:
    if name not in bsdf.channels:
        raise UsageError(f"no channel {name!r}; there is {', '.join(bsdf.channels)}")


def build(
    bsdf: Bsdf,
    what: ModelFile,
    *,
    basis: KlemsBasis,
    front: Side | None = None,
    averages: Mapping[str, PatchMatrices] | None = None,
) -> KlemsMatrices:
    """Matrices of all bands, with the origin of every cell. `front` goes before bsdf.front_faces; `averages` are those
    that are known already, by channel.

    Raises UsageError for what is undeclared, CheckFailed where more light leaves than arrives.
    """
    if bsdf.symmetry == "undeclared" and not _from_file(bsdf):
        raise UsageError(
            "the sample's symmetry is not declared and is never guessed: give --symmetry "
            "isotropic, bilateral, quadrilateral, up or none"
        )
    faces = front or bsdf.front_faces
    made = KlemsMatrices(basis, {}, faces, channel_of=dict(what.channels), source=_source(bsdf))
    done = dict(averages or {})
    bands: list[Band] = [*BANDS, *(band for band in what.channels if band not in BANDS)]
    for band in bands:
        name = what.channels.get(band)
        block = made.bands[band] = empty_set(basis)
        if name is None:
            continue
        averaged = _averaged(bsdf, name, done, basis, faces)
        for key, values in averaged.matrices.items():
            block.matrices[key][:] = values
            block.origin[key][:] = MODELLED
            block.cells[key] = _cells(bsdf, name, key, basis, faces)
        clip(block, basis)
        if band in BANDS:
            _check(block, bsdf, name, band, made, rescale=what.rescale)
        made.notes += _precision(band, averaged, block, basis)
    if what.assume_flat and sum(band in what.channels for band in BANDS) == 1:
        source: Band = "Visible" if "Visible" in what.channels else "Solar"
        target: Band = "Solar" if source == "Visible" else "Visible"
        made.bands[target] = made.bands[source]
        made.copied = (source, target)
    made.notes += [*what.notes, *bsdf.validity]
    made.notes.append(validity.line(replace(bsdf, front_faces=faces, channels=_by_band(bsdf, made))))
    return made


def write(
    bsdf: Bsdf,
    path: Path,
    what: ModelFile,
    *,
    basis: str,
    front: Side | None = None,
    cells: Path | None = None,
    thermal: window_xml.ThermalValues | None = None,
    averages: Mapping[str, PatchMatrices] | None = None,
) -> KlemsMatrices:
    """Writes WINDOW XML, and with `cells` a table of every cell's value and origin; both are written or none. Other
    arguments and what is raised: `build`."""
    made = build(bsdf, what, basis=basis_named(basis), front=front, averages=averages)
    files = {path: window_xml.render(bsdf, made, thermal or window_xml.ThermalValues())}
    if cells is not None:
        files[cells] = klems_cells.render(made)
    atomic.write_set(files)
    return made


def _averaged(bsdf: Bsdf, name: str, done: dict[str, PatchMatrices], basis: KlemsBasis, faces: Side) -> PatchMatrices:
    """A channel's averages; of a weighted mean of channels the mean of theirs. Nothing is averaged twice."""
    if name not in done:
        scattering = bsdf.channels[name]
        if isinstance(scattering, Weighted):
            done[name] = _mean(bsdf, scattering, done, basis, faces)
        else:
            done[name] = average(scattering, basis, faces, symmetry=bsdf.symmetry)
    return done[name]


def _mean(
    bsdf: Bsdf, weighted: Weighted, done: dict[str, PatchMatrices], basis: KlemsBasis, faces: Side
) -> PatchMatrices:
    names = {id(scattering): name for name, scattering in bsdf.channels.items()}
    parts = [(w, _averaged(bsdf, names[id(s)], done, basis, faces)) for w, s in weighted.parts]
    keys = [key for key in parts[0][1].matrices if all(key in p.matrices for _, p in parts)]
    return PatchMatrices(
        {key: np.sum([w * p.matrices[key] for w, p in parts], axis=0) for key in keys},
        {key: np.sum([w * p.error[key] for w, p in parts], axis=0) for key in keys},
    )


def _cells(bsdf: Bsdf, name: str, key: Key, basis: KlemsBasis, faces: Side) -> NDArray[np.uint8]:
    """Origin of every cell: what most of a few pairs of directions within it have, of equals the worse; MEASURED where
    most have it for a measured incident direction within the patch (of an isotropic sample: within its ring)."""
    component = Component(bsdf.channels[name], *key, faces)
    isotropic = bsdf.symmetry == "isotropic"
    low, high, start, width = np.radians(basis.bounds_deg).T
    polar, azimuth = 0.5 * (low + high), start + 0.5 * width
    sides = np.array([-_PROBE, _PROBE])
    polar_4 = polar[:, None] + (high - low)[:, None] * np.repeat(sides, 2)
    azimuth_4 = azimuth[:, None] + width[:, None] * np.tile(sides, 2)
    outgoing = component.outgoing(polar_4.ravel(), azimuth_4.ravel())
    if isotropic:
        polar_i, azimuth_i = polar[:, None] + (high - low)[:, None] * sides, np.repeat(azimuth[:, None], 2, axis=1)
    else:
        polar_i, azimuth_i = polar_4, azimuth_4
    found = _commonest(component, polar_i, azimuth_i, outgoing)
    for theta, phi in _measured_places(bsdf, component):
        column = int(basis.patch_of(np.degrees(theta), np.degrees(phi)))
        columns, turned = np.array([column]), np.array([phi])
        if isotropic:
            ring = int(basis.ring_of(np.degrees(theta)))
            columns = np.arange(basis.ring_start[ring], basis.ring_start[ring + 1])
            turned = azimuth[columns]
        at = _commonest(component, np.full((len(columns), 1), theta), turned[:, None], outgoing)
        found[:, columns] = np.where(at == Origin.MEASURED, at, found[:, columns])
    return found


def _commonest(component: Component, polar: FloatArray, azimuth: FloatArray, outgoing: FloatArray) -> NDArray[np.uint8]:
    """Commonest origin (patches, columns) over incident directions (columns, n) and four outgoing ones of a patch."""
    columns, per_column = polar.shape
    incident = component.incident(polar.ravel(), azimuth.ravel())
    which = np.repeat(np.arange(len(incident)), len(outgoing))
    origin = component.scattering.origin(incident, np.tile(outgoing, (len(incident), 1)), which)
    votes = origin.reshape(columns, per_column, -1, 4)
    counts = np.stack([np.count_nonzero(votes == kind, axis=(1, 3)) for kind in reversed(Origin)])
    return np.asarray((len(Origin) - 1 - np.argmax(counts, axis=0)).T, dtype=np.uint8)


def _measured_places(bsdf: Bsdf, component: Component) -> list[tuple[float, float]]:
    """Polar angle and column azimuth [rad] of the incident directions that were measured on the component's side."""
    angles = sorted({(m.incident_theta_deg, m.incident_phi_deg) for m in bsdf.measured})
    places = []
    for theta, phi in np.radians(angles).reshape(-1, 2).tolist():
        unit = np.array([[np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)]])
        polar, azimuth = component.place_of_incident(unit)
        if polar[0] < np.pi / 2:
            places.append((float(polar[0]), float(azimuth[0])))
    return places


def _check(block: MatrixSet, bsdf: Bsdf, name: str, band: Band, made: KlemsMatrices, *, rescale: bool) -> None:
    measured = [m for m in bsdf.measured if m.channel == name]
    for side in SIDES:
        if any((process, side) in block.cells for process in PROCESSES):
            component = Component(bsdf.channels[name], "Reflection", side, made.front_faces)
            klems_energy.check_side(
                block,
                made.basis,
                band,
                component,
                measured,
                made.findings,
                isotropic=bsdf.symmetry == "isotropic",
                rescale=rescale,
            )


def _precision(band: Band, averaged: PatchMatrices, block: MatrixSet, basis: KlemsBasis) -> list[str]:
    """What adaptive cubature left, where it is more than was asked for."""
    lines = []
    for key, error in averaged.error.items():
        total = basis.projected_solid_angle_sr @ block.matrices[key]
        relative = np.divide(error, total, out=np.zeros_like(error), where=total > 0.0)
        column = int(np.argmax(relative))
        if relative[column] > TOLERANCE:
            lines.append(
                f"{band} {key[0]} {key[1]}: column sums are uncertain by up to {relative[column]:.1e} of themselves "
                f"from the cubature (incident patch {column + 1})."
            )
    return lines


def _by_band(bsdf: Bsdf, made: KlemsMatrices) -> dict[str, Scattering]:
    """Channels as a reader of the file will call them (scattering.channel_named)."""
    found: dict[str, Scattering] = {
        band if band.startswith("CIE") else band.lower(): bsdf.channels[name] for band, name in made.channel_of.items()
    }
    if made.copied is not None:
        found[made.copied[1].lower()] = found[made.copied[0].lower()]
    return found


def _from_file(bsdf: Bsdf) -> bool:
    """Whether it came from matrices or a tree: these hold all directions, so that no symmetry fills anything in."""
    return "imported" in bsdf.provenance and "model" not in bsdf.provenance


def _source(bsdf: Bsdf) -> str:
    model: Any = bsdf.provenance.get("model")
    if isinstance(model, dict):
        return f"a model ({model.get('family', 'unnamed')}) of measured distributions, averaged over both patches"
    imported: Any = bsdf.provenance.get("imported")
    if isinstance(imported, dict):
        return f"{imported.get('file', 'a file')} ({imported.get('format', 'unnamed format')}), by gonio convert"
    return "a scattering function, averaged over both patches"
