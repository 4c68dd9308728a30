"""splitter_view.py: how the detector sees the sample in the beam splitter of the retro rig (paper [0], section 2.3)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Lab frame: the splitter stands on edge in the centre of the arm's turns, at 45 degrees, and exchanges X and Z.
SAMPLE_LAB = np.array([1.0, 0.0, 0.0])  # where the ideal retro direction is seen: the lab's (90, 0)
REFERENCE_LAB = np.array([-1.0, 0.0, 0.0])  # where the reference beam arrives: (90, 180)


@dataclass(frozen=True)
class SplitterView:
    """For each of n detector directions: `outgoing` (n, 3), unit vectors in the lab frame from the sample towards the
    detector's mirror image; `distance_mm` (n,) of that way; `dsf_factor` (n,): what r^2 E / P_i is to be multiplied
    by to be the sample's DSF; `slant` (n,): cosine of the light's angle against the detector's normal."""

    outgoing: FloatArray
    distance_mm: FloatArray
    dsf_factor: FloatArray
    slant: FloatArray


def lab_from_sample(incident_theta_deg: float, incident_phi_deg: float) -> FloatArray:
    """Rotation (3, 3) that takes sample-frame vectors to the lab where the sample is turned to this incident direction:
    R_Y(-theta_i) R_z(-phi_i) (CONVENTIONS.md)."""
    theta, phi = np.radians(incident_theta_deg), np.radians(incident_phi_deg)
    ct, st, cp, sp = np.cos(theta), np.sin(theta), np.cos(phi), np.sin(phi)
    return np.array([[ct * cp, ct * sp, -st], [-sp, cp, 0.0], [st * cp, st * sp, ct]])


def seen_in_splitter(detector_lab: FloatArray, arm_radius_mm: float, sample_distance_mm: float) -> SplitterView:
    """The view from detector directions (n, 3), unit, lab frame, `arm_radius_mm` from the centre; the sample's front is
    `sample_distance_mm` behind the centre.

    Exact: the way from the sample to the detector's image is r m + d z, with m the mirrored direction. Paper [0] eq. 2,
    sin(theta_rs) = (r / r_r) sin(theta_s), takes r_r = r + d for all directions, and says nothing of the irradiance,
    which falls with the square of the longer way. The splitter mirrors, so the sides of a lobe are exchanged: a
    rotation from (90, 0) to (0, 0), as the paper has it, would leave them.
    """
    image = detector_lab[:, [2, 1, 0]]
    way = arm_radius_mm * image + np.array([0.0, 0.0, sample_distance_mm])
    distance_mm = np.linalg.norm(way, axis=1)
    outgoing = way / distance_mm[:, None]
    slant = np.einsum("ij,ij->i", outgoing, image)
    return SplitterView(outgoing, distance_mm, (distance_mm / arm_radius_mm) ** 2 / slant, slant)


def seen_from_sample(outgoing_lab: FloatArray, arm_radius_mm: float, sample_distance_mm: float) -> FloatArray:
    """Detector directions (n, 3) at which the outgoing directions (n, 3), lab frame, are seen: the inverse."""
    along = sample_distance_mm * outgoing_lab[:, 2]
    way = along + np.sqrt(along**2 + arm_radius_mm**2 - sample_distance_mm**2)
    place = way[:, None] * outgoing_lab - np.array([0.0, 0.0, sample_distance_mm])
    return np.asarray((place / np.linalg.norm(place, axis=1)[:, None])[:, [2, 1, 0]])
