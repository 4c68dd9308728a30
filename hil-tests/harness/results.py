"""results.py: what a scenario left in the results folder, as the tests read it."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from harness.outcomes import BrokenRigError


class ScenarioFailedError(AssertionError):
    """The scenario's own steps failed: something never came true in the guest."""


@dataclass(frozen=True)
class Command:
    """One gonio command as the user would have seen it."""

    argv: tuple[str, ...]
    status: int
    seconds: float
    stdout: str
    stderr: str


class Result:
    """One scenario's folder."""

    def __init__(self, session: Path, name: str) -> None:
        self.session = session
        self.folder = session / name
        self.name = name
        path = self.folder / "result.json"
        if not path.is_file():
            raise BrokenRigError(f"{name}: the virtual machine left no result")
        self._content: dict[str, Any] = json.loads(path.read_text())

    def require_steps(self) -> None:
        """Raises what became of the steps: ScenarioFailedError or BrokenRigError; returns if all were gone through."""
        error = self._content["error"]
        if error is None:
            return
        text = f"{self.name}: {error['text']}"
        if error["kind"] == "broken rig":
            raise BrokenRigError(text)
        raise ScenarioFailedError(f"{text}\n{self.said()}")

    def said(self) -> str:
        """What the commands said, for a failed test's reader."""
        parts = []
        for command in self._content["commands"]:
            parts.append(f"$ {' '.join(command['argv'])}  -> {command['status']}, {command['seconds']:.1f} s")
            parts += [text for key in ("stdout", "stderr") if (text := command[key].strip())]
        return "\n".join(parts)

    def command(self, name: str) -> Command:
        """A recorded command by the name that the steps gave it."""
        for recorded in self._content["commands"]:
            if recorded["name"] == name:
                return Command(
                    tuple(recorded["argv"]),
                    recorded["status"],
                    recorded["seconds"],
                    recorded["stdout"],
                    recorded["stderr"],
                )
        raise BrokenRigError(f"{self.name}: no command {name} was recorded")

    def state(self, label: str) -> dict[str, Any]:
        """The twin's state that the steps recorded under this label."""
        state: dict[str, Any] = self._content["states"][label]
        return state

    @property
    def values(self) -> dict[str, Any]:
        values: dict[str, Any] = self._content["values"]
        return values

    @property
    def goniod_log(self) -> str:
        """All that this start of the firmware wrote to its standard error."""
        return (self.session / str(self._content["goniod_log"])).read_text(errors="replace")

    def raw(self, name: str = "raw.mcap") -> Path:
        """A raw log that the scenario wrote."""
        return self.folder / name
