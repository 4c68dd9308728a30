"""big_scan.py: raw logs of any size for the benchmarks, written as gonio scan writes them: reference, coarse, peak."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gonio.geometry.kinematics import Kinematics
from gonio.protocol.frames import FrameDecoder, encode_frame
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.protocol.generated import records
from gonio.rawlog.writer import RawLogWriter
from gonio.units.instrument import load_instrument

FloatArray = NDArray[np.float64]
BOOT_NS = 1_000_000_000_000
POWER_COUNTS = 1500.0
INCIDENT_DEG = (30.0, 0.0)
SAMPLES_PER_BLOCK, POSES_PER_BLOCK = 100, 50
_DARK, _REFERENCE = 2000, 30_000  # samples of each dark, and of the reference spiral
_REST = 400  # samples between legs, while the axes stand where a leg ends or begins
_PEAK_SHARE = 0.2
_SWEEP_DEG, _SPEED_DEG_S, _STEP_SHARE = 358.0, 30.0, 0.03  # of the arm's circles; share of a sweep for the next one


@dataclass(frozen=True)
class Leg:
    """A stretch of samples at 1 kHz, from the first to before the last; a path where it has a kind."""

    first: int
    last: int
    kind: str = ""


def write_big_scan(path: Path, samples: int) -> None:
    """About `samples` samples of a path over the whole sphere and a spiral about the mirror direction of a sample with
    a Lambertian part and a lobe; noise and darks as real ones, positions in encoder counts at 500 Hz."""
    peak = int(_PEAK_SHARE * samples)
    legs, at = [], 0
    for kind, count in (
        ("", _DARK),
        ("reference", _REFERENCE),
        ("coarse", samples - peak),
        ("peak", peak),
        ("", _DARK),
    ):
        legs.append(Leg(at, at + count, kind))
        at += count + _REST
    instrument = load_instrument(None)
    rng = np.random.default_rng(5)
    q_deg = _readings(legs, np.arange(at) * 1e-3)
    light = _light(legs, q_deg, Kinematics(instrument.axes))
    entries = []
    events = [_event(0, output=pb.SetOutput(output=pb.OUTPUT_SHUTTER, on=False))]
    for number, leg in enumerate(legs):
        if not leg.kind:
            continue
        theta, phi = INCIDENT_DEG
        entry = {"path_id": number, "kind": leg.kind, "name": "mirror" if leg.kind == "peak" else leg.kind}
        entries.append(
            entry if leg.kind == "reference" else {**entry, "incident_theta_deg": theta, "incident_phi_deg": phi}
        )
        if leg.kind == "reference":
            events.append(_event(leg.first - 200, output=pb.SetOutput(output=pb.OUTPUT_SHUTTER, on=True)))
        events.append(_event(leg.first, path=pb.PathState(path_id=number, end=pb.PATH_RUNNING)))
        events.append(_event(leg.last - 1, path=pb.PathState(path_id=number, end=pb.PATH_FINISHED)))
    events.append(_event(legs[-1].first, output=pb.SetOutput(output=pb.OUTPUT_SHUTTER, on=False)))
    metadata = {
        "paths": entries,
        "unreachable": [],
        "instrument": instrument.text,
        "sample": {"name": f"{samples} samples", "front_faces": "exterior"},
        "beam": {"kind": "focused", "diameter_mm": 10.0, "divergence_deg": 1.0},
    }
    payloads = [(records.FRAME_EVENT, event.SerializeToString()) for event in events]
    payloads += [(records.FRAME_SAMPLES, block) for block in _sample_blocks(light, rng)]
    payloads += [(records.FRAME_POSES, block) for block in _pose_blocks(legs, at)]
    decoder = FrameDecoder()
    with RawLogWriter(path, metadata) as writer:
        for number, (kind, payload) in enumerate(payloads, 1):
            for frame in decoder.feed(encode_frame(kind, number, 0, payload)):
                writer.write(frame, BOOT_NS)


def _event(sample: int, **body: object) -> pb.Event:
    return pb.Event(time_ns=BOOT_NS + sample * 1_000_000, **body)  # type: ignore[arg-type]


def _readings(legs: list[Leg], t_s: FloatArray) -> FloatArray:
    """Readings (n, 4) at times (n,) in s from the first sample: spirals in arm angles about straight through and the
    mirror direction; circles to and fro at 30 degrees/s."""
    q = np.zeros((len(t_s), 4))
    for leg in legs:
        own = (t_s >= (leg.first - _REST // 2) * 1e-3) & (t_s < (leg.last + _REST // 2) * 1e-3)
        duration = (leg.last - leg.first) * 1e-3
        t = np.clip(t_s[own] - leg.first * 1e-3, 0.0, duration)
        share = t / duration
        if leg.kind == "coarse":
            sweep = t * _SPEED_DEG_S / _SWEEP_DEG
            within = sweep % 1.0
            swing = np.abs((sweep % 2.0) - 1.0) * _SWEEP_DEG - 0.5 * _SWEEP_DEG
            number = np.floor(sweep) + np.maximum(within - 1.0 + _STEP_SHARE, 0.0) / _STEP_SHARE
            elevation = -84.0 + 168.0 * number / np.floor(duration * _SPEED_DEG_S / _SWEEP_DEG)
            q[own] = np.stack((np.full(len(t), 30.0), 0.0 * t, swing, elevation), axis=1)
        elif leg.kind:
            radius, still, centre = (1.6, 0.0, 180.0) if leg.kind == "reference" else (6.0, 30.0, -60.0)
            turns = radius / (0.1 if leg.kind == "reference" else _peak_pitch_deg(leg, radius))
            azimuth = 2.0 * np.pi * turns * np.sqrt(share)
            polar = radius * np.sqrt(share)
            arm = np.stack((centre + polar * np.cos(azimuth), polar * np.sin(azimuth)), axis=1)
            q[own] = np.concatenate((np.tile([still, 0.0], (len(t), 1)), arm), axis=1)
    return q


def _peak_pitch_deg(leg: Leg, radius_deg: float) -> float:
    """So that the arm moves at about 5 degrees/s."""
    return float(np.pi * radius_deg**2 / (5e-3 * (leg.last - leg.first)))


def _light(legs: list[Leg], q_deg: FloatArray, kinematics: Kinematics) -> FloatArray:
    """Light (n,) in low-gain counts."""
    light = np.zeros(len(q_deg))
    for leg in legs:
        own = slice(leg.first, leg.last)
        if leg.kind == "reference":
            off = np.degrees(np.arccos(np.clip(-kinematics.detector_in_lab(q_deg[own])[:, 2], -1.0, 1.0)))
            light[own] = np.exp(-0.5 * (off / 0.35) ** 2) / (2.0 * np.pi * np.radians(0.35) ** 2)
        elif leg.kind:
            outgoing = kinematics.directions(q_deg[own])[1]
            mirror = np.array([-0.5, 0.0, np.sqrt(0.75)])
            light[own] = 0.3 / np.pi * np.maximum(outgoing[:, 2], 0.0)
            light[own] += 10.0 * np.exp((outgoing @ mirror - 1.0) / np.radians(1.3) ** 2) * (outgoing[:, 2] > 0.0)
    return POWER_COUNTS * light


def _sample_blocks(light: FloatArray, rng: np.random.Generator) -> list[bytes]:
    n = len(light)
    samples = np.zeros(n, records.SAMPLE_DTYPE)
    shown = light + np.sqrt(1e-3 * light) * rng.standard_normal(n)
    high = 1000.0 * shown + 350.0 + 8.0 * rng.standard_normal(n)
    samples["flags"] = np.where(high >= 8388607, records.SAMPLE_HIGH_SATURATED, 0)
    samples["high_counts"] = np.rint(np.minimum(high, 8388607))
    samples["low_counts"] = np.rint(shown + 12.0 + 0.5 * rng.standard_normal(n))
    samples["monitor_counts"] = np.rint(4e6 + 200.0 * rng.standard_normal(n))
    samples["temperature_centi_c"] = 2500
    block = np.zeros(1, records.SAMPLE_BLOCK_DTYPE)
    block["period_ns"], block["window"] = 1e6, 200
    blocks = []
    for number, first in enumerate(range(0, n, SAMPLES_PER_BLOCK)):
        own = samples[first : first + SAMPLES_PER_BLOCK]
        block["first_sample"], block["first_time_ns"] = first, BOOT_NS + first * 1_000_000
        block["block"], block["count"] = number, len(own)
        blocks.append(block.tobytes() + own.tobytes())
    return blocks


def _pose_blocks(legs: list[Leg], samples: int) -> list[bytes]:
    count = samples // 2 + 100
    time_ns = np.arange(count, dtype=np.int64) * 2_000_000
    q_deg = _readings(legs, time_ns * 1e-9)
    poses = np.zeros(count, records.POSE_DTYPE)
    poses["sync_time_ns"] = BOOT_NS + time_ns
    poses["sync_number"] = np.arange(1, count + 1)
    poses["valid"] = 0b1111
    for number, axis in enumerate(load_instrument(None).axes):
        poses["position_counts"][:, number] = np.rint(q_deg[:, number] * axis.counts_per_deg)
    header = np.zeros(1, records.POSE_BLOCK_DTYPE)
    blocks = []
    for number, first in enumerate(range(0, count, POSES_PER_BLOCK)):
        own = poses[first : first + POSES_PER_BLOCK]
        header["block"], header["count"], header["axis_count"] = number, len(own), 4
        blocks.append(header.tobytes() + own.tobytes())
    return blocks
