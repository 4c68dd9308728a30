"""findings.py: what a check says, in three grades."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum


class Grade(StrEnum):
    """How bad it is."""

    WRONG = "wrong"  # the firmware will refuse the drive, or the instrument would err
    FALLBACK = "fallback"  # the firmware works without it
    NOTE = "note"


@dataclass(frozen=True)
class Finding:
    """One sentence: what is found, and what to do or what follows."""

    grade: Grade
    where: str  # "node 3 (arm azimuth)" or "bus"
    object: str  # "0x6007", or empty
    sentence: str

    @property
    def line(self) -> str:
        """For the terminal."""
        return f"{self.grade}: {self.where}: {self.object + ': ' if self.object else ''}{self.sentence}"


def any_wrong(findings: Iterable[Finding]) -> bool:
    """Whether the command's exit status is 1."""
    return any(finding.grade is Grade.WRONG for finding in findings)
