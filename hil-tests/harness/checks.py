"""checks.py: what every fault must end in: one sentence, status 3, rest, dark, a readable log, recovery."""

import tomllib
from pathlib import Path

import numpy as np
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.rawlog.reader import RawLog, read_rawlog

from harness.results import Command, Result

INSTRUMENT_FAULT = 3  # exit status
AXES = 4
REST_DEG_PER_S = 0.05
CLOCK_TOLERANCE = 0.0011  # what the firmware takes for a crystal, and rounding


def raw_log(path: Path) -> RawLog:
    """A raw log that must be readable and undamaged, whole or not."""
    log = read_rawlog([path])
    assert not log.damaged, log.problem
    return log


def complaints(command: Command) -> list[str]:
    """What the command complained of: remarks before the scan begins are none."""
    return [line for line in command.stderr.splitlines() if line.startswith("gonio: ")]


def assert_fault_sentence(command: Command, *words: str) -> str:
    """Status 3 and one line that says what happened; the line."""
    assert command.status == INSTRUMENT_FAULT, command.stderr
    told = complaints(command)
    assert len(told) == 1, command.stderr
    for word in words:
        assert word.lower() in told[0].lower(), told[0]
    return told[0]


def assert_safe(result: Result) -> None:
    """The arm stands and it is dark, by the twin's own account."""
    state = result.state("safe")
    assert state["at_rest"]
    assert not state["shutter_open"]
    assert max(map(abs, state["speed_deg_per_s"])) < REST_DEG_PER_S


def assert_fault_in_log(path: Path, sentence: str) -> None:
    """The raw log holds the fault that the user was told."""
    faults = [event.fault for event in raw_log(path).events if event.HasField("fault")]
    assert faults, "no fault in the raw log"
    assert any(fault.sentence in sentence for fault in faults)


def assert_recovered(result: Result) -> None:
    """The next command found every position again, and they are true."""
    home = result.command("recovery")
    assert home.status == 0, home.stderr
    told = [float(line.rpartition(": ")[2].removesuffix(" deg")) for line in home.stdout.splitlines()]
    truth = result.state("recovered")["position_deg"]
    assert len(told) == AXES
    assert all(abs(a - b) < 0.01 for a, b in zip(told, truth, strict=True)), (told, truth)


def assert_fault_end(result: Result, *words: str) -> None:
    """The whole required end state of a fault in mid-scan."""
    sentence = assert_fault_sentence(result.command("raw"), *words)
    assert_safe(result)
    assert_fault_in_log(result.raw(), sentence)
    assert_recovered(result)


def counters(log: RawLog) -> pb.Counters:
    """The firmware's last count of what went wrong, since its start."""
    return [event.counters for event in log.events if event.HasField("counters")][-1]


def assert_whole(path: Path) -> None:
    """A whole log: every frame of the link, every sample."""
    log = raw_log(path)
    assert log.problem is None
    assert log.segments[0].link_gap_frames == 0
    assert np.all(np.diff(log.sample_number.astype(np.int64)) == 1)


def assert_nothing_lost(path: Path) -> None:
    """A whole log, and no frame of the bus left unread."""
    assert_whole(path)
    assert counters(raw_log(path)).can_overflow == 0


def assert_sample_clock(log: RawLog) -> None:
    """Every fitted sample period is the instrument's, whatever the strobes' stamps suffered. (While the emulation
    stands still the strobes' numbers may slip; double-width pulses mend that, and `strobe_realigned` counts it.)"""
    blocks = log.sample_blocks
    fitted_us = 1e-3 * blocks["period_ns"][blocks["window"] > 0]
    nominal_us = tomllib.loads(log.metadata["instrument"])["cycle"]["sample_period_us"]
    assert len(fitted_us) > 0
    assert np.abs(fitted_us / nominal_us - 1.0).max() < CLOCK_TOLERANCE
