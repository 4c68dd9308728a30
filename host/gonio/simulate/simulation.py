"""simulation.py: a scenario to a dataset like that of a measurement: what `gonio simulate` does."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from gonio.dataset.bsdf import Dataset
from gonio.dataset.nexus import read_dataset
from gonio.simulate import directions
from gonio.simulate.assembly import FreeBeam, distribution_of, far_apart, free_beam
from gonio.simulate.directions import BeamExtent
from gonio.simulate.progress import PhotonProgress
from gonio.simulate.readings import BALANCE, FloatArray, Job, Reading, added
from gonio.simulate.request import Request, Simulated
from gonio.simulate.setting import Setting, open_setting
from gonio.simulate.targets import Target, targets_like, targets_on_grid
from gonio.units.errors import UsageError
from gonio.units.version import gonio_version

CORRECTIONS = (
    "readings: power in the detector's aperture over its solid angle and the emitted power",
    "P_i: sum E Omega over a spiral through the free beam, simulated without sample",
    "variance: of independent photons; that of P_i is apart",
)
_PROBE_PHOTONS = 1 << 16
_BEAM_PHOTONS = 1 << 20  # P_i to about 0.1 %
_BEAM_INCIDENT = (0.0, 0.0)  # then the sample frame is the lab frame


@dataclass(frozen=True)
class _BeamPoints:
    """Where the free beam is read: unit vectors (n, 3), lab frame, and which of them."""

    unit: FloatArray
    used: Any  # (n,) bool


def simulate(request: Request, progress: PhotonProgress) -> Simulated:
    """Simulate all incident directions and bands of a request. Raises UsageError for wrong input."""
    measured = None if request.like is None else read_dataset(request.like)
    with open_setting(request, progress) as setting:
        names = [name for name, _ in setting.bands]
        progress.begin("free beam")
        extent = None
        if measured is None:
            extent = _extent(setting, names[0])
            targets = targets_on_grid(names, setting.incidents, setting.step_deg, extent)
        else:
            targets = targets_like(measured, names, str(request.like))
            if measured.beam is None:
                extent = _extent(setting, names[0])
        bands = list(dict.fromkeys(target.band for target in targets))
        beams = _free_beams(setting, bands, _beam_points(measured, extent))
        progress.begin("sample")
        readings = setting.read([target.job(*setting.estimator) for target in targets])
    distributions = [distribution_of(t, r, beams[t.band]) for t, r in zip(targets, readings, strict=True)]
    described = [_described(t, r) for t, r in zip(targets, readings, strict=True)]
    provenance = {
        "simulation": setting.provenance
        | {"distributions": described, "like": None if request.like is None else _like(request)},
        "instrument_text": setting.provenance["instrument_text"],
        "corrections": list(CORRECTIONS),
        "versions": {"gonio": gonio_version(), "numpy": np.__version__, "scipy": scipy.__version__},
    }
    del provenance["simulation"]["instrument_text"]
    remarks = _remarks(setting, targets, readings, beams) + far_apart(distributions)
    provenance["notes"] = remarks
    dataset = Dataset(
        distributions=distributions,
        sample_name=f"simulated: {request.scenario.stem}",
        provenance=provenance,
        beam=beams[bands[0]].distribution,
        polarisation=setting.polarisation,
    )
    if measured is not None:
        dataset.front_faces = measured.front_faces
        dataset.symmetry = measured.symmetry
        dataset.thickness_mm = measured.thickness_mm
    return Simulated(dataset, _balance(readings), remarks, described)


def _extent(setting: Setting, band: str) -> BeamExtent:
    probe = directions.beam_probe()
    reading = setting.read([Job(band, _BEAM_INCIDENT, False, probe)], _PROBE_PHOTONS)[0]
    extent = directions.beam_extent(reading.signal_per_sr)
    if extent is None:
        raise UsageError(f'P_i is 0 in the band "{band}": no light arrives straight through; check [beam] and [rig]')
    return extent


def _beam_points(measured: Dataset | None, extent: BeamExtent | None) -> _BeamPoints:
    """The measured beam's points, or a spiral over the beam's extent."""
    if extent is not None:
        unit = directions.beam_spiral(extent)
        return _BeamPoints(unit, np.ones(len(unit), dtype=bool))
    assert measured is not None
    assert measured.beam is not None
    unit = directions.about_beam(measured.beam.theta_deg, measured.beam.phi_deg)
    return _BeamPoints(unit, measured.beam.measured)


def _free_beams(setting: Setting, bands: Sequence[str], points: _BeamPoints) -> dict[str, FreeBeam]:
    looked_at = np.ascontiguousarray(points.unit[points.used])
    readings = setting.read([Job(band, _BEAM_INCIDENT, False, looked_at) for band in bands], _BEAM_PHOTONS)
    wavelengths = dict(setting.bands)
    return {
        band: free_beam(band, wavelengths[band], points.unit, points.used, reading)
        for band, reading in zip(bands, readings, strict=True)
    }


def _described(target: Target, reading: Reading) -> dict[str, Any]:
    return {
        "incident_deg": list(target.incident_deg),
        "channel": target.channel,
        "band": target.band,
        "points": len(target.unit),
        "median_relative_error": reading.median_error,
        "balance": reading.balance,
    }


def _like(request: Request) -> dict[str, str]:
    assert request.like is not None
    return {"file": request.like.name, "sha256": hashlib.sha256(request.like.read_bytes()).hexdigest()}


def _balance(readings: Sequence[Reading]) -> dict[str, int]:
    total = dict.fromkeys(BALANCE, 0)
    for reading in readings:
        if reading.balance:
            total = added(total, reading.balance)
    return total if total["photons"] else {}


def _remarks(
    setting: Setting, targets: Sequence[Target], readings: Sequence[Reading], beams: dict[str, FreeBeam]
) -> list[str]:
    """What the user should know, one sentence each."""
    renamed = dict.fromkeys((t.channel, t.band) for t in targets if t.channel != t.band)
    remarks = [f'channel "{channel}" is simulated in the band "{band}"' for channel, band in renamed]
    for band, beam in beams.items():
        remarks += [f"{band}: {note}" for note in beam.beam.notes()]
    goal = setting.relative_error
    short = [r.median_error for r in readings if r.median_error > goal > 0.0]
    if short:
        remarks.append(
            f"{len(short)} of {len(readings)} distributions do not reach the error of {goal:.2%} (the worst has "
            f"{max(short):.2%}): raise most_photons"
        )
    lost = _balance(readings).get("lost", 0)
    if lost:
        share = lost / _balance(readings)["emitted"]
        remarks.append(f"{share:.2g} of the light was lost after most_interactions: raise it")
    return remarks
