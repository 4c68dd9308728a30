"""scheme.py: the ways to interpolate between incident directions that leave-one-out chooses from."""

from dataclasses import dataclass
from typing import Literal

from gonio.model.hemisphere import Follows
from gonio.units.errors import UsageError

Curve = Literal["linear", "pchip"]


@dataclass(frozen=True)
class Scheme:
    """lobes: peaks are matched and moved, else all is one grid. background: what the grids follow. curve: of the lobes'
    parameters along theta; pchip (monotone cubic, Fritsch and Carlson 1980) only on a line of directions. rest: what
    most directions have in common (diffuse light) rests, and only the remainder (tails of peaks) follows."""

    lobes: bool
    background: Follows
    curve: Curve = "linear"
    rest: bool = False

    @property
    def name(self) -> str:
        """As --method takes it."""
        if not self.lobes:
            return f"blend-{self.background}"
        tail = "-rest" if self.rest else "-pchip" if self.curve == "pchip" else ""
        return f"lobes-{self.background}{tail}"


_FOLLOWS: tuple[Follows, ...] = ("fixed", "opposite", "same")
# The simplest first: of equals it is taken. A lobe's own offset keeps peaks in place, so the ground may rest.
SCHEMES = (
    Scheme(True, "fixed"),
    *(Scheme(True, follows, rest=True) for follows in _FOLLOWS[1:]),
    *(Scheme(True, follows) for follows in _FOLLOWS[1:]),
    *(Scheme(True, follows, "pchip") for follows in _FOLLOWS),
    *(Scheme(False, follows) for follows in _FOLLOWS),
)
METHODS = ("auto", *(scheme.name for scheme in SCHEMES))


def named(method: str) -> Scheme:
    """The scheme of this name. UsageError for another."""
    for scheme in SCHEMES:
        if scheme.name == method:
            return scheme
    raise UsageError(f"--method {method}: not one of {', '.join(METHODS)}")
