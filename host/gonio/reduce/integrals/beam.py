"""beam.py: the free beam's power as the detector sees it, P_i = integral of E over the reference spiral."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.uncertainty import Uncertain
from gonio.geometry.cells import Cells, cells
from gonio.geometry.kinematics import SOURCE_LAB
from gonio.geometry.pitch import path_pitch_rad
from gonio.reduce.coverage import REACH_FACTOR
from gonio.reduce.integrals.peaks import LEAST_TURNS
from gonio.reduce.integrals.quadrature import left_of_peak_u
from gonio.reduce.integrals.results import Results

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# With fewer turns than this across the full width at half maximum P_i may be off by more than 0.1 %: the edge of a beam
# with a flat top falls between the turns.
ENOUGH_TURNS = 8.0
# Every other turn is a spiral of twice the pitch. What the turns miss falls with the third power of the pitch where the
# beam's edge has a continuous slope, and what both halves miss differs by up to twice that.
_HALVES = 2.0 * 2.0**3
_SLACK = 1.1  # over half a turn and a step along it
_LEAST_POINTS = 20


@dataclass(frozen=True)
class Beam:
    """Angles about the straight-through direction: polar angle, and azimuth from the lab's +X towards its +Y."""

    polar_deg: FloatArray
    azimuth_deg: FloatArray
    solid_angle_sr: FloatArray  # over the number of scans, so that a sum over all points is the mean of the scans
    linear_sr: FloatArray  # weights of linear interpolation, likewise
    power: Uncertain  # P_i [signal * sr], 2 V - P1
    voronoi: float  # V alone
    scans: tuple[Uncertain, ...]  # P_i of each reference scan by itself
    centroid_x_deg: float  # of the beam's light, off straight through
    centroid_y_deg: float
    fwhm_deg: float  # of the disc with the area that is above half of the top
    turns: float  # of the spiral across the full width at half maximum

    @property
    def p_i(self) -> float:
        """P_i, signal * sr."""
        return self.power.value

    @property
    def p_i_u_rel(self) -> float:
        """Its relative standard uncertainty from this scan: noise, skirt, quadrature."""
        return self.power.u / self.p_i if self.p_i > 0.0 else np.inf

    def results(self) -> Results:
        """Entries of the beam's integrals: p_i with its budget, p_i_voronoi, centroid, fwhm_deg, turns; of two scans
        and more reference_ratio: the last one's P_i over the first one's."""
        found = Results()
        found.put("p_i", self.power)
        found.values |= {
            "p_i_voronoi": self.voronoi,
            "centroid_x_deg": self.centroid_x_deg,
            "centroid_y_deg": self.centroid_y_deg,
            "fwhm_deg": self.fwhm_deg,
            "turns": self.turns,
        }
        if len(self.scans) > 1:
            # Skirt and quadrature are the same in both scans, and cancel.
            found.put("reference_ratio", self.scans[-1].over(self.scans[0]))
        return found

    def notes(self) -> list[str]:
        """What the user should know about P_i."""
        found = []
        if self.turns < ENOUGH_TURNS:
            found.append(
                f"the reference spiral crosses the beam in {self.turns:.1f} turns per full width at half maximum, P_i "
                f"may be off by {self.p_i_u_rel:.2%}: choose [reference] pitch_deg for {LEAST_TURNS:g} turns or more"
            )
        if len(self.scans) > 1:
            ratio = self.scans[-1].over(self.scans[0])
            if abs(ratio.value - 1.0) > 3.0 * ratio.u:
                found.append(
                    f"P_i of the last reference scan is {ratio.value:.4f} of the first one's (standard uncertainty "
                    f"{ratio.u:.1g}): the lamp drifted and the monitor did not follow, or something moved"
                )
        return found


def measure_beam(
    detector_lab: FloatArray,
    normalised_signal: FloatArray,
    variance: FloatArray,
    used: BoolArray,
    scan: NDArray[np.int32] | None = None,
) -> Beam:
    """P_i from the reference spiral in the order it was flown: detector directions (n, 3), lab frame; signal over lamp
    monitor (n,) and its variance; `used` (n,) leaves out masked samples; `scan` (n,): which reference scan each sample
    belongs to, where there are several. P_i is the mean over the scans.

    Nothing is subtracted: the dark is gone already, and a skirt of the beam belongs to it. What the outermost tenth of
    the disc still reads, taken over the whole disc, is the effect `skirt`; `quadrature` is what 2 V - P1 leaves.
    """
    number = np.zeros(len(detector_lab), dtype=np.int32) if scan is None else scan
    scans = [samples for one in np.unique(number) if (samples := np.flatnonzero(used & (number == one))).size]
    omega, linear = np.zeros(len(detector_lab)), np.zeros(len(detector_lab))
    signal, variance = np.where(used, normalised_signal, 0.0), np.where(used, variance, 0.0)
    x_deg, y_deg = np.degrees(detector_lab[:, 0]), np.degrees(detector_lab[:, 1])
    polar_deg = np.degrees(np.arctan2(np.hypot(detector_lab[:, 0], detector_lab[:, 1]), -detector_lab[:, 2]))
    powers = []
    for own in scans:
        found = _cells(detector_lab[own])
        omega[own], linear[own] = found.solid_angle_sr, found.linear_sr
        powers.append(_power(detector_lab[own], signal[own], variance[own], polar_deg[own], found))
    count = max(len(scans), 1)
    power = Uncertain(0.0)
    for one in powers:
        power = power.plus(one.scaled(1.0 / count))
    omega, linear = omega / count, linear / count
    voronoi = float(signal @ omega)
    half = signal > 0.5 * signal.max()
    fwhm_deg = float(np.degrees(2.0 * np.sqrt(omega[half].sum() / np.pi)))
    return Beam(
        polar_deg=polar_deg,
        azimuth_deg=np.mod(np.degrees(np.arctan2(y_deg, x_deg)), 360.0),
        solid_angle_sr=omega,
        linear_sr=linear,
        power=power,
        voronoi=voronoi,
        scans=tuple(powers),
        centroid_x_deg=float((signal * x_deg) @ omega) / voronoi if voronoi > 0.0 else 0.0,
        centroid_y_deg=float((signal * y_deg) @ omega) / voronoi if voronoi > 0.0 else 0.0,
        fwhm_deg=fwhm_deg,
        turns=_turns(detector_lab, number, half, float(omega[half].sum()) * count, np.radians(fwhm_deg)),
    )


def _cells(unit: FloatArray) -> Cells:
    """Cells of one spiral. Outside its last turn they end where a next one would take over: a beam that fills the disc
    must not gain what nobody flew over."""
    pitch = path_pitch_rad(unit, np.zeros(len(unit), dtype=np.int64))
    reach = REACH_FACTOR * pitch
    step = float(np.quantile(np.linalg.norm(np.diff(unit, axis=0), axis=1), 0.9))
    off = np.arccos(np.clip(unit @ -SOURCE_LAB, -1.0, 1.0))
    last_turn = off > off.max() - pitch
    reach[last_turn] = _SLACK * np.hypot(0.5 * pitch[last_turn], step)
    return cells(unit, reach_rad=reach, cut_at_horizon=False)


def _power(
    unit: FloatArray, signal: FloatArray, variance: FloatArray, polar_deg: FloatArray, found: Cells
) -> Uncertain:
    """P_i of one scan with its budget."""
    weight = 2.0 * found.solid_angle_sr - found.linear_sr
    value, noise = float(weight @ signal), float(np.sqrt(weight**2 @ variance))
    edge = polar_deg > 0.9 * polar_deg.max()
    over_edge = float(found.solid_angle_sr[edge].sum())
    skirt = float(signal[edge] @ found.solid_angle_sr[edge]) / over_edge if over_edge > 0.0 else 0.0
    removed = found.solid_angle_sr - found.linear_sr
    left = left_of_peak_u(value, float(removed @ signal), float(np.sqrt(removed**2 @ variance)))
    azimuth = np.unwrap(np.arctan2(unit[:, 1], unit[:, 0]))
    even = np.floor(np.abs(azimuth - azimuth[0]) / (2.0 * np.pi)) % 2 == 0
    halves = []
    for half in (even, ~even):
        if half.sum() > _LEAST_POINTS:
            of_half = _cells(unit[half])
            halves.append(float((2.0 * of_half.solid_angle_sr - of_half.linear_sr) @ signal[half]))
    # Each half has twice the noise variance of the whole, their difference four times.
    between = max(abs(halves[0] - halves[1]) - 2.0 * noise, 0.0) / _HALVES if len(halves) == 2 else 0.0
    effects = {"skirt": skirt * float(found.solid_angle_sr.sum()), "quadrature": float(np.hypot(left, between))}
    return Uncertain(value, noise, effects)


def _turns(lab: FloatArray, number: NDArray[np.int32], half: BoolArray, area: float, width: float) -> float:
    """Turns of the spiral across the width: its length where it reads more than half, over the area, is one over the
    distance of the turns."""
    steps = np.linalg.norm(np.diff(lab, axis=0), axis=1)
    own = half[1:] & half[:-1] & (number[1:] == number[:-1])
    return width * float(steps[own].sum()) / area if area > 0.0 else 0.0
