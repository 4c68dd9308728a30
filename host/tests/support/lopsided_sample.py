"""lopsided_sample.py: a sample without symmetry (front/back, left/right, up/down) in closed form, for many formats.

In each pair of hemispheres BSDF = b (1 + o . (x_s, y_s)) (1 + i . (x_i, y_i)) with constants of its own. It is affine
in the direction cosines of either direction, so its average over a Klems patch or a cell of a tensor tree, both
weighted by projected solid angle, is its value at the patch's mean (x, y): exact answers for every format.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Distribution, Side
from gonio.dataset.scattering import Bsdf, Features, FloatArray, IndexArray, Origin
from gonio.formats.window.klems import KlemsBasis, LightSide, Process
from gonio.formats.window.matrices import PROCESSES, SIDES
from gonio.geometry.directions import unit_from_angles_deg


@dataclass(frozen=True)
class Component:
    """BSDF [1/sr] at the mean, and its relative slopes along x and y of the outgoing and the incident direction."""

    bsdf_per_sr: float
    outgoing: tuple[float, float]
    incident: tuple[float, float]

    def bsdf(self, incident_xy: FloatArray, outgoing_xy: FloatArray) -> FloatArray:
        """BSDF [1/sr] (...) of direction cosines (..., 2)."""
        return np.asarray(
            self.bsdf_per_sr
            * (1.0 + outgoing_xy @ np.array(self.outgoing))
            * (1.0 + incident_xy @ np.array(self.incident))
        )


# Light side and leaving side, front or not. Sums stay under 1 from every direction.
COMPONENTS: dict[tuple[bool, bool], Component] = {
    (True, True): Component(0.060, (0.50, -0.20), (0.15, 0.30)),
    (True, False): Component(0.090, (-0.15, 0.45), (0.35, -0.10)),
    (False, True): Component(0.050, (0.25, 0.55), (-0.30, 0.20)),
    (False, False): Component(0.110, (-0.40, -0.35), (-0.05, -0.25)),
}


@dataclass(frozen=True)
class Lopsided:
    """Scattering in closed form; `factor` scales it (a second channel)."""

    factor: float = 1.0

    def dsf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> FloatArray:
        """See Scattering."""
        own = np.broadcast_to(incident[0], outgoing.shape) if which is None else incident[which]
        result = np.zeros(len(outgoing))
        for (lit_front, leaves_front), part in COMPONENTS.items():
            here = ((own[:, 2] >= 0.0) == lit_front) & ((outgoing[:, 2] >= 0.0) == leaves_front)
            result[here] = part.bsdf(own[here, :2], outgoing[here, :2])
        return np.asarray(self.factor * result * np.abs(outgoing[:, 2]))

    def origin(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> NDArray[np.uint8]:
        """See Scattering."""
        del incident, which
        return np.full(len(outgoing), Origin.MEASURED, dtype=np.uint8)

    def covers(self, *, incident_front: bool, outgoing_front: bool) -> bool:
        """See Scattering."""
        del incident_front, outgoing_front
        return True

    def features(self, incident: FloatArray) -> Features:
        """See Scattering."""
        del incident
        return Features.none()

    def integral(self, incident: FloatArray, *, reflection: bool) -> float:
        """rho or tau of one incident unit vector (3,): over the hemisphere the outgoing slopes cancel."""
        lit_front = bool(incident[2] >= 0.0)
        part = COMPONENTS[lit_front, lit_front == reflection]
        return float(self.factor * np.pi * part.bsdf_per_sr * (1.0 + incident[:2] @ np.array(part.incident)))


SOLAR_FACTOR = 0.8


def lopsided_bsdf(front_faces: Side = "interior") -> Bsdf:
    """Channels visible and solar, solar SOLAR_FACTOR times visible."""
    return Bsdf(
        {"visible": Lopsided(), "solar": Lopsided(SOLAR_FACTOR)},
        sample_name="lopsided",
        manufacturer="gonio",
        front_faces=front_faces,
        symmetry="none",
        thickness_mm=2.0,
    )


INCIDENT_DEG: tuple[tuple[float, float], ...] = ((0.0, 0.0), (40.0, 20.0), (65.0, 250.0), (140.0, 100.0), (180.0, 0.0))


def lopsided_dataset(
    incident_deg: Sequence[tuple[float, float]] = INCIDENT_DEG, front_faces: Side = "interior", rings: int = 24
) -> Dataset:
    """The visible channel as measured points on both hemispheres: cells of equal solid angle, values in the middle."""
    z = (np.arange(rings) + 0.5) / rings
    turns = 4 * rings
    azimuth = (np.arange(turns) + 0.5) * 360.0 / turns
    theta = np.degrees(np.arccos(np.concatenate((z, -z))))
    theta_deg, phi_deg = (column.ravel() for column in np.meshgrid(theta, azimuth, indexing="ij"))
    unit = unit_from_angles_deg(theta_deg, phi_deg)
    n = len(unit)
    distributions = []
    for theta_i, phi_i in incident_deg:
        dsf = Lopsided().dsf_per_sr(unit_from_angles_deg(np.array([theta_i]), np.array([phi_i])), unit)
        distributions.append(
            Distribution(
                incident_theta_deg=theta_i,
                incident_phi_deg=phi_i,
                theta_deg=theta_deg,
                phi_deg=phi_deg,
                dsf_per_sr=dsf,
                variance_per_sr2=(1e-3 * dsf) ** 2,
                signal=dsf,
                normalisation=np.ones(n),
                count=np.ones(n, dtype=np.int32),
                flags=np.zeros(n, dtype=np.uint16),
                solid_angle_sr=np.full(n, 2.0 * np.pi / (rings * turns)),
                time_ns=np.zeros(n, dtype=np.int64),
                signal_unit="1/sr",
            )
        )
    return Dataset(distributions, sample_name="lopsided", front_faces=front_faces, symmetry="none", thickness_mm=2.0)


def patch_means(basis: KlemsBasis) -> FloatArray:
    """Mean direction cosines (x, y) of each patch (size, 2), weighted by projected solid angle: exact."""
    lower, upper, start, width = np.radians(basis.bounds_deg).T
    radial = (np.sin(upper) ** 3 - np.sin(lower) ** 3) / 3.0
    across = np.stack((np.sin(start + width) - np.sin(start), np.cos(start) - np.cos(start + width)), axis=1)
    return np.asarray(radial[:, None] * across / basis.projected_solid_angle_sr[:, None])


def exact_matrices(basis: KlemsBasis, front_faces: Side = "interior") -> dict[tuple[Process, LightSide], FloatArray]:
    """Double averages of the visible channel, rows = outgoing patches, in the order and frame of WINDOW XML."""
    means = patch_means(basis)
    x_sign = 1.0 if front_faces == "interior" else -1.0  # Radiance's frame is the sample's, or turned about y
    ours = means * np.array([x_sign, 1.0])
    found: dict[tuple[Process, LightSide], FloatArray] = {}
    for side in SIDES:
        lit_front = (side == "Back") == (front_faces == "interior")
        for process in PROCESSES:
            part = COMPONENTS[lit_front, lit_front == (process == "Reflection")]
            # A column's azimuth is the source's plus 180 degrees.
            found[process, side] = part.bsdf(-ours[None, :, :], ours[:, None, :])
    return found
