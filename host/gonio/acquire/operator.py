"""operator.py: what a person does by hand during a scan: the prompt, and waiting for it while the link stays alive."""

import select
import sys
from collections.abc import Callable
from typing import Protocol

from gonio.plan.program import OperatorStep
from gonio.units.errors import UsageError


class Operator(Protocol):
    """Confirms that a step was done; `keep_alive` handles one frame of the link and is called while waiting."""

    def confirm(self, step: OperatorStep, keep_alive: Callable[[], None]) -> None: ...


class AssumedOperator:
    """Nothing to wait for: a twin mounts and removes its sample itself, or the user said --yes."""

    def confirm(self, step: OperatorStep, keep_alive: Callable[[], None]) -> None:
        """Return at once."""


class PromptingOperator:
    """Asks at the terminal and waits for Enter."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say

    def confirm(self, step: OperatorStep, keep_alive: Callable[[], None]) -> None:
        """Prompt and wait. Raises UsageError when the standard input ends without an answer."""
        self._say(f"{step.prompt} Then press Enter.")
        while not select.select([sys.stdin], [], [], 0.0)[0]:
            keep_alive()
        if not sys.stdin.readline():
            raise UsageError(f"nobody confirms “{step.prompt}”: run in a terminal, or with --yes")
