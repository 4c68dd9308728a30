"""station.py: firmware, twin and watcher as they are wired for a scenario; restarted only when the wiring changes."""

import signal
from dataclasses import dataclass
from pathlib import Path

from guest.gadgets import DIGITISER, LINK
from guest.interfaces import CAN_PAIRS, GpioChip, can_up, raise_softirqs, set_up_can, set_up_gpio
from guest.processes import Program, RigError
from guest.twin_control import TwinControl

CONTROL = Path("/run/twin.sock")
TWIN_PRIORITY = 40  # SCHED_FIFO, below goniod: drives keep their time, whatever else loads the machine
_INPUTS = ("strobe", "door", "emergency_stop", "sto", "limit")  # in the twin's order of lines
_OUTPUTS = ("shutter", "lamp", "watchdog")


@dataclass(frozen=True)
class Wiring:
    """What a scenario needs: a pair of CAN_PAIRS, and the twin's scenario file of the rig."""

    can: str = "sim"
    twin: str = "twin.toml"


class Station:
    """The programs of one wiring."""

    def __init__(self, programs: dict[str, Path], rig_folder: Path, logs: Path) -> None:
        self._programs = programs
        self._rig_folder = rig_folder
        self._logs = logs
        self._chip: GpioChip | None = None
        self._wiring: Wiring | None = None
        self._goniod: Program | None = None
        self._twin_program: Program | None = None
        self._control: TwinControl | None = None
        self.port = 0
        self.watchers: dict[str, Program] = {}

    def set_up(self) -> None:
        """The kernel's side, once; candump, an independent program, writes down every frame of every bus."""
        raise_softirqs()
        set_up_can()
        self._chip = set_up_gpio()
        for gadget in (LINK, DIGITISER):
            gadget.prepare()
        for name, pair in CAN_PAIRS.items():
            command = ["candump", "-L", f"{pair.twin},0:0,#FFFFFFFF"]
            self.watchers[name] = Program(f"candump-{name}", command, self._logs)

    @property
    def wiring(self) -> Wiring:
        if self._wiring is None:
            raise RigError("nothing is wired yet")
        return self._wiring

    @property
    def goniod(self) -> Program:
        if self._goniod is None:
            raise RigError("goniod was never started")
        return self._goniod

    @property
    def twin_program(self) -> Program:
        if self._twin_program is None:
            raise RigError("the twin was never started")
        return self._twin_program

    @property
    def twin(self) -> TwinControl:
        if self._control is None:
            raise RigError("the twin was never started")
        return self._control

    def programs(self) -> list[Program]:
        """All that were started and are still known."""
        known = [self._goniod, self._twin_program, *self.watchers.values()]
        return [program for program in known if program is not None]

    def wire(self, wiring: Wiring) -> None:
        """Bring the station to this wiring, with every fault undone."""
        if self._wiring != wiring or not self._twin_alive():
            self.end()
            self._wiring = wiring
            self._start_twin()
        if self._goniod is None or not self._goniod.alive():
            self.start_goniod()
        self.twin.clear()

    def start_goniod(self) -> None:
        """Start the firmware on the wiring's interface; plug its USB link in when it has written its descriptors."""
        config = self._logs / "goniod.conf"
        config.write_text(self.config())
        self._goniod = Program("goniod", [str(self._programs["goniod"]), "--config", str(config)], self._logs)
        self.port = int(self._goniod.wait_for_line("listening ").rpartition(":")[2])
        LINK.bind()

    def config(self) -> str:
        """goniod's settings file."""
        assert self._chip is not None
        lines = [f"can.interface = {CAN_PAIRS[self.wiring.can].firmware}"]
        lines += [f"input.{name} = {self._chip.device}:{offset}" for offset, name in enumerate(_INPUTS)]
        first = len(_INPUTS)
        lines += [f"output.{name} = {self._chip.device}:{first + offset}" for offset, name in enumerate(_OUTPUTS)]
        lines += [f"link.functionfs = {LINK.mount}", "link.tcp_port = 7411", "digitiser.usb_id = 1209:0002"]
        return "".join(f"{line}\n" for line in lines)

    def end(self) -> None:
        """A controlled end of firmware and twin."""
        if self._goniod is not None and self._goniod.alive():
            self._goniod.kill(signal.SIGTERM)
        if self._control is not None:
            self._control.close()
            self._control = None
        if self._twin_program is not None and self._twin_program.alive():
            self._twin_program.kill(signal.SIGTERM)

    def end_watchers(self) -> None:
        for watcher in self.watchers.values():
            watcher.kill(signal.SIGTERM)

    def _twin_alive(self) -> bool:
        return self._twin_program is not None and self._twin_program.alive()

    def _start_twin(self) -> None:
        assert self._chip is not None
        if self.wiring.can != "vcan":
            can_up_again(self.wiring.can)
        CONTROL.unlink(missing_ok=True)
        command = [str(self._programs["gonio-twin-devices"]), str(self._rig_folder / self.wiring.twin)]
        command += ["--can", CAN_PAIRS[self.wiring.can].twin, "--gpio-sim", str(self._chip.folder)]
        command += ["--digitiser", str(DIGITISER.mount), "--control", str(CONTROL)]
        command += ["--journal", str(self._logs / f"journal-{self.wiring.twin}.json")]
        self._twin_program = Program("twin", command, self._logs, TWIN_PRIORITY)
        self._twin_program.wait_for_line("serving")
        DIGITISER.bind()
        self._control = TwinControl(CONTROL)


def can_up_again(name: str) -> None:
    """Both sides of a pair up, also after a scenario that took one down."""
    for interface in (CAN_PAIRS[name].firmware, CAN_PAIRS[name].twin):
        state = Path(f"/sys/class/net/{interface}/flags").read_text().strip()
        if not int(state, 16) & 1:
            can_up(interface)
