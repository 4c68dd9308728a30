"""figures.py: what firmware, twin and host reach together, by the real command line, against the twin's truth.

`make figures` prints the table; host/tests/figures asserts the same figures. Needs the built twin.
"""

import os
import subprocess
import sys
import tempfile
import tomllib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from gonio.dataset.bsdf import Dataset
from gonio.dataset.nexus import read_dataset
from gonio.geometry.directions import angle_between_deg, unit_from_angles_deg
from gonio.geometry.kinematics import Kinematics
from gonio.rawlog.reader import RawLog, read_rawlog
from gonio.reduce.integrals.truth_beside import beside
from gonio.reduce.samples.pairing import PoseTrack
from gonio.simulate.closed_form import Truth
from gonio.units.instrument import Instrument, load_instrument

ROOT = Path(__file__).resolve().parents[2]
PLANS, SCENARIOS = ROOT / "docs" / "examples", ROOT / "sim" / "scenarios"
TRUTH_DTYPE = np.dtype([("sample", "<u8"), ("time_ns", "<i8"), ("q_deg", "<f8", (4,)), ("signal", "<f8")])
HIGH_CHANNEL = 0
FINER = 1000
EDGE_SAMPLES = 20  # the spline through the truth is not used at the ends of a recording


@dataclass(frozen=True)
class Figure:
    name: str
    value: float
    limit: float | None  # the largest absolute value allowed; None: printed only
    unit: str

    @property
    def kept(self) -> bool:
        return self.limit is None or abs(self.value) <= self.limit


def gonio(*arguments: str | Path, folder: Path) -> None:
    """Run the real command; its control socket stands in `folder`, so that no other scan is disturbed."""
    command = [sys.executable, "-m", "gonio.cli.main", *map(str, arguments)]
    done = subprocess.run(
        command, env=os.environ | {"XDG_RUNTIME_DIR": str(folder)}, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, arguments))}: {done.stderr.strip()}")


def measure(plan: Path, scenario: Path, folder: Path) -> Dataset:
    """Scan and reduce; the dataset."""
    raw, reduced = folder / "raw.mcap", folder / "bsdf.h5"
    gonio("scan", plan, "--device", f"twin:{scenario}", "-o", raw, folder=folder)
    gonio("reduce", raw, "-o", reduced, folder=folder)
    return read_dataset(reduced)


def beam_power(dataset: Dataset, scenario: Path) -> Figure:
    power_counts = tomllib.loads(scenario.read_text())["beam"]["power_counts"]
    return Figure("P_i against the beam's power", 100.0 * (dataset.distributions[0].p_i / power_counts - 1.0), 0.1, "%")


def lambertian(folder: Path) -> list[Figure]:
    """Direct-hemispherical reflectance of Lambertian 0.5."""
    scenario = SCENARIOS / "lambertian.toml"
    distribution = measure(PLANS / "lambertian.toml", scenario, folder).distributions[0]
    found, truth = distribution.integrals, beside(distribution, Truth.from_scenario(scenario))
    there = 100.0 * (found["rho_measured"] / truth["rho_truth_measured"] - 1.0)
    whole = 100.0 * (found["rho_estimate"] / 0.5 - 1.0)
    unseen = 100.0 * (1.0 - found["rho_measured_share"])
    return [
        Figure("Lambertian 0.5: reflectance, masked guessed", whole, 0.2, "%"),
        Figure("Lambertian 0.5: measured directions, truth there", there, 0.2, "%"),
        Figure("Lambertian 0.5: shaded or out of reach", unseen, None, "%"),
    ]


def lobe(folder: Path) -> list[Figure]:
    """A mirror lobe of sigma 1.2 degrees against its truth convolved with beam and aperture."""
    scenario = SCENARIOS / "demo.toml"
    dataset = measure(PLANS / "lobe.toml", scenario, folder)
    truth = Truth.from_scenario(scenario)
    part = next(c for c in tomllib.loads(scenario.read_text())["sample"]["components"] if c.get("about") == "mirror")
    distribution = dataset.distributions[0]
    found = {key.rsplit(" ", 1)[1]: value for key, value in distribution.integrals.items() if "mirror" in key}
    expected = unit_from_angles_deg(distribution.incident_theta_deg, distribution.incident_phi_deg + 180.0)
    off_deg = angle_between_deg(unit_from_angles_deg(found["theta_deg"], found["phi_deg"]), expected)
    sigma_deg = truth.peak_sigma_deg(part["sigma_deg"])
    return [
        beam_power(dataset, scenario),
        Figure("lobe of sigma 1.2 deg: direction", float(off_deg), 0.01, "deg"),
        Figure("lobe of sigma 1.2 deg: integral", 100.0 * (found["integral"] / part["integral"] - 1.0), 0.5, "%"),
        Figure("lobe of sigma 1.2 deg: sigma", 100.0 * (found["sigma_deg"] / sigma_deg - 1.0), 1.0, "%"),
    ]


@dataclass
class Recording:
    """A scan with everything that can spoil a sample's time, and the twin's own record of it."""

    log: RawLog
    truth: NDArray[np.void]  # TRUTH_DTYPE, of the samples in the log
    moving: NDArray[np.bool_]  # samples (n,) inside the sinusoid, clock settled, away from the recording's ends

    @classmethod
    def make(cls, folder: Path, scenario: Path = SCENARIOS / "pairing.toml") -> "Recording":
        raw, truth_file = folder / "pairing.mcap", folder / "truth.bin"
        gonio(
            "scan", PLANS / "pairing.toml", "--instrument", SCENARIOS / "pairing-axes.toml",
            "--device", f"twin:{scenario}", "--twin-truth", truth_file, "-o", raw, folder=folder,
        )  # fmt: skip
        log = read_rawlog([raw])
        truth = np.fromfile(truth_file, TRUTH_DTYPE)
        truth = truth[np.searchsorted(truth["sample"], log.sample_number)]
        if not np.array_equal(truth["sample"], log.sample_number):
            raise RuntimeError("the twin's record lacks samples that the raw log has")
        longest = max(
            (event.path.path_time_ns, event.time_ns) for event in log.events if event.WhichOneof("body") == "path"
        )
        inside = (log.sample_time_ns > longest[1] - longest[0]) & (log.sample_time_ns < longest[1])
        inside[:EDGE_SAMPLES] = inside[-EDGE_SAMPLES:] = False
        return cls(log, truth, inside & log.sample_settled)


@dataclass
class Pairing:
    """Poses and true poses of a recording's moving samples, all arrays over them; the delays of pairing-axes.toml.

    The light of a sample comes its channel's delay before the strobe; the twin's record holds the pose at the strobe,
    each millisecond: a spline gives it at any other time.
    """

    wanted_deg: NDArray[np.float64]  # (n, axes)
    speed_deg_per_s: NDArray[np.float64]  # (n, axes)
    paired_deg: NDArray[np.float64]  # by the firmware's clock and the logged positions
    flags: NDArray[np.uint16]
    true_clock_deg: NDArray[np.float64]  # by the true clock and the logged positions
    exact_deg: NDArray[np.float64]  # by the true clock and exact positions at the logged SYNC times
    clock_error_us: NDArray[np.float64]
    kinematics: Kinematics

    @classmethod
    def of(cls, recording: Recording) -> "Pairing":
        instrument = load_instrument(SCENARIOS / "pairing-axes.toml")
        log, truth, moving = recording.log, recording.truth, recording.moving
        delay_ns = 1e3 * instrument.channels[HIGH_CHANNEL].delay_us
        origin_ns = int(truth["time_ns"][0])
        true_pose = CubicSpline((truth["time_ns"] - origin_ns).astype(np.float64), truth["q_deg"])
        light_ns = (truth["time_ns"] - origin_ns).astype(np.float64)[moving] - delay_ns
        track = PoseTrack.from_poses(log.poses, instrument.axes)
        fitted_ns, true_ns = log.sample_time_ns[moving], truth["time_ns"][moving]
        paired_deg, flags = track.pose_at(fitted_ns, delay_ns)
        exact = exact_positions(log.poses, true_pose, origin_ns, instrument)
        return cls(
            wanted_deg=true_pose(light_ns),
            speed_deg_per_s=np.abs(true_pose(light_ns, 1)) * 1e9,
            paired_deg=paired_deg,
            flags=flags,
            true_clock_deg=track.pose_at(true_ns, delay_ns)[0],
            exact_deg=exact.pose_at(true_ns, delay_ns)[0],
            clock_error_us=(fitted_ns - true_ns) * 1e-3,
            kinematics=Kinematics(instrument.axes),
        )

    def error_deg(self, q_deg: NDArray[np.float64]) -> NDArray[np.float64]:
        """The larger of the errors of incident and outgoing direction, shape (n,)."""
        pairs = zip(self.kinematics.directions(q_deg), self.kinematics.directions(self.wanted_deg), strict=True)
        return np.asarray(np.max([angle_between_deg(ours, true) for ours, true in pairs], axis=0))


def pairing(folder: Path) -> list[Figure]:
    """Error of every sample's direction, all axes swinging at up to 30 degrees/s, and what each part contributes."""
    found = Pairing.of(Recording.make(folder))
    figures = [
        Figure("pairing: samples", float(len(found.flags)), None, ""),
        Figure("pairing: fastest axis", float(found.speed_deg_per_s.max()), None, "deg/s"),
        Figure("pairing: samples without a plain pose", float(np.count_nonzero(found.flags)), 0.0, ""),
    ]
    strobe_deg = found.wanted_deg + (found.paired_deg - found.true_clock_deg)
    parts = {
        "all together": (found.paired_deg, 0.002),
        "quantisation and echo stamp": (found.true_clock_deg, None),
        "SYNC (cubic through jittered times)": (found.exact_deg, None),
        "strobe (sample clock)": (strobe_deg, None),
    }
    for name, (q_deg, limit) in parts.items():
        error_deg = found.error_deg(q_deg)
        figures.append(Figure(f"pairing, {name}: max", float(error_deg.max()), limit, "deg"))
        figures.append(Figure(f"pairing, {name}: rms", float(np.sqrt(np.mean(error_deg**2))), None, "deg"))
    figures.append(Figure("sample clock: max", float(np.abs(found.clock_error_us).max()), None, "us"))
    return figures


def exact_positions(
    poses: NDArray[np.void], true_pose: CubicSpline, origin_ns: int, instrument: Instrument
) -> PoseTrack:
    """The same SYNCs with positions from the truth, in counts a thousand times as fine: the SYNC part alone."""
    fine = poses.copy()
    axes = [replace(axis, counts_per_deg_ratio=axis.counts_per_deg_ratio * FINER) for axis in instrument.axes]
    for number, axis in enumerate(axes):
        at_ns = (poses["sync_time_ns"] - origin_ns).astype(np.float64) + 1e3 * axis.latch_delay_us
        inside = np.clip(at_ns, true_pose.x[0], true_pose.x[-1])  # a spline must not run off beyond its ends
        fine["position_counts"][:, number] = np.rint(true_pose(inside)[:, number] * axis.counts_per_deg)
    return PoseTrack.from_poses(fine, axes)


def main() -> int:
    """Print the table; 1 if a figure is not kept."""
    figures: list[Figure] = []
    for work in (lambertian, lobe, pairing):
        with tempfile.TemporaryDirectory(prefix="gonio-figures-") as folder:
            figures += work(Path(folder))
    for figure in figures:
        limit = "" if figure.limit is None else f"limit {figure.limit:g}  {'kept' if figure.kept else 'NOT KEPT'}"
        sys.stdout.write(f"{figure.name:52} {figure.value:12.6g} {figure.unit:6} {limit}\n")
    return 0 if all(figure.kept for figure in figures) else 1


if __name__ == "__main__":
    sys.exit(main())
