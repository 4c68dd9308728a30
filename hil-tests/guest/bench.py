"""bench.py: what a scenario's steps may do: gonio commands, faults, waiting; everything is recorded as it happens."""

import json
import shutil
import signal
import time
import tomllib
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from guest.gonio_command import Ended, GonioCommand
from guest.processes import wait_until
from guest.station import Station
from guest.twin_control import TwinControl

STEP_LIMIT_S = 90.0  # of one gonio command; generous: emulation may be ten times slower than it is
STATE_LIMIT_S = 30.0  # of a condition on the twin's state
MOVING_DEG_PER_S = 3.0


class Bench:
    """The steps' hands. `folder` keeps what the scenario leaves; `values` goes into its result."""

    def __init__(self, station: Station, rig: dict[str, Any], rig_folder: Path, folder: Path) -> None:
        self.station = station
        self.rig = rig
        self.rig_folder = rig_folder
        self.folder = folder
        self.values: dict[str, Any] = {}
        self.commands: list[dict[str, Any]] = []
        self.states: dict[str, dict[str, Any]] = {}
        self._started: list[tuple[str, GonioCommand]] = []

    @property
    def twin(self) -> TwinControl:
        return self.station.twin

    @property
    def tcp(self) -> str:
        """The device name of the loopback link."""
        return f"tcp://127.0.0.1:{self.station.port}"

    @property
    def usb(self) -> str:
        """The device name of the USB link."""
        return "usb:"

    @property
    def instrument(self) -> Path:
        """The instrument file that the wired twin's scenario names: both sides read the same."""
        scenario = self.rig_folder / self.station.wiring.twin
        return scenario.parent / str(tomllib.loads(scenario.read_text())["instrument"])

    def plan(self, name: str) -> Path:
        """A plan of the rig."""
        return self.rig_folder / name

    def start(
        self, name: str, *arguments: str | Path, device: str | None = None, instrument: Path | None = None
    ) -> GonioCommand:
        """Begin `gonio ARGUMENTS --device ...`; `name` names its outputs."""
        words = [*map(str, arguments), "--device", device or self.tcp]
        if arguments[0] in ("scan", "home"):
            words += ["--instrument", str(instrument or self.instrument)]
        command = GonioCommand(words, self.folder / name)
        self._started.append((name, command))
        return command

    def end(self, command: GonioCommand, limit_s: float = STEP_LIMIT_S) -> Ended:
        """Wait for a command and record it."""
        ended = command.wait(limit_s, lambda: self.operate(command))
        name = next(name for name, started in self._started if started is command)
        self.commands.append({"name": name} | asdict(ended))
        return ended

    def operate(self, command: GonioCommand) -> None:
        """Be the person beside the instrument: do what the command prompts for, then press Enter."""
        prompt = command.prompt() if command.running() else None
        if prompt is not None:
            self.twin.ask("mount off" if prompt.startswith("Take") else "mount on")
            command.answer()

    def gonio(
        self, name: str, *arguments: str | Path, limit_s: float = STEP_LIMIT_S, device: str | None = None
    ) -> Ended:
        """A whole command."""
        return self.end(self.start(name, *arguments, device=device), limit_s)

    def scan(
        self, plan: str, raw: str = "raw.mcap", device: str | None = None, instrument: Path | None = None
    ) -> GonioCommand:
        """Begin a scan into this scenario's folder."""
        arguments = ("scan", self.plan(plan), "-o", self.folder / raw)
        return self.start(raw.removesuffix(".mcap"), *arguments, device=device, instrument=instrument)

    def state(self, label: str) -> dict[str, Any]:
        """The twin's state now, recorded under a label."""
        self.states[label] = self.twin.state()
        return self.states[label]

    def until(
        self, what: str, condition: Callable[[dict[str, Any]], bool], limit_s: float = STATE_LIMIT_S
    ) -> dict[str, Any]:
        """The twin's state when a condition on it came true, recorded under `what`. Raises NeverCameError."""
        latest: dict[str, Any] = {}

        def holds() -> bool:
            latest.clear()
            latest.update(self.twin.state())
            self.states[what] = dict(latest)
            return condition(latest)

        began = time.monotonic()
        wait_until(what, holds, limit_s)
        self.states[what]["after_s"] = time.monotonic() - began
        return self.states[what]

    def until_measuring(
        self, command: GonioCommand, degrees: float = 3.0, least_deg_per_s: float = MOVING_DEG_PER_S
    ) -> dict[str, Any]:
        """Wait until the shutter is open and the arm has flown `degrees` in this state; ends early with the command."""
        begun: list[list[float]] = []

        def measuring(state: dict[str, Any]) -> bool:
            if not command.running():
                return True  # its status and words say why
            self.operate(command)
            moving = state["shutter_open"] and max(map(abs, state["speed_deg_per_s"])) > least_deg_per_s
            if not moving:
                begun.clear()
                return False
            begun.append(state["position_deg"])
            return max(abs(a - b) for a, b in zip(begun[0], begun[-1], strict=True)) > degrees

        return self.until("measuring", measuring, STEP_LIMIT_S)

    def until_safe(self) -> dict[str, Any]:
        """Wait until everything stands and is dark."""
        return self.until("safe", lambda state: state["at_rest"] and not state["shutter_open"])

    def keep(self, *files: Path) -> None:
        """Copy files into the scenario's folder."""
        for path in files:
            shutil.copy(path, self.folder)

    def finish(self) -> None:
        """No command outlives its scenario."""
        for name, command in self._started:
            if command.running():
                command.send(signal.SIGKILL)
                self.values.setdefault("left_running", []).append(name)
                while command.running():
                    time.sleep(0.01)

    def result(self) -> dict[str, Any]:
        """What goes into result.json."""
        return {"values": self.values, "commands": self.commands, "states": self.states}


def write_json(path: Path, content: Any) -> None:
    """Whole or not at all: the machine may die meanwhile."""
    partial = path.with_suffix(".partial")
    partial.write_text(json.dumps(content, indent=1, default=_plain))
    partial.rename(path)


def _plain(value: object) -> object:
    if isinstance(value, Sequence):
        return list(value)
    return str(value)
