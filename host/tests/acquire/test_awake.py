"""test_awake.py: holding off sleep, sleep that came all the same, and a host clock that is stepped."""

import os
import shutil
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from fake_firmware import FakeFirmware
from tiny_scan import run_tiny_scan, with_data

from gonio.acquire import awake
from gonio.acquire.awake import SleepWatch, kept_awake
from gonio.rawlog.segment_reader import read_segment
from gonio.units.errors import InstrumentFault

SECOND = 1_000_000_000
INHIBIT = """#!/bin/sh
while [ "${1#--}" != "$1" ]; do echo "$1" >> "$LOG"; shift; done
echo begin >> "$LOG"
"$@"
echo end >> "$LOG"
"""


class Clocks:
    """The two clocks, with sleep and with moments in which the reader was held up between them."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now_ns, self.slept_ns, self.held_up_ns = 50 * SECOND, 7 * SECOND, 0
        monkeypatch.setattr(time, "clock_gettime_ns", self.read)

    def read(self, clock: int) -> int:
        self.now_ns += 1000 + self.held_up_ns
        return self.now_ns + (self.slept_ns if clock == time.CLOCK_BOOTTIME else 0)


def test_sleep_is_noticed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    clocks = Clocks(monkeypatch)
    watch = SleepWatch()
    clocks.now_ns += 3600 * SECOND
    watch.check()
    clocks.slept_ns += 12 * SECOND
    with pytest.raises(InstrumentFault, match=r"asleep for 12\.0 s.*--resume"):
        watch.check()
    watch.check()
    clocks.slept_ns += 5 * SECOND
    with pytest.raises(InstrumentFault, match=r"asleep for 5\.0 s"):
        watch.check()


@pytest.mark.parametrize(("at_start_ns", "later_ns"), [(0, 3 * SECOND), (3 * SECOND, 0), (SECOND, 2 * SECOND)])
def test_a_busy_machine_is_not_a_sleeping_one(monkeypatch: pytest.MonkeyPatch, at_start_ns: int, later_ns: int) -> None:
    """Seconds may pass between the two readings: no false alarm."""
    clocks = Clocks(monkeypatch)
    clocks.held_up_ns = at_start_ns
    watch = SleepWatch()
    clocks.held_up_ns = later_ns
    watch.check()


def test_a_machine_without_the_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(time, "CLOCK_BOOTTIME")
    SleepWatch().check()


def put_program(folder: Path, text: str, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The only systemd-inhibit there is; its log."""
    program, log = folder / "systemd-inhibit", folder / "log"
    program.write_text(text)
    program.chmod(0o755)
    monkeypatch.setenv("LOG", str(log))
    monkeypatch.setattr(awake, "ANSWER_TIMEOUT_S", 60.0)  # however busy the machine is
    monkeypatch.setattr(shutil, "which", lambda name: str(program) if name == program.name else None)
    return log


def test_the_lock_is_held_for_the_scan_and_no_longer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = put_program(tmp_path, INHIBIT, monkeypatch)
    said: list[str] = []
    with kept_awake(said.append):
        held = log.read_text().split("\n")
        assert "--what=sleep:idle" in held
        assert held[-2:] == ["begin", ""]
    assert log.read_text().endswith("begin\nend\n")
    assert said == []


def test_the_lock_ends_with_a_killed_scan(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its standard input is our pipe: the kernel closes it, whatever happened to us."""
    log = put_program(tmp_path, INHIBIT, monkeypatch)
    child = awake._inhibitor()
    assert child
    assert child.stdin
    os.close(child.stdin.fileno())
    assert child.wait(20.0) == 0
    assert log.read_text().endswith("end\n")
    child.stdin = None
    assert child.stdout
    child.stdout.close()


@pytest.mark.parametrize("text", [None, "#!/bin/sh\nexit 1\n", "#!/bin/sh\necho other words\ncat\n"])
def test_where_nothing_holds_off_sleep_it_is_said_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str | None
) -> None:
    """No such program; one that finds no login manager."""
    if text is None:
        monkeypatch.setattr(shutil, "which", lambda _name: None)
    else:
        put_program(tmp_path, text, monkeypatch)
    said: list[str] = []
    with kept_awake(said.append):
        assert len(said) == 1
    assert "sleep" in said[0]
    assert len(said) == 1


Device = Callable[..., tuple[FakeFirmware, str]]


def test_sleep_in_a_scan_ends_it_like_an_unplugged_cable(
    device: Device, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clocks = Clocks(monkeypatch)

    def sleep(fake: FakeFirmware, tick: int) -> None:
        with_data(fake, tick)
        if fake.knots_received >= 60:
            clocks.slept_ns = 67 * SECOND

    fake, name = device(on_tick=sleep)
    with pytest.raises(InstrumentFault, match=r"asleep for 60\.0 s"):
        run_tiny_scan(tmp_path, name)
    assert [r.stop.reason for r in fake.requests if r.HasField("stop")] == ["the scan failed"]
    assert not read_segment(tmp_path / "raw.mcap").damaged


def test_steps_of_the_hosts_clock_change_nothing(
    device: Device, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The wall clock jumps by a day, to and fro, at every look: the scan is whole, no time-out comes early or late."""
    steps = iter(range(10**9))
    real_s = time.time()
    monkeypatch.setattr(time, "time", lambda: real_s + (86_400.0 if next(steps) % 2 else -86_400.0))
    fake, name = device(on_tick=with_data)
    segment = read_segment(run_tiny_scan(tmp_path, name))
    assert segment.complete
    assert fake.broken == []
    assert [e.path.path_id for e in segment.events if e.HasField("path")] == [1, 2]
