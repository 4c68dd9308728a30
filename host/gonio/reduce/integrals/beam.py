"""beam.py: the free beam's power as the detector sees it, P_i = sum E_j Omega_j over the reference spiral."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.geometry.cells import disc_solid_angles_sr, spiral_pitch_deg
from gonio.geometry.kinematics import SOURCE_LAB

FloatArray = NDArray[np.float64]

# P_i of the demo's beam, 9.5 turns across its full width at half maximum, reads 0.03 % high; that grows with the square
# of the pitch: 0.04 % at eight turns, 0.6 % at two.
LEAST_TURNS = 8.0
_OFF_AT_LEAST = 0.0004


@dataclass(frozen=True)
class Beam:
    """Angles about the straight-through direction: polar angle, and azimuth from the lab's +X towards its +Y."""

    polar_deg: FloatArray
    azimuth_deg: FloatArray
    solid_angle_sr: FloatArray
    p_i: float  # signal * sr
    p_i_u_rel: float
    centroid_x_deg: float  # of the beam's light, off straight through
    centroid_y_deg: float
    turns: float  # of the spiral across the beam's full width at half maximum

    def notes(self) -> list[str]:
        """What the user should know about P_i."""
        if self.turns >= LEAST_TURNS:
            return []
        off = _OFF_AT_LEAST * (LEAST_TURNS / self.turns) ** 2
        return [
            f"the reference spiral crosses the beam in {self.turns:.1f} turns per full width at half maximum, P_i may "
            f"be off by {off:.2%}: choose [reference] pitch_deg for {LEAST_TURNS:g} turns or more"
        ]


def measure_beam(
    detector_lab: FloatArray, normalised_signal: FloatArray, variance: FloatArray, used: NDArray[np.bool_]
) -> Beam:
    """P_i from the reference spiral in the order it was flown: detector directions (n, 3), lab frame; signal over lamp
    monitor (n,) and its variance; `used` (n,) leaves out masked samples.

    Nothing is subtracted: the dark is gone already, and a skirt of the beam belongs to it. What the outermost tenth of
    the disc still reads, taken over the whole disc, is part of the stated uncertainty beside the noise.
    """
    omega = np.zeros(len(detector_lab))
    omega[used] = disc_solid_angles_sr(detector_lab[used], -SOURCE_LAB)
    signal = np.where(used, normalised_signal, 0.0)
    x_deg, y_deg = np.degrees(detector_lab[:, 0]), np.degrees(detector_lab[:, 1])
    polar_deg = np.degrees(np.arctan2(np.hypot(detector_lab[:, 0], detector_lab[:, 1]), -detector_lab[:, 2]))
    p_i = float(signal @ omega)
    edge = used & (polar_deg > 0.9 * polar_deg[used].max())
    skirt = float(signal[edge] @ omega[edge] / omega[edge].sum() * omega.sum())
    half = signal > 0.5 * signal.max()
    width_deg = float(np.degrees(2.0 * np.sqrt(omega[half].sum() / np.pi)))
    noise = float(np.sqrt(np.sum(np.where(used, variance, 0.0) * omega**2)))
    return Beam(
        polar_deg=polar_deg,
        azimuth_deg=np.mod(np.degrees(np.arctan2(y_deg, x_deg)), 360.0),
        solid_angle_sr=omega,
        p_i=p_i,
        p_i_u_rel=float(np.hypot(noise, skirt)) / p_i if p_i > 0.0 else np.inf,
        centroid_x_deg=float((signal * x_deg) @ omega) / p_i if p_i > 0.0 else 0.0,
        centroid_y_deg=float((signal * y_deg) @ omega) / p_i if p_i > 0.0 else 0.0,
        turns=width_deg / spiral_pitch_deg(detector_lab[used], -SOURCE_LAB),
    )
