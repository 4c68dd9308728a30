"""rig.py: a rig file says what the scenarios run on: the virtual machine, or a real instrument on a bench."""

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NoReturn

_USB_DEVICES = Path("/sys/bus/usb/devices")
_VM_KEYS: dict[str, type] = {
    "instrument": str,
    "system_limit_s": float,
    "timing_limit_s": float,
    "timing_samples": int,
    "soak_limit_s": float,
    "soak_scans": int,
}
_BENCH_KEYS: dict[str, type] = {"serial": str, "instrument": str, "watcher": str, "operator": str}


class RigFileError(Exception):
    """The rig file cannot be used: one line, what and where."""


@dataclass(frozen=True)
class Rig:
    """A rig file. `settings` is its [vm] or [bench] table; names of files in it are relative to `folder`."""

    path: Path
    name: str
    kind: Literal["vm", "bench"]
    settings: dict[str, Any]

    @property
    def folder(self) -> Path:
        return self.path.parent

    def file(self, key: str) -> Path:
        """A file that the rig names."""
        return self.folder / str(self.settings[key])

    def absent(self, usb_devices: Path = _USB_DEVICES) -> str | None:
        """Why the rig is not there, or None. The virtual machine always is: what it lacks makes it a broken rig."""
        if self.kind == "vm":
            return None
        serial = str(self.settings["serial"])
        for path in sorted(usb_devices.glob("*/serial")):
            if path.read_text(errors="replace").strip() == serial:
                return None
        return f"no such rig: no controller with serial {serial} on USB ({self.path.name})"


def load_rig(path: Path) -> Rig:
    """Read a rig file. Raises RigFileError."""

    def refuse(what: str) -> NoReturn:
        raise RigFileError(f"{path}: {what}")

    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        refuse(f"cannot be read ({error})")
    head = document.pop("rig", None)
    if not isinstance(head, dict) or set(head) != {"name", "kind"} or not isinstance(head["name"], str):
        refuse("[rig] must hold name and kind, nothing else")
    kind = head["kind"]
    if kind not in ("vm", "bench"):
        refuse(f'rig.kind is "{kind}": write "vm" or "bench"')
    if set(document) != {kind}:
        refuse(f"beside [rig] there must be [{kind}], nothing else")
    settings, keys = document[kind], _VM_KEYS if kind == "vm" else _BENCH_KEYS
    for key in settings:
        if key not in keys:
            refuse(f"{kind}.{key}: nobody knows this key; known are {', '.join(keys)}")
    for key, wanted in keys.items():
        if key not in settings:
            refuse(f"{kind}.{key} is missing")
        if not isinstance(settings[key], wanted):
            refuse(f"{kind}.{key} must be of type {wanted.__name__}")
    rig = Rig(path, head["name"], kind, settings)
    if not rig.file("instrument").is_file():
        refuse(f"{kind}.instrument: there is no file {rig.file('instrument')}")
    return rig
