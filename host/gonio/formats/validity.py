"""validity.py: where a model rests on measurements, as one line of text that travels in the comments of files.

The line is `gonio-validity: ` and a JSON object on one line, in the SAMPLE frame of CONVENTIONS.md:

    {"front_faces": "exterior", "symmetry": "isotropic", "ranges": [
        {"channels": ["visible"], "from": "front", "to": "back", "theta_i": [0, 70], "phi_i": [0, 360],
         "theta_s": [0, 89]}, ...]}

theta_i and theta_s are degrees from the normal of the side that light arrives at and leaves from, phi_i is the incident
azimuth, perhaps beyond 360 (a range through 0). A pair of sides without a range was not measured. Writers call
`line(bsdf)`; readers call `parse`, and ask the result for the origin of values.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Side, Symmetry
from gonio.dataset.scattering import Bsdf, FloatArray, IndexArray, Origin, Scattering
from gonio.geometry.directions import unit_from_angles_deg

MARK = "gonio-validity:"
FRONT_SENTENCE = "Front, where light arrives from the exterior, is the sample's "  # what follows is "front" or "back"

# Polar angles that are looked at; the last one stands for the horizon, which itself is on no side.
_HORIZON_DEG = 89.99
_POLAR_DEG = np.append(np.arange(0.0, 90.0, 0.5), _HORIZON_DEG)
_AZIMUTHS_DEG = np.arange(0.0, 360.0, 15.0)  # of the incident direction, where the sample is not isotropic
_PROBES_DEG = ((5.0, 0.0), (25.0, 45.0), (25.0, 225.0), (50.0, 135.0), (50.0, 315.0), (70.0, 90.0))  # outgoing
_SLACK_DEG = 0.01  # a direction so little outside counts as inside
_MOST_RANGES = 4096


@dataclass(frozen=True)
class Range:
    """Incident and outgoing directions of one pair of sides between which values rest on measurements."""

    channels: tuple[str, ...]
    incident_front: bool
    outgoing_front: bool
    theta_i_deg: tuple[float, float]
    phi_i_deg: tuple[float, float]
    theta_s_deg: tuple[float, float]

    def as_json(self) -> dict[str, Any]:
        """As in the line."""
        return {
            "channels": list(self.channels),
            "from": _side(self.incident_front),
            "to": _side(self.outgoing_front),
            "theta_i": [round(v, 2) for v in self.theta_i_deg],
            "phi_i": [round(v, 2) for v in self.phi_i_deg],
            "theta_s": [round(v, 2) for v in self.theta_s_deg],
        }

    def sentence(self) -> str:
        """For people."""
        azimuth = "" if self.phi_i_deg[1] - self.phi_i_deg[0] >= 360.0 else f", phi_i {_span(self.phi_i_deg)}"
        return (
            f"{', '.join(self.channels)}, {_side(self.incident_front)} to {_side(self.outgoing_front)}: measured for "
            f"theta_i {_span(self.theta_i_deg)}{azimuth} and theta_s {_span(self.theta_s_deg)} degrees from the normal."
        )


@dataclass(frozen=True)
class Validity:
    """All ranges of a file, and what is declared of the sample."""

    front_faces: Side
    symmetry: Symmetry
    ranges: tuple[Range, ...]

    def line(self) -> str:
        """The machine-readable line."""
        content = {
            "front_faces": self.front_faces,
            "symmetry": self.symmetry,
            "ranges": [r.as_json() for r in self.ranges],
        }
        return f"{MARK} {json.dumps(content, allow_nan=False)}"

    def sentences(self) -> tuple[str, ...]:
        """One sentence per range."""
        return tuple(r.sentence() for r in self.ranges)

    def covers(self, channel: str, *, incident_front: bool, outgoing_front: bool) -> bool:
        """Whether anything was measured for this pair of sides."""
        sides = (incident_front, outgoing_front)
        return any(channel in r.channels and (r.incident_front, r.outgoing_front) == sides for r in self.ranges)

    def origin(
        self, channel: str, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None
    ) -> NDArray[np.uint8]:
        """Origin (m,) of values of a channel, arguments as in Scattering: INTERPOLATED within a range, for a file holds
        averages; else EXTRAPOLATED; ABSENT where no range is about that pair of sides."""
        rows = np.zeros(len(outgoing), dtype=np.int64) if which is None else which
        polar_i = _polar_deg(incident)
        azimuth_i = np.degrees(np.arctan2(incident[:, 1], incident[:, 0]))
        polar_s = _polar_deg(outgoing)
        lit_front, leaves_front = incident[:, 2] >= 0.0, outgoing[:, 2] >= 0.0
        result = np.full(len(outgoing), Origin.ABSENT, dtype=np.uint8)
        for r in self._named(channel):
            pair = (lit_front == r.incident_front)[rows] & (leaves_front == r.outgoing_front)
            beyond = (azimuth_i - r.phi_i_deg[0] + _SLACK_DEG) % 360.0 > r.phi_i_deg[1] - r.phi_i_deg[
                0
            ] + 2 * _SLACK_DEG
            turned_in = ~beyond | (polar_i < _SLACK_DEG)
            inside = (turned_in & _within(polar_i, r.theta_i_deg))[rows] & _within(polar_s, r.theta_s_deg)
            result[pair & inside] = Origin.INTERPOLATED
            result[pair & ~inside & (result == Origin.ABSENT)] = Origin.EXTRAPOLATED
        return result

    def seen_with(self, front_faces: Side) -> "Validity":
        """The same in the frame of a sample whose front is said to face another way: turned about y."""
        if front_faces == self.front_faces:
            return self
        turned = [
            replace(
                r,
                incident_front=not r.incident_front,
                outgoing_front=not r.outgoing_front,
                phi_i_deg=_mirrored(r.phi_i_deg),
            )
            for r in self.ranges
        ]
        return Validity(front_faces, self.symmetry, tuple(turned))

    def _named(self, channel: str) -> list[Range]:
        """Ranges of a channel; all of them for one that no range names: a band may hold a channel of another name."""
        own = [r for r in self.ranges if channel in r.channels]
        return own or list(self.ranges)


def line(bsdf: Bsdf) -> str:
    """The line for a file's comments, from what the channels say of the origin of their values."""
    return validity_of(bsdf).line()


def validity_of(bsdf: Bsdf) -> Validity:
    """Ranges of all channels, by asking for the origin of values on a grid of directions: incident polar angles every
    half degree, azimuths every 15 degrees unless the sample is declared isotropic."""
    ranges: dict[tuple[Any, ...], list[str]] = {}
    for name, scattering in bsdf.channels.items():
        for incident_front in (True, False):
            for outgoing_front in (True, False):
                if scattering.covers(incident_front=incident_front, outgoing_front=outgoing_front):
                    for spans in _spans(scattering, incident_front, outgoing_front, bsdf.symmetry == "isotropic"):
                        ranges.setdefault((incident_front, outgoing_front, *spans), []).append(name)
    found = tuple(
        Range(tuple(names), lit, leaves, theta_i, phi_i, theta_s)
        for (lit, leaves, theta_i, phi_i, theta_s), names in ranges.items()
    )
    return Validity(bsdf.front_faces, bsdf.symmetry, found)


def parse(comments: str) -> Validity | None:
    """The validity in a text that holds the line, whatever stands before and behind it; None where there is none or it
    is damaged."""
    start = comments.find(MARK)
    if start < 0:
        return None
    try:
        content, _ = json.JSONDecoder().raw_decode(comments[start + len(MARK) :].lstrip())
        if len(content["ranges"]) > _MOST_RANGES:
            return None
        faces: Side = _one_of(content["front_faces"], get_args(Side))
        return Validity(
            _by_sentence(comments) or faces,  # the sentence tells what the file was written with
            _one_of(content["symmetry"], get_args(Symmetry)),
            tuple(_range(entry) for entry in content["ranges"]),
        )
    except (ValueError, KeyError, TypeError, RecursionError, OverflowError):
        return None


def front_faces_of(comments: str) -> Side | None:
    """Which way the sample's front faces, where the comments of a file of ours say so."""
    found = parse(comments)
    faces = _by_sentence(comments) if found is None else found.front_faces
    return None if faces == "undeclared" else faces


def _by_sentence(comments: str) -> Side | None:
    _, mark, rest = comments.partition(FRONT_SENTENCE)
    if mark and rest.startswith("front"):
        return "exterior"
    return "interior" if mark and rest.startswith("back") else None


def _spans(
    scattering: Scattering, incident_front: bool, outgoing_front: bool, isotropic: bool
) -> list[tuple[tuple[float, float], tuple[float, float], tuple[float, float]]]:
    """theta_i, phi_i and theta_s [deg] of each group of neighbouring incident azimuths with the same theta_i."""
    polar = _POLAR_DEG
    azimuths = _AZIMUTHS_DEG[:1] if isotropic else _AZIMUTHS_DEG
    measured = np.zeros((len(azimuths), len(polar)), dtype=np.bool_)
    probes = _directions(*np.array(_PROBES_DEG).T, front=outgoing_front)
    for row, azimuth in enumerate(azimuths):
        incident = _directions(polar, np.full(len(polar), azimuth), front=incident_front)
        which = np.repeat(np.arange(len(polar)), len(probes))
        origin = scattering.origin(incident, np.tile(probes, (len(polar), 1)), which)
        measured[row] = np.any(_rests(origin).reshape(len(polar), -1), axis=1)
    lit = [_ends(polar[row]) for row in measured]
    spans = []
    for theta_i, first, last in _arcs(lit):
        phi_i = (0.0, 360.0)
        if last - first + 1 < len(azimuths):
            phi_i = (15.0 * first, 15.0 * last)
        middle = 0.5 * (theta_i[0] + theta_i[1])
        azimuth = float(azimuths[(first + last) // 2 % len(azimuths)])
        spans.append((theta_i, phi_i, _outgoing_span(scattering, middle, azimuth, incident_front, outgoing_front)))
    return spans


def _arcs(lit: Sequence[tuple[float, float] | None]) -> list[tuple[tuple[float, float], int, int]]:
    """Runs of equal entries on the circle: entry, first and last index; the last may run beyond the end."""
    count = len(lit)
    start = next((i for i in range(count) if lit[i] != lit[i - 1]), 0)
    turned = [(start + i, lit[(start + i) % count]) for i in range(count)]
    runs = []
    for entry, group in groupby(turned, key=lambda pair: pair[1]):
        indices = [index for index, _ in group]
        if entry is not None:
            runs.append((entry, indices[0], indices[-1]))
    return runs


def _outgoing_span(
    scattering: Scattering, theta_i_deg: float, phi_i_deg: float, incident_front: bool, outgoing_front: bool
) -> tuple[float, float]:
    incident = _directions(np.array([theta_i_deg]), np.array([phi_i_deg]), front=incident_front)
    polar = _POLAR_DEG
    azimuth = np.arange(0.0, 360.0, 30.0) + 7.5
    theta, phi = (column.ravel() for column in np.meshgrid(polar, azimuth, indexing="ij"))
    rests = _rests(scattering.origin(incident, _directions(theta, phi, front=outgoing_front)))
    there = polar[rests.reshape(len(polar), -1).any(axis=1)]
    return _ends(there) or (0.0, 0.0)


def _ends(polar_deg: FloatArray) -> tuple[float, float] | None:
    if not len(polar_deg):
        return None
    return float(polar_deg[0]), 90.0 if polar_deg[-1] == _HORIZON_DEG else float(polar_deg[-1])


def _rests(origin: NDArray[np.uint8]) -> NDArray[np.bool_]:
    return np.asarray((origin == Origin.MEASURED) | (origin == Origin.INTERPOLATED))


def _directions(polar_deg: FloatArray, phi_deg: FloatArray, *, front: bool) -> FloatArray:
    return unit_from_angles_deg(polar_deg if front else 180.0 - polar_deg, phi_deg)


def _polar_deg(unit: FloatArray) -> FloatArray:
    return np.asarray(np.degrees(np.arctan2(np.hypot(unit[:, 0], unit[:, 1]), np.abs(unit[:, 2]))))


def _within(value: FloatArray, span: tuple[float, float]) -> NDArray[np.bool_]:
    return np.asarray((value >= span[0] - _SLACK_DEG) & (value <= span[1] + _SLACK_DEG))


def _range(entry: Any) -> Range:
    channels = entry["channels"]
    if not isinstance(channels, list) or not all(isinstance(name, str) for name in channels):
        raise ValueError("channels are no names")
    return Range(
        tuple(channels),
        _one_of(entry["from"], ("front", "back")) == "front",
        _one_of(entry["to"], ("front", "back")) == "front",
        _pair(entry["theta_i"], 90.0),
        _pair(entry["phi_i"], 720.0),
        _pair(entry["theta_s"], 90.0),
    )


def _pair(values: Any, most: float) -> tuple[float, float]:
    low, high = (float(v) for v in values)
    if not 0.0 <= low <= high <= most:
        raise ValueError("no range of angles")
    return low, high


def _one_of(value: Any, allowed: tuple[str, ...]) -> Any:
    if value not in allowed:
        raise ValueError(f"none of {allowed}")
    return value


def _mirrored(phi_deg: tuple[float, float]) -> tuple[float, float]:
    """Azimuths of a range after the turn, 180 - phi."""
    if phi_deg[1] - phi_deg[0] >= 360.0:
        return phi_deg
    start = (180.0 - phi_deg[1]) % 360.0
    return start, start + phi_deg[1] - phi_deg[0]


def _side(front: bool) -> str:
    return "front" if front else "back"


def _span(span: tuple[float, float]) -> str:
    return f"{span[0]:g}-{span[1]:g}"
