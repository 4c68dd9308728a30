"""repeated_scan.py: one scan repeated thousands of times as reduced samples, with every error drawn anew and acting as
it does in the instrument: nothing here knows the linear model that it judges."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution, PointFlag
from gonio.geometry.cells import cells
from gonio.reduce.corrections.light import Gains
from gonio.reduce.effects.columns import angles_of, effect_columns, pose_variance
from gonio.reduce.effects.power import reference_beam
from gonio.reduce.points import Points, Scale, distribution_of
from gonio.units.instrument import Instrument, load_instrument

FloatArray = NDArray[np.float64]

AMPLIFIER_COUNTS = (8.0, 0.5)  # rms of a sample, high and low gain
SHOT_PER_COUNT = 1e-3  # low-gain counts
DARK_U_COUNTS = (0.5, 0.1)
POWER_COUNTS_SR = 2000.0
BEAM_SIGMA_RAD = np.radians(0.45)
SKIRT_U_REL = 5e-4
STAMP_U_US = 100.0


@dataclass(frozen=True)
class Truth:
    """Lambertian reflectance and Gaussian peaks about the mirror direction: (integral, sigma in degrees), as they are
    seen through beam and aperture."""

    reflectance: float = 0.5
    peaks: tuple[tuple[float, float], ...] = ((0.15, 8.0), (0.2, 0.5))

    def dsf_per_sr(self, incident: FloatArray, outgoing: FloatArray) -> FloatArray:
        """For vectors (3, ...) each."""
        value = self.reflectance / np.pi * np.maximum(outgoing[2], 0.0)
        apart = (outgoing[0] + incident[0]) ** 2 + (outgoing[1] + incident[1]) ** 2 + (outgoing[2] - incident[2]) ** 2
        for integral, sigma_deg in self.peaks:
            sigma = np.radians(sigma_deg)
            value = value + integral / (2.0 * np.pi * sigma**2) * np.exp(-0.5 * apart / sigma**2)
        return np.asarray(value)


def sample_frame(q_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Incident and outgoing vectors (3, ...) for readings (4, ...), from CONVENTIONS.md: lab <- sample = R_Y(-q1)
    R_z(-q2), detector in the lab = (sin q3 cos q4, sin q4, cos q3 cos q4)."""
    q1, q2, q3, q4 = q_rad
    detector = np.stack((np.sin(q3) * np.cos(q4), np.sin(q4), np.cos(q3) * np.cos(q4)))
    source = np.stack((np.zeros_like(q1), np.zeros_like(q1), np.ones_like(q1)))
    both = []
    for x, y, z in (source, detector):
        turned_x, turned_z = np.cos(q1) * x + np.sin(q1) * z, np.cos(q1) * z - np.sin(q1) * x
        turned = np.cos(q2) * turned_x - np.sin(q2) * y, np.sin(q2) * turned_x + np.cos(q2) * y, turned_z
        both.append(np.stack(turned))
    return both[0], both[1]


def tilted(v: FloatArray, about_x: FloatArray, about_y: FloatArray) -> FloatArray:
    """Vectors (3, ...) as a sample sees them that is turned by small angles about x, then y, of its nominal frame."""
    x, y, z = v
    x, z = np.cos(about_y) * x - np.sin(about_y) * z, np.sin(about_y) * x + np.cos(about_y) * z
    y, z = np.cos(about_x) * y + np.sin(about_x) * z, np.cos(about_x) * z - np.sin(about_x) * y
    return np.stack((x, y, z))


@dataclass
class Flight:
    """Readings (n, 4) and rates (n, 4) of the points, and each point's path: 0 the coarse one, 1 the spiral."""

    q_deg: FloatArray
    rate_deg_per_s: FloatArray
    path: NDArray[np.int32]

    @classmethod
    def about_mirror(
        cls, theta_deg: float, roll_deg: float, pitch_deg: float = 0.12, radius_deg: float = 2.4
    ) -> "Flight":
        """Circles of arm elevation over the front, and a spiral in arm angles about the mirror direction."""
        circles = []
        for number, elevation in enumerate(np.arange(-60.0, 60.1, 4.0)):
            arm = np.arange(-85.0, 85.1, 3.0)[:: 1 if number % 2 == 0 else -1] - theta_deg
            circles.append(np.stack((arm, np.full(len(arm), elevation)), axis=1))
        coarse = np.concatenate(circles)
        turns = radius_deg / pitch_deg
        azimuth = 2.0 * np.pi * np.sqrt(np.linspace(0.0, turns**2, int(45 * turns)))
        polar = pitch_deg * azimuth / (2.0 * np.pi)
        spiral = np.stack((-2.0 * theta_deg + polar * np.cos(azimuth), polar * np.sin(azimuth)), axis=1)
        arm = np.concatenate((coarse, spiral))
        path = np.repeat(np.array([0, 1], dtype=np.int32), (len(coarse), len(spiral)))
        along = np.gradient(arm, axis=0)
        speed = np.where(path == 0, 20.0, 6.0)
        rate = along / np.maximum(np.linalg.norm(along, axis=1), 1e-12)[:, None] * speed[:, None]
        still = np.tile([theta_deg, roll_deg], (len(arm), 1))
        return cls(np.concatenate((still, arm), axis=1), np.concatenate((0.0 * rate, rate), axis=1), path)


@dataclass
class RepeatedScan:
    """`flight` over `truth` by `instrument`, whose file states every uncertainty."""

    truth: Truth
    flight: Flight
    instrument: Instrument
    incident_deg: tuple[float, float]

    def __post_init__(self) -> None:
        self.gains = Gains.of(self.instrument)
        incident, outgoing = sample_frame(np.radians(self.flight.q_deg.T))
        self.true_dsf = self.truth.dsf_per_sr(incident, outgoing)
        self.unit = np.ascontiguousarray(outgoing.T)
        turns = np.sqrt(np.linspace(0.0, 15.0**2, 400))
        self.beam_polar_rad = np.radians(1.8) * turns / 15.0
        self.beam_cell_sr = np.full(400, np.pi * np.radians(1.8) ** 2 / 400)
        profile = np.exp(-0.5 * (self.beam_polar_rad / BEAM_SIGMA_RAD) ** 2)
        self.beam_light = POWER_COUNTS_SR * profile / (profile @ self.beam_cell_sr)
        self.solid_angle_sr = cells(self.unit, reach_rad=np.where(self.flight.path == 0, 0.1, 0.005)).solid_angle_sr

    def repeats(self, count: int, rng: np.random.Generator) -> tuple[FloatArray, ...]:
        """`count` scans: DSF (count, n), signal, high weight (the same), P_i (count, 1), and its beam's signal and
        weight (count, b)."""
        cal, axes, n = self.instrument.calibration, self.instrument.axes, len(self.unit)

        def drawn(u: float, *shape: int) -> FloatArray:
            return u * rng.standard_normal((count, *shape))

        zero_rad = np.radians(drawn(cal.axis_zero_u_deg, 4))
        latch_us = np.stack([drawn(axis.latch_delay_u_us) for axis in axes], axis=1)
        channel_us = [drawn(channel.delay_u_us, 1) for channel in (self.gains.high, self.gains.low)]
        stamp_us = drawn(STAMP_U_US, n)
        # The arm's readings are whole counts of what may be anywhere within one; the sample's axes stand.
        count_deg = np.array([0.0, 0.0, *(1.0 / abs(axis.counts_per_deg) for axis in axes[2:])])
        read_deg = self.flight.q_deg.T + count_deg[:, None] * rng.uniform(-0.5, 0.5, (count, 4, n))
        gain_rel = [drawn(channel.gain_u_rel, 1) for channel in (self.gains.high, self.gains.low)]
        bend = cal.nonlinearity + drawn(cal.nonlinearity_u, 1)
        tilt_x, tilt_y = (np.radians(drawn(cal.tilt_u_deg, 1)) for _ in "xy")
        offset_mm = cal.sample_offset_mm + drawn(cal.sample_offset_u_mm, 1)
        stray = cal.stray_light_per_sr + drawn(cal.stray_light_u_per_sr, 1)
        lamp = 1.0 + drawn(cal.monitor_u_rel, 1)
        # The beam, by the same receiver; its darks are others.
        beam = self._counted(np.tile(self.beam_light, (count, 1)), gain_rel, bend, rng)
        p_i = (beam[0] @ self.beam_cell_sr)[:, None] * (1.0 + drawn(SKIRT_U_REL, 1))
        # Which channel counts decides whose delay it was: its own light is asked for.
        light = []
        for late_us in channel_us:
            time_s = 1e-6 * (latch_us[:, :, None] + (stamp_us - late_us)[:, None, :])
            q = np.radians(read_deg + self.flight.rate_deg_per_s.T * time_s) + zero_rad[:, :, None]
            incident, outgoing = sample_frame(np.moveaxis(q, 1, 0))
            incident, outgoing = tilted(incident, tilt_x, tilt_y), tilted(outgoing, tilt_x, tilt_y)
            towards = self.instrument.arm_radius_mm * outgoing - offset_mm * incident / incident[2]
            distance = np.sqrt((towards**2).sum(axis=0))
            dsf = self.truth.dsf_per_sr(incident, towards / distance) + stray
            light.append(POWER_COUNTS_SR * lamp * dsf * (self.instrument.arm_radius_mm / distance) ** 2)
        signal, weight = self._counted(light, gain_rel, bend, rng)
        return signal / p_i, signal, weight, p_i, *beam

    def _counted(
        self,
        light: FloatArray | list[FloatArray],
        gain_rel: list[FloatArray],
        bend: FloatArray,
        rng: np.random.Generator,
    ) -> tuple[FloatArray, FloatArray]:
        """Dark-subtracted signal and high weight (count, n) for light (count, n) in low-gain counts, the same for both
        channels or one each."""
        both = light if isinstance(light, list) else [light, light]
        shot = rng.standard_normal(both[0].shape)
        offset = [u * rng.standard_normal((len(shot), 1)) for u in DARK_U_COUNTS]
        counts = []
        for channel, of_channel, rel, noise, dark in zip(
            (self.gains.high, self.gains.low), both, gain_rel, AMPLIFIER_COUNTS, offset, strict=True
        ):
            fallen = of_channel + shot * np.sqrt(SHOT_PER_COUNT * np.maximum(of_channel, 0.0))
            true = channel.gain * (1.0 + rel) * fallen / channel.full_scale_counts
            # light = s (1 + c s): what s the receiver shows for it.
            shown = 2.0 * true / (1.0 + np.sqrt(np.maximum(1.0 + 4.0 * bend * true, 0.0)))
            value = shown * channel.full_scale_counts + noise * rng.standard_normal(shot.shape) + dark
            counts.append(np.minimum(np.rint(value), channel.full_scale_counts))
        weight = self.gains.high_weight({"high_counts": counts[0], "flags": np.zeros(1, dtype=np.uint16)})  # type: ignore[arg-type]
        signal = weight * counts[0] / self.gains.high.gain + (1.0 - weight) * counts[1] / self.gains.low.gain
        return signal, weight

    def points(self, signal: FloatArray, weight: FloatArray, unit: FloatArray, path: NDArray[np.int32]) -> Points:
        """Signal and weight (n,) as the reduction's points."""
        n, gain = len(signal), self.gains.high.gain
        amplifier = (weight * AMPLIFIER_COUNTS[0] / gain) ** 2 + ((1.0 - weight) * AMPLIFIER_COUNTS[1]) ** 2
        flown = n == len(self.flight.path)
        return Points(
            unit=unit,
            signal=signal,
            variance=amplifier + SHOT_PER_COUNT * np.maximum(signal, 0.0),
            normalisation=np.ones(n),
            count=np.ones(n, dtype=np.int32),
            flags=np.full(n, PointFlag.MEASURED, dtype=np.uint16),
            time_ns=np.zeros(n, dtype=np.int64),
            path=path,
            q_deg=self.flight.q_deg if flown else np.zeros((n, 4)),
            axis_rate_deg_per_s=self.flight.rate_deg_per_s if flown else np.zeros((n, 4)),
            high_weight=weight,
            dark_u_counts=np.hypot(weight * DARK_U_COUNTS[0] / gain, (1.0 - weight) * DARK_U_COUNTS[1]),
        )

    def reduced(self, rng: np.random.Generator) -> Distribution:
        """One scan with its uncertainty, as the reduction gives it: it knows what one scan shows, and no truth."""
        dsf, signal, weight, p_i, beam_signal, beam_weight = self.repeats(1, rng)
        del dsf
        nowhere = np.zeros(len(beam_signal[0]), dtype=np.int32)
        beam_points = self.points(beam_signal[0], beam_weight[0], np.zeros((len(nowhere), 3)), nowhere)
        noise = float(np.sqrt(beam_points.variance @ self.beam_cell_sr**2)) / float(p_i[0, 0])
        beam = reference_beam(beam_points, self.beam_cell_sr, float(np.hypot(noise, SKIRT_U_REL)), self.instrument)
        points = self.points(signal[0], weight[0], self.unit, self.flight.path)
        scale = Scale(1.0, float(p_i[0, 0]), beam.p_i_u_rel, SHOT_PER_COUNT, 0.0)
        distribution = distribution_of(points, self.solid_angle_sr, self.incident_deg, scale)
        angles = angles_of(points, distribution, self.instrument)
        distribution.variance_per_sr2 += pose_variance(angles, STAMP_U_US)
        distribution.effects = effect_columns(points, distribution, self.instrument, beam, angles)
        return distribution


def reference_scan(theta_deg: float = 30.0, roll_deg: float = 0.0, **calibration: float) -> RepeatedScan:
    """The reference instrument; `calibration` replaces what its file says."""
    instrument = load_instrument(None)
    instrument = replace(instrument, calibration=replace(instrument.calibration, **calibration))
    return RepeatedScan(Truth(), Flight.about_mirror(theta_deg, roll_deg), instrument, (theta_deg, roll_deg))
