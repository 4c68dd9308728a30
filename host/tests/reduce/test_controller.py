"""test_controller.py: what a raw log tells of its controller, and what the uncertainty of its stamps becomes."""

import struct
from pathlib import Path

import numpy as np
import pytest
from small_log import METADATA, pose_payload

from gonio.protocol.frames import FrameDecoder, encode_frame
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.protocol.generated import records
from gonio.rawlog.reader import read_rawlog
from gonio.rawlog.segments import segment_path
from gonio.rawlog.writer import RawLogWriter
from gonio.reduce.samples.controller import controller_facts, late_at_most_us
from gonio.reduce.samples.pairing import time_u_us
from gonio.units.instrument import load_instrument

REFERENCE = load_instrument(None)
KERNEL = "Linux 6.1.0-rt aarch64"


def event(**body: object) -> tuple[int, bytes]:
    return records.FRAME_EVENT, pb.Event(time_ns=1, **body).SerializeToString()


def info(*, realtime: bool = True, kernel: str = KERNEL, notes: str = "") -> tuple[int, bytes]:
    said = pb.Info(kernel=kernel, realtime=realtime, nodes=[pb.NodeInfo(node=1), pb.NodeInfo(node=3, notes=notes)])
    return records.FRAME_REPLY, pb.Reply(id=9, info=said).SerializeToString()


def poses(block: int, sigma_us: float, *, count: int = 3) -> tuple[int, bytes]:
    """A block of poses; its header's last field is the uncertainty."""
    payload = bytearray(pose_payload(block, count=count))
    struct.pack_into("<f", payload, 12, sigma_us)
    return records.FRAME_POSES, bytes(payload)


def latency(thread: pb.Thread, wakeups: int, max_us: int, bins: list[int]) -> tuple[int, bytes]:
    return event(latency=pb.Latency(thread=thread, wakeups=wakeups, max_us=max_us, bins=bins))


def write(path: Path, *payloads: tuple[int, bytes]) -> Path:
    with RawLogWriter(path, METADATA) as writer:
        raw = b"".join(encode_frame(kind, n, 0, payload) for n, (kind, payload) in enumerate(payloads, 1))
        for frame in FrameDecoder().feed(raw):
            writer.write(frame, 1)
    return path


def test_kernel_notes_latency_and_stamps_of_two_segments(tmp_path: Path) -> None:
    first = write(
        tmp_path / "raw.mcap",
        info(),  # before boot: nothing is known of the drives
        info(notes="no 0x6007"),
        latency(pb.THREAD_MOTION, 100, 900, [10, 80, 10]),  # before the scan: not part of it
        latency(pb.THREAD_MOTION, 1100, 900, [10, 1079, 11]),
        latency(pb.THREAD_STREAM, 50, 7, [0, 0, 20, 30]),
        poses(0, 3.0),
    )
    second = write(
        segment_path(first, 2),
        info(realtime=False),
        latency(pb.THREAD_MOTION, 2000, 40, [0, 2000]),
        latency(pb.THREAD_MOTION, 2005, 40, [0, 2004, 0, 1]),
        poses(0, 4.0),
    )
    log = read_rawlog([first, second])
    np.testing.assert_array_equal(log.pose_sigma_us, [3.0] * 3 + [4.0] * 3)
    facts = controller_facts(log, REFERENCE)
    assert facts["kernel"] == KERNEL
    assert facts["realtime"] is False
    assert facts["notes"] == {"node 3": "no 0x6007"}
    assert facts["latency"]["motion"] == {"wakeups": 1005, "max_us": 900, "bins": [0, 1003, 1, 1]}
    assert facts["latency"]["stream"] == {"wakeups": 50, "max_us": 7, "bins": [0, 0, 20, 30]}
    # Latch delay 1 us (the instrument's file), stamps 3 us and 4 us as often: sqrt(1 + 12.5).
    assert facts["position_time_u_us"]["arm elevation"] == pytest.approx(np.sqrt(13.5))


def test_a_twin_in_virtual_time_tells_nothing(tmp_path: Path) -> None:
    log = read_rawlog([write(tmp_path / "raw.mcap", info(kernel="", realtime=False), poses(0, 0.0))])
    assert controller_facts(log, REFERENCE) == {}
    assert controller_facts(read_rawlog([write(tmp_path / "empty.mcap")]), REFERENCE) == {}


def test_999_of_1000_wakeups() -> None:
    """Bins double: less than 1, 2, 4, 8 us ...; the last of the thousand may be as late as it likes."""
    assert late_at_most_us({"bins": [0, 0, 0, 999, 0, 0, 0, 1], "max_us": 100}, 0.999) == 8.0
    assert late_at_most_us({"bins": [0, 0, 0, 998, 0, 0, 0, 2], "max_us": 100}, 0.999) == 100.0
    assert late_at_most_us({"bins": [1000], "max_us": 0}, 0.999) == 0.0


def test_uncertainties_add_in_quadrature() -> None:
    axis = REFERENCE.axes[0]
    assert axis.latch_delay_u_us == 1.0
    assert time_u_us(axis, np.zeros(5, np.float32)) == 1.0
    assert time_u_us(axis, np.full(5, np.sqrt(3.0), np.float32)) == pytest.approx(2.0)
    assert time_u_us(axis, np.array([np.nan, 0.0], np.float32)) == 1.0
    assert time_u_us(axis, np.zeros(0, np.float32)) == 1.0
