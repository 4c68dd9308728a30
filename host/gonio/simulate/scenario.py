"""scenario.py: the parts of a scenario file that the closed-form truth needs: sample, beam, instrument."""

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gonio.units.errors import UsageError
from gonio.units.instrument import Instrument, load_instrument

# Keys of each kind of component beside `kind`; the twin refuses the same others.
COMPONENT_KEYS = {
    "lambertian": {"reflectance", "transmittance"},
    "gaussian": {"about", "sigma_deg", "integral"},
    "straight-through": {"transmittance"},
}


@dataclass(frozen=True)
class Scenario:
    """Sample components as in the file; angles of the beam's top hat (full width) and of its raised-cosine edge."""

    components: tuple[dict[str, Any], ...]
    divergence_deg: float
    edge_deg: float
    instrument: Instrument


def load_scenario(path: Path) -> Scenario:
    """Read a scenario file. Raises UsageError, naming file and key."""
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise UsageError(f"{path}: cannot read the scenario ({error}): check name and syntax") from error
    sample = document.get("sample", {})
    if "kind" in sample:
        raise UsageError(
            f"{path}: sample.kind = {sample['kind']!r} is traced and has no closed form: compare with gonio simulate"
        )
    named = document.get("instrument")
    instrument = load_instrument(path.parent / named if named else None)
    components = tuple(sample.get("components", ()))
    for number, component in enumerate(components):
        kind = component.get("kind")
        if kind not in COMPONENT_KEYS:
            raise UsageError(f"{path}: sample.components[{number}].kind = {kind!r}; one of {sorted(COMPONENT_KEYS)}")
        for key in component.keys() - COMPONENT_KEYS[kind] - {"kind"}:
            raise UsageError(f"{path}: sample.components[{number}].{key} is unknown for kind {kind!r}")
        if kind == "gaussian" and component.get("about") not in ("mirror", "retro", "through"):
            raise UsageError(f"{path}: sample.components[{number}].about must be mirror, retro or through")
    beam = document.get("beam", {})
    collimated = beam.get("kind", "collimated") == "collimated"
    natural_deg = 1.0
    if collimated:
        radius_mm = 0.5 * float(beam.get("diameter_mm", 65.0))
        natural_deg = float(2.0 * np.degrees(np.arctan2(radius_mm, instrument.arm_radius_mm)))
    return Scenario(
        components=components,
        divergence_deg=float(beam.get("divergence_deg", natural_deg)),
        edge_deg=float(beam.get("edge_deg", 0.1)),
        instrument=instrument,
    )
