"""session.py: the boots of one test run, each when a test first asks for it."""

import json
import shutil
from collections.abc import Sequence
from pathlib import Path

from harness.outcomes import BrokenRigError
from harness.results import Result
from harness.rig import Rig
from kernel.build import KernelError, kernel_image
from vm.boot import BootError, Machine, boot, last_lines
from vm.initrd import InitrdError

HIL = Path(__file__).resolve().parents[1]
ROOT = HIL.parent
PROGRAMS = {"goniod": "firmware/app/goniod", "gonio-twin-devices": "sim/gonio-twin-devices"}
_START = """\
export PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/run TMPDIR=/run/tmp XDG_RUNTIME_DIR=/run/user LC_ALL=C.UTF-8
export PYTHONPATH={hil} PYTHONDONTWRITEBYTECODE=1 OPENBLAS_NUM_THREADS=1 GONIO_BIN={root}/.venv/bin/gonio
chmod 700 /run/user
cd {root} && exec {root}/.venv/bin/python -m guest.runner /run/results
"""


class SystemLane:
    """One boot for all scenarios that the selected tests want."""

    def __init__(self, rig: Rig, build: Path, results: Path, limit_s: float, wanted: Sequence[str]) -> None:
        self._rig = rig
        self._build = build
        self._results = results
        self._limit_s = limit_s
        self._wanted = sorted(set(wanted))
        self._broken: str | None = None
        self._booted = False

    def result(self, scenario: str) -> Result:
        """What a scenario left. Boots on the first call. Raises BrokenRigError."""
        if not self._booted:
            self._booted = True
            try:
                self._boot()
            except (BootError, KernelError, InitrdError) as error:
                self._broken = str(error)
        if self._broken is not None and not (self._results / scenario / "result.json").is_file():
            raise BrokenRigError(self._broken)
        return Result(self._results, scenario)

    def _boot(self) -> None:
        programs = {name: self._build / path for name, path in PROGRAMS.items()}
        for name, path in programs.items():
            if not path.is_file():
                raise BootError(f"{name} is not built: there is no {path}; run make build")
        shutil.rmtree(self._results, ignore_errors=True)
        self._results.mkdir(parents=True)
        job = {
            "root": str(ROOT),
            "programs": {name: str(path) for name, path in programs.items()},
            "rig": {"vm": self._rig.settings},
            "rig_folder": str(self._rig.folder),
            "scenarios": self._wanted,
        }
        (self._results / "job.json").write_text(json.dumps(job, indent=1))
        (self._results / "start.sh").write_text(_START.format(hil=HIL, root=ROOT))
        serial = boot(Machine(kernel_image(), "system", self._results, self._limit_s))
        broken = self._results / "broken.json"
        if broken.is_file():
            raise BootError(str(json.loads(broken.read_text())["text"]))
        if not (self._results / "done.json").is_file():
            raise BootError(f"the guest did not finish:\n{last_lines([serial])}")
