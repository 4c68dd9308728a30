"""findings.py: what a reader, writer or validator has to say about a file: severity, code, place, message."""

from dataclasses import asdict, dataclass, field
from typing import Any, Literal

Severity = Literal["error", "warning", "note"]


@dataclass(frozen=True)
class Finding:
    severity: Severity
    code: str  # stable, for scripts
    where: str
    message: str

    def __str__(self) -> str:
        return f"{self.severity}: {self.where}: {self.message} [{self.code}]"


@dataclass
class Findings:
    """Findings about one file, in the order they were made."""

    source: str
    items: list[Finding] = field(default_factory=list)

    def add(self, severity: Severity, code: str, where: str, message: str) -> None:
        self.items.append(Finding(severity, code, where, message))

    def of(self, *severities: Severity) -> list[Finding]:
        return [item for item in self.items if item.severity in severities]

    @property
    def codes(self) -> set[str]:
        return {item.code for item in self.items}

    @property
    def exit_status(self) -> int:
        """0 good (notes allowed), 1 when there is an error or a warning."""
        return 1 if self.of("error", "warning") else 0

    def text(self) -> str:
        """One line per finding and a last line that counts them."""
        counts = ", ".join(f"{len(self.of(s))} {s}s" for s in ("error", "warning", "note"))
        return "\n".join([*(str(item) for item in self.items), f"{self.source}: {counts}"])

    def as_json(self) -> dict[str, Any]:
        """A plain object for --json."""
        return {
            "file": self.source,
            "exit_status": self.exit_status,
            "findings": [asdict(item) for item in self.items],
        }
