"""outcomes.py: what a test on a rig can come to, and how often each came: a broken rig is no failed test."""

from collections import Counter
from typing import Literal

Outcome = Literal["passed", "failed", "not run", "broken rig"]
OUTCOMES: tuple[Outcome, ...] = ("passed", "failed", "not run", "broken rig")


class BrokenRigError(Exception):
    """The rig did not do its part: nothing is said about what was to be tested."""


class Tally:
    """Counts tests by outcome; a test has one, however many phases pytest reports."""

    def __init__(self) -> None:
        self._outcome: dict[str, Outcome] = {}

    def add(self, test: str, outcome: Outcome) -> None:
        """The worst that was said of a test stays."""
        known = self._outcome.get(test)
        order = ("passed", "not run", "failed", "broken rig")
        if known is None or order.index(outcome) > order.index(known):
            self._outcome[test] = outcome

    def counts(self) -> dict[Outcome, int]:
        """All outcomes, zero included."""
        counted = Counter(self._outcome.values())
        return {outcome: counted[outcome] for outcome in OUTCOMES}

    def line(self, rig: str) -> str:
        """One line for the summary."""
        return f"rig {rig}: " + ", ".join(f"{count} {outcome}" for outcome, count in self.counts().items())
