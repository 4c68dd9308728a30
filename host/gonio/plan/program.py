"""program.py: what a compiled plan is: steps that acquire runs one after the other, checked before anything moves."""

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from gonio.units.instrument import Instrument

PathKind = Literal["move", "reference", "coarse", "peak"]


@dataclass(frozen=True)
class OperatorStep:
    """Something done by hand: prompt, wait for confirmation, tell the firmware (it goes into the raw log)."""

    action: Literal["sample_removed", "sample_mounted"]
    prompt: str


@dataclass(frozen=True)
class ShutterStep:
    open: bool


@dataclass(frozen=True)
class DarkStep:
    """Stand still with the shutter closed and record for so long (link time)."""

    duration_s: float


@dataclass(frozen=True)
class PathStep:
    """One path from rest to rest. Knots in axis counts, dtype protocol KNOT_DTYPE, shape (n,)."""

    path_id: int  # unique in the program, from 1
    kind: PathKind
    name: str  # for progress and the report, e.g. "coarse 30/0"
    knots: NDArray[np.void]
    incident_theta_deg: float | None = None  # None for moves and the reference
    incident_phi_deg: float | None = None

    @property
    def duration_s(self) -> float:
        return float(self.knots["time_ns"][-1]) * 1e-9


Step = OperatorStep | ShutterStep | DarkStep | PathStep


@dataclass(frozen=True)
class UnreachableDirection:
    """A planned direction that no allowed axis position reaches; it becomes a masked point."""

    incident_theta_deg: float
    incident_phi_deg: float
    theta_deg: float
    phi_deg: float
    reason: str  # the limit or zone, in words


@dataclass
class Program:
    steps: list[Step]
    unreachable: list[UnreachableDirection] = field(default_factory=list)
    # Plain JSON: the plan's own text and settings, sample data (name, front_faces, symmetry, thickness, manufacturer),
    # beam shape and head size for shading; goes into the raw log's metadata as it is.
    metadata: dict[str, Any] = field(default_factory=dict)
    instrument: Instrument | None = None  # for which it was compiled; resume plans new moves with it

    @property
    def duration_s(self) -> float:
        return sum(s.duration_s for s in self.steps if isinstance(s, PathStep | DarkStep))
