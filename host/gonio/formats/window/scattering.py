"""scattering.py: Klems matrices of a WINDOW file as a BSDF in any direction, constant in each pair of patches."""

import hashlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Side
from gonio.dataset.scattering import Bsdf, Features, FloatArray, IndexArray, Origin
from gonio.formats import validity
from gonio.formats.findings import Findings
from gonio.formats.validity import Validity
from gonio.formats.window.klems import LightSide, process_of
from gonio.formats.window.matrices import Band
from gonio.formats.window.read import READ_BANDS, WindowBsdf, read
from gonio.units.errors import UsageError

_EXTERIOR_TO_RADIANCE = np.array([-1.0, 1.0, -1.0])  # the sample is turned about y


@dataclass(frozen=True)
class KlemsScattering:
    """One band of a WINDOW file, in the frame of a sample whose front faces `front_faces` (Scattering).

    `rests`: where the file says that it rests on measurements; None: it does not say.
    """

    window: WindowBsdf
    band: Band
    front_faces: Side
    rests: Validity | None = None

    def __post_init__(self) -> None:
        if self.front_faces == "undeclared":
            raise UsageError(
                "it is not declared which way the sample's front faces: give --front exterior or --front interior"
            )

    @property
    def channel(self) -> str:
        """Name of the band as a channel."""
        return channel_named(self.band)

    def bsdf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> FloatArray:
        """BSDF [1/sr] (m,) of the patches, also at grazing; NaN where the file has no matrix. Arguments as in
        Scattering."""
        basis = self.window.basis
        rows = np.zeros(len(outgoing), dtype=np.int64) if which is None else which
        turn = _EXTERIOR_TO_RADIANCE if self.front_faces == "exterior" else np.ones(3)
        towards_source, leaving = incident * turn, outgoing * turn
        column = basis.patch_of(_polar_deg(towards_source), _azimuth_deg(-towards_source))
        row = basis.patch_of(_polar_deg(leaving), _azimuth_deg(leaving))
        # The horizon belongs to the sample's front, whichever way that faces.
        front_inside = self.front_faces == "interior"
        from_inside = (incident[:, 2] >= 0.0) == front_inside
        to_inside = (outgoing[:, 2] >= 0.0) == front_inside
        result = np.full(len(outgoing), np.nan)
        for side, lit in (("Front", ~from_inside), ("Back", from_inside)):
            for interior in (True, False):
                matrix = self._matrix(side, interior=interior)  # type: ignore[arg-type]
                if matrix is not None and lit.any():
                    here = lit[rows] & (to_inside == interior)
                    result[here] = matrix[row[here], column[rows[here]]]
        return result

    def dsf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> FloatArray:
        """See Scattering; the patches' BSDF times |cos theta_s|."""
        return np.asarray(self.bsdf_per_sr(incident, outgoing, which) * np.abs(outgoing[:, 2]))

    def origin(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> NDArray[np.uint8]:
        """See Scattering. An average over patches is never called measured: INTERPOLATED, or what the file says."""
        rows = np.zeros(len(outgoing), dtype=np.int64) if which is None else which
        there = np.zeros(len(outgoing), dtype=np.bool_)
        for lit in (True, False):
            for leaves in (True, False):
                if self.covers(incident_front=lit, outgoing_front=leaves):
                    there |= ((incident[:, 2] >= 0.0)[rows] == lit) & ((outgoing[:, 2] >= 0.0) == leaves)
        found = np.full(len(outgoing), Origin.INTERPOLATED, dtype=np.uint8)
        if self.rests is not None:
            found = self.rests.origin(self.channel, incident, outgoing, which)
        return np.where(there, found, np.uint8(Origin.ABSENT))

    def covers(self, *, incident_front: bool, outgoing_front: bool) -> bool:
        """See Scattering. A matrix of zeros of which the file says that it was not measured is none."""
        front_inside = self.front_faces == "interior"
        side: LightSide = "Back" if incident_front == front_inside else "Front"
        return self._matrix(side, interior=outgoing_front == front_inside) is not None

    def features(self, incident: FloatArray) -> Features:
        """See Scattering: patches are wide."""
        del incident
        return Features.none()

    def _matrix(self, side: LightSide, *, interior: bool) -> FloatArray | None:
        matrix = self.window.matrices.get((self.band, process_of(side, interior), side))
        if matrix is None or self.rests is None or matrix.any():
            return matrix
        front_inside = self.front_faces == "interior"
        lit, leaves = (side == "Back") == front_inside, interior == front_inside
        return matrix if self.rests.covers(self.channel, incident_front=lit, outgoing_front=leaves) else None


def channel_named(band: Band) -> str:
    """Channel of a band: visible, solar; CIE-X and CIE-Z as they are."""
    return band if band.startswith("CIE") else band.lower()


def window_bsdf(path: Path, front: Side | None = None) -> tuple[Bsdf, Findings]:
    """A WINDOW file with a channel per band (`channel_named`), and what is odd about the file.

    `front`: side that the sample's front faces; goes before what a file of ours says in its comments; where nobody
    says it, the front faces the exterior, as the word is used by WINDOW. Raises UsageError for a file that cannot be
    read.
    """
    return bsdf_of(read(path), front)


def bsdf_of(window: WindowBsdf, front: Side | None = None) -> tuple[Bsdf, Findings]:
    """As `window_bsdf`, of a file that was read."""
    comments = window.text.get("Comments", "")
    faces: Side = front or validity.front_faces_of(comments) or "exterior"
    said = validity.parse(comments)
    rests = None if said is None else said.seen_with(faces)
    if said is None and validity.MARK in comments:
        window.findings.add("warning", "validity", "Comments", "the line of the validity range is damaged; ignored")
    bands = [band for band in READ_BANDS if any(key[0] == band for key in window.matrices)]
    bsdf = Bsdf(
        {channel_named(band): KlemsScattering(window, band, faces, rests) for band in bands},
        sample_name=window.text.get("Name", ""),
        manufacturer=window.text.get("Manufacturer", ""),
        front_faces=faces,
        symmetry="undeclared" if said is None else said.symmetry,
        thickness_mm=window.thickness_mm,
        validity=_sentences(window, rests),
        provenance={
            "imported": {
                "file": window.path.name,
                "sha256": hashlib.sha256(window.path.read_bytes()).hexdigest(),
                "format": "WINDOW XML, Klems matrices",
                "basis": window.basis.name,
                "values": "averages over pairs of patches",
                "front": _who_says(front, comments, faces),
                "comments": comments,
                "findings": window.findings.as_json()["findings"],
            }
        },
    )
    return bsdf, window.findings


def _sentences(window: WindowBsdf, rests: Validity | None) -> tuple[str, ...]:
    averages = f"Values are averages over pairs of patches ({window.basis.name}, {window.basis.size} patches)."
    return (averages, *(() if rests is None else rests.sentences()))


def _who_says(front: Side | None, comments: str, faces: Side) -> str:
    if front is not None:
        return f"faces the {faces}, as the user says"
    if validity.front_faces_of(comments) is not None:
        return f"faces the {faces}, as the file says"
    return f"taken to face the {faces}, where WINDOW has its front"


def _polar_deg(unit: FloatArray) -> FloatArray:
    return np.asarray(np.degrees(np.arctan2(np.hypot(unit[:, 0], unit[:, 1]), np.abs(unit[:, 2]))))


def _azimuth_deg(unit: FloatArray) -> FloatArray:
    return np.asarray(np.degrees(np.arctan2(unit[:, 1], unit[:, 0])))
