"""registry.py: scenarios by name: a function of steps, the wiring that it needs, whether it spoils the station."""

import importlib
import pkgutil
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from guest.station import Wiring

if TYPE_CHECKING:
    from guest.bench import Bench

Steps = Callable[["Bench"], None]


@dataclass(frozen=True)
class Scenario:
    """Steps that run in the guest; tests outside look at what they left in the results folder."""

    name: str
    steps: Steps
    wiring: Wiring
    spoils: bool  # the programs are started anew afterwards


_SCENARIOS: dict[str, Scenario] = {}


def scenario(can: str = "sim", twin: str = "twin.toml", spoils: bool = False) -> Callable[[Steps], Steps]:
    """Make a function a scenario of its own name."""

    def register(steps: Steps) -> Steps:
        name = steps.__name__
        if name in _SCENARIOS:
            raise ValueError(f"two scenarios are called {name}")
        _SCENARIOS[name] = Scenario(name, steps, Wiring(can, twin), spoils)
        return steps

    return register


def load_scenarios() -> list[Scenario]:
    """All scenarios, in the order of modules and of their definition."""
    package = importlib.import_module("scenarios")
    for module in sorted(info.name for info in pkgutil.iter_modules(package.__path__)):
        importlib.import_module(f"scenarios.{module}")
    return list(_SCENARIOS.values())
