"""synthetic_scan.py: raw logs made in numpy from a closed-form truth: what the instrument would have recorded."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from gonio.geometry.directions import mirror, tangent_frame, unit_from_angles_deg
from gonio.geometry.kinematics import Kinematics
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.protocol.generated.records import POSE_DTYPE, SAMPLE_BLOCK_DTYPE, SAMPLE_DTYPE, SAMPLE_HIGH_SATURATED
from gonio.rawlog.reader import RawLog
from gonio.rawlog.segment_reader import Segment
from gonio.simulate.closed_form import Truth
from gonio.units.instrument import Instrument, load_instrument, parse_instrument

FloatArray = NDArray[np.float64]
BOOT_NS = 1_700_000_000_123_456_789
POWER_COUNTS = 1500.0
FULL_SCALE = 8388607
RAMP_S = 0.5


def instrument_with_delays() -> Instrument:
    """The reference instrument with delays calibrated on channels and axes."""
    text = load_instrument(None).text
    head, *channels = text.split("[[channel]]")
    for value in ("20.0", "45.0", "70.0", "10.0"):
        head = head.replace("latch_delay_us = 0.0 ", f"latch_delay_us = {value} ", 1)
    delayed = [
        c.replace("delay_us = 0.0", f"delay_us = {v}", 1) for c, v in zip(channels, ("180.0", "60.0"), strict=True)
    ]
    return parse_instrument("[[channel]]".join([head, *delayed]), "synthetic")


def spiral(centre: tuple[float, float], radius_deg: float, pitch_deg: float) -> FloatArray:
    """Directions (n, 3) of an Archimedean spiral from its centre outwards."""
    turns = radius_deg / pitch_deg
    azimuth = 2.0 * np.pi * np.sqrt(np.linspace(0.0, turns**2, int(400 * turns)))
    polar = np.radians(pitch_deg) * azimuth / (2.0 * np.pi)
    e1, e2, pole = tangent_frame(unit_from_angles_deg(*centre))
    ring = np.cos(azimuth)[:, None] * e1 + np.sin(azimuth)[:, None] * e2
    return np.asarray(np.sin(polar)[:, None] * ring + np.cos(polar)[:, None] * pole)


def circles(pitch_deg: float) -> FloatArray:
    """Arm readings (n, 2) along circles of elevation, to and fro."""
    corners = []
    for number, elevation in enumerate(np.arange(-84.0, 84.1, pitch_deg)):
        ends = (-179.0, 179.0) if number % 2 == 0 else (179.0, -179.0)
        corners += [np.stack((np.linspace(*ends, 720), np.full(720, elevation)), axis=1)]
    return np.concatenate(corners)


@dataclass
class Scan:
    """Builds one segment: add legs, then `log()`."""

    truth: Truth
    instrument: Instrument = field(default_factory=instrument_with_delays)
    noise_counts: tuple[float, float] = (8.0, 0.5)
    dark_counts: tuple[float, float] = (350.0, 12.0)
    dark_drift_per_s: tuple[float, float] = (0.05, 0.002)
    shot_noise: float = 0.001
    lamp_drift_per_s: float = 2e-4
    monitor_noise: float = 200.0
    jitter_us: float = 120.0
    seed: int = 1

    def __post_init__(self) -> None:
        self.kinematics = Kinematics(self.instrument.axes)
        self.legs: list[tuple[float, float, Any]] = []  # begin s, end s, spline of the readings
        self.paths: list[dict[str, Any]] = []
        self.events: list[pb.Event] = []
        self.mounted: list[tuple[float, float, bool]] = []
        self.now_s = 0.2
        self.at = np.zeros(4)
        self._shutter(on=False)

    def _event(self, **body: Any) -> None:
        self.events.append(pb.Event(time_ns=BOOT_NS + round(self.now_s * 1e9), **body))

    def _shutter(self, *, on: bool) -> None:
        self._event(output=pb.SetOutput(output=pb.OUTPUT_SHUTTER, on=on))

    def dark(self, duration_s: float = 1.0) -> None:
        self._shutter(on=False)
        self.now_s += duration_s + 0.3
        self._shutter(on=True)
        self.now_s += 0.2

    def fly(
        self, kind: str, name: str, q_deg: FloatArray, incident: tuple[float, float] | None, a_deg_s2: float
    ) -> None:
        """Move to the first of the readings (n, 4) and follow them at 30 degrees/s, slower where they bend."""
        start = np.concatenate((self.at[None], q_deg[:1]))
        self._leg(CubicSpline([self.now_s, self.now_s + 2.0], start, bc_type="clamped"), 2.0)
        step = np.linalg.norm(np.diff(q_deg, axis=0), axis=1)
        along = np.r_[0.0, np.cumsum(step)]
        tangent = np.gradient(q_deg, along, axis=0)
        bend = np.linalg.norm(np.gradient(tangent, along, axis=0), axis=1)
        speed = np.minimum(30.0, np.sqrt(a_deg_s2 / np.maximum(bend, 1e-9)))
        clock = np.r_[0.0, np.cumsum(step / (0.5 * (speed[1:] + speed[:-1])))]
        # From rest to rest: path time runs up to speed and down again within the ramps.
        duration = clock[-1] + RAMP_S
        t = np.linspace(0.0, duration, int(duration * 100) + 50)
        ramp = np.minimum(np.minimum(t, duration - t) / RAMP_S, 1.0)
        rate = ramp**2 * (3.0 - 2.0 * ramp)
        path_time = np.r_[0.0, np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(t))]
        path_time *= clock[-1] / path_time[-1]
        readings = CubicSpline(clock, q_deg)(path_time)
        path_id = len(self.paths) + 1
        entry = {"path_id": path_id, "kind": kind, "name": name}
        if incident is not None:
            entry |= {"incident_theta_deg": incident[0], "incident_phi_deg": incident[1]}
        self.paths.append(entry)
        self._event(path=pb.PathState(path_id=path_id, end=pb.PATH_RUNNING))
        self._leg(CubicSpline(self.now_s + t, readings, bc_type="clamped"), duration)
        self._event(path=pb.PathState(path_id=path_id, end=pb.PATH_FINISHED))

    def _leg(self, readings: Any, duration_s: float) -> None:
        self.legs.append((self.now_s, self.now_s + duration_s, readings))
        self.now_s += duration_s
        self.at = np.asarray(readings(self.now_s))

    def reference(self, radius_deg: float = 1.6, pitch_deg: float = 0.1) -> None:
        self.mounted.append((self.now_s, np.inf, False))
        self.fly_spiral("reference", "reference", (180.0, 0.0), (0.0, 0.0), radius_deg, pitch_deg)
        self.mounted[-1] = (self.mounted[-1][0], self.now_s, False)

    def peak(self, incident: tuple[float, float], radius_deg: float, pitch_deg: float) -> None:
        theta, phi = mirror(*incident)
        self.fly_spiral("peak", "mirror", (float(theta), float(phi)), incident, radius_deg, pitch_deg)

    def fly_spiral(
        self, kind: str, name: str, centre: tuple[float, float], incident: tuple[float, float], *size: float
    ) -> None:
        """A spiral about `centre` (sample frame, degrees); `size`: radius and pitch in degrees."""
        q1, q2 = self.kinematics.sample_axes_for_incident(*incident)
        arm = self.kinematics.arm_for_outgoing(q1, q2, spiral(centre, *size))
        arm[:, 0] = np.degrees(np.unwrap(np.radians(arm[:, 0])))
        q_deg = np.concatenate((np.tile([q1, q2], (len(arm), 1)), arm), axis=1)
        self.fly(kind, name, q_deg, None if kind == "reference" else incident, 60.0)

    def coarse(self, incident: tuple[float, float], pitch_deg: float) -> None:
        q1, q2 = self.kinematics.sample_axes_for_incident(*incident)
        arm = circles(pitch_deg)
        q_deg = np.concatenate((np.tile([q1, q2], (len(arm), 1)), arm), axis=1)
        self.fly("coarse", "coarse", q_deg[np.r_[True, np.any(np.diff(q_deg, axis=0) != 0, axis=1)]], incident, 600.0)

    def readings_deg(self, t_s: FloatArray) -> FloatArray:
        """True readings (n, 4) at times (n,) in s after BOOT_NS."""
        q = np.zeros((len(t_s), 4))
        q[:] = self.legs[0][2](self.legs[0][0])
        for begin, _, readings in self.legs:
            after = t_s >= begin
            q[after] = readings(np.minimum(t_s[after], readings.x[-1]))
        return q

    def light_counts(self, t_s: FloatArray) -> FloatArray:
        """Noise-free light in low-gain counts (n,) at times (n,) in s."""
        q = self.readings_deg(t_s)
        incident, outgoing = self.kinematics.directions(q)
        light = np.empty(len(t_s))
        free = np.zeros(len(t_s), dtype=bool)
        for begin, end, _ in self.mounted:
            free |= (t_s >= begin) & (t_s <= end)
        lab = self.kinematics.detector_in_lab(q[free])
        light[free] = self.truth.beam_per_sr(np.degrees(np.arctan2(np.hypot(lab[:, 0], lab[:, 1]), -lab[:, 2])))
        theta = np.degrees(np.arccos(np.clip(incident[:, 2], -1, 1)))
        for value in np.unique(np.round(theta[~free], 6)):
            own = ~free & (np.abs(theta - value) < 2e-6)
            light[own] = self.truth.dsf_per_sr(float(value), 0.0, outgoing[own])
        lamp = 1.0 + self.lamp_drift_per_s * t_s
        return np.asarray(POWER_COUNTS * lamp * light * self._open(t_s))

    def _open(self, t_s: FloatArray) -> FloatArray:
        times = [(e.time_ns - BOOT_NS) * 1e-9 for e in self.events if e.WhichOneof("body") == "output"]
        states = [float(e.output.on) for e in self.events if e.WhichOneof("body") == "output"]
        return np.asarray(np.array([0.0, *states])[np.searchsorted(times, t_s, side="right")])

    def log(self) -> RawLog:
        rng = np.random.default_rng(self.seed)
        count = int((self.now_s + 0.1) * 1000)
        time_ns = np.arange(count, dtype=np.int64) * 1_000_017
        t_s = time_ns.astype(np.float64) * 1e-9
        channels = {c.name: c for c in self.instrument.channels}
        samples = np.zeros(count, dtype=SAMPLE_DTYPE)
        shot = rng.standard_normal(count)
        columns = (("high", 1000.0, "high_counts"), ("low", 1.0, "low_counts"))
        for index, (name, gain, column) in enumerate(columns):
            light = self.light_counts(t_s - 1e-6 * channels[name].delay_us)
            light += shot * np.sqrt(self.shot_noise * np.maximum(light, 0.0))
            value = gain * light + self.dark_counts[index] + self.dark_drift_per_s[index] * t_s
            value += self.noise_counts[index] * rng.standard_normal(count)
            if name == "high":
                samples["flags"] |= np.where(value >= FULL_SCALE, SAMPLE_HIGH_SATURATED, 0).astype(np.uint16)
            samples[column] = np.rint(np.minimum(value, FULL_SCALE))
        lamp = 1.0 + self.lamp_drift_per_s * t_s
        samples["monitor_counts"] = np.rint(4e6 * lamp + self.monitor_noise * rng.standard_normal(count))
        samples["temperature_centi_c"] = 2500
        metadata = {
            "paths": self.paths,
            "unreachable": [],
            "instrument": self.instrument.text,
            "sample": {"name": "synthetic", "front_faces": "exterior", "symmetry": "isotropic", "thickness_mm": 1.0},
            "beam": {"kind": "focused", "diameter_mm": 10.0, "divergence_deg": 1.0},
        }
        segment = Segment(Path("synthetic.mcap"), "0" * 64, metadata, complete=True)
        poses = self.poses(rng)
        return RawLog(
            metadata=metadata,
            segments=[segment],
            samples=samples,
            sample_number=np.arange(count, dtype=np.uint64),
            sample_time_ns=BOOT_NS + time_ns,
            sample_settled=np.ones(count, dtype=bool),
            sample_segment=np.zeros(count, dtype=np.int32),
            sample_blocks=np.zeros(0, dtype=SAMPLE_BLOCK_DTYPE),
            poses=poses,
            pose_sigma_us=np.zeros(len(poses), dtype=np.float32),
            pose_segment=np.zeros(len(poses), dtype=np.int32),
            events=self.events,
            event_segment=[0] * len(self.events),
        )

    def poses(self, rng: np.random.Generator) -> NDArray[np.void]:
        count = int((self.now_s + 0.2) * 500)
        relative_ns = np.rint(np.arange(count) * 2e6 + rng.uniform(-self.jitter_us, self.jitter_us, count) * 1e3)
        poses = np.zeros(count, dtype=POSE_DTYPE)
        poses["sync_time_ns"] = BOOT_NS + relative_ns.astype(np.int64)
        poses["sync_number"] = np.arange(1, count + 1)
        poses["valid"] = 0b1111
        for number, axis in enumerate(self.instrument.axes):
            latched_s = relative_ns * 1e-9 + 1e-6 * axis.latch_delay_us
            poses["position_counts"][:, number] = np.rint(self.readings_deg(latched_s)[:, number] * axis.counts_per_deg)
        return poses
