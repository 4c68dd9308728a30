"""scan_until.py KIND SECONDS ACTION ARGUMENTS...: runs gonio ARGUMENTS until something happens to it.

When a path of KIND has been flown for SECONDS (link time, so the moment is the same on any machine), ACTION comes: a
signal by its name, sent to this process, or "stop": gonio stop from another process. All else is the real command.
"""

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

from gonio.acquire.runner import Runner
from gonio.cli import main
from gonio.plan.program import PathStep
from gonio.protocol.generated import gonio_pb2 as pb

HOLD_S = 0.05  # per frame, until the stopping process has its answer


class Trigger:
    """Watches the runner from outside: the path under way, and how far it is."""

    def __init__(self, kind: str, path_time_s: float, action: str) -> None:
        self.kind = kind
        self.path_time_ns = path_time_s * 1e9
        self.action = action
        self.step: PathStep | None = None
        self.pulled = False
        self.stopper: subprocess.Popen[str] | None = None

    def see(self, event: pb.Event) -> None:
        """Act once, at the first Status that is far enough."""
        if self.stopper:
            try:
                self.stopper.wait(HOLD_S)
            except subprocess.TimeoutExpired:
                return
            self.stopper = None
        if self.pulled or self.step is None or self.step.kind != self.kind:
            return
        status = event.status
        if status.path_id == self.step.path_id and status.path_time_ns >= self.path_time_ns:
            self.pulled = True
            self._act()

    def _act(self) -> None:
        if self.action == "stop":
            self.stopper = subprocess.Popen([sys.executable, "-m", "gonio.cli.main", "stop"], text=True)
            return
        children = Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()
        print(*children, flush=True)  # noqa: T201 - who is to be waited for when we are gone
        os.kill(os.getpid(), signal.Signals[self.action])


def install(trigger: Trigger) -> None:
    """Put the trigger beside the runner's own reading of events."""
    fly, take_event = Runner._fly, Runner.take_event

    def seen_fly(runner: Runner, step: PathStep) -> None:
        trigger.step = step
        fly(runner, step)

    def seen_event(runner: Runner, event: pb.Event) -> None:
        take_event(runner, event)
        trigger.see(event)

    replaced: Any = Runner
    replaced._fly, replaced.take_event = seen_fly, seen_event


if __name__ == "__main__":
    install(Trigger(sys.argv[1], float(sys.argv[2]), sys.argv[3]))
    sys.exit(main.run(sys.argv[4:]))
