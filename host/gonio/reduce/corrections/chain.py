"""chain.py: all corrections in the order in which they act, which of them are on, and what the file says of each."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

from gonio.reduce.corrections import dark, distance, lamp, light, linearity, masks, stray_light
from gonio.units.errors import UsageError
from gonio.units.instrument import Instrument

ORDER = (dark, light, linearity, lamp, distance, stray_light, masks)
NAMES = tuple(correction.NAME for correction in ORDER)
# What every reduction does; the order is that of the work.
_BEFORE = (
    ("delays", "light of a sample = strobe time less the channel's delay; position = SYNC echo plus axis' latch delay"),
    ("pose", "cubic through the four SYNC positions around the light"),
)
_AFTER = (
    ("division", "DSF = signal / (normalisation P_i), of signed values; nothing is clipped"),
    ("variance", "noise measured in the dark plus shot and monitor noise estimated from the scan, as white noise"),
)


@dataclass(frozen=True)
class Switches:
    """Which corrections are on."""

    without: frozenset[str] = frozenset()

    @classmethod
    def of(cls, without: Iterable[str]) -> "Switches":
        """Raises UsageError for a name that is no correction."""
        off = frozenset(without)
        for name in sorted(off - set(NAMES)):
            raise UsageError(f"--without {name}: no such correction; there are {', '.join(NAMES)}")
        return cls(off)

    def on(self, name: str) -> bool:
        """Whether this correction is applied."""
        return name not in self.without


def recorded(
    switches: Switches, instrument: Instrument, used: dict[str, dict[str, Any]], power: dict[str, Any]
) -> list[dict[str, Any]]:
    """For the provenance: every step with name, applied, what (one sentence), parameters with u where they have one.

    `used`: what was found in the scan, by correction; `power`: what is known of P_i.
    """
    steps: list[dict[str, Any]] = [_step(name, what, {}) for name, what in _BEFORE]
    calibrated = _calibrated(instrument)
    for correction in ORDER:
        parameters = {**calibrated.get(correction.NAME, {}), **used.get(correction.NAME, {})}
        step = _step(correction.NAME, correction.WHAT, parameters)
        steps.append(step | {"applied": switches.on(correction.NAME)})
    steps.append(_step("p_i", str(power["what"]), {key: value for key, value in power.items() if key != "what"}))
    return steps + [_step(name, what, {}) for name, what in _AFTER]


def _step(name: str, what: str, parameters: dict[str, Any]) -> dict[str, Any]:
    return {"name": name, "applied": True, "what": what, "parameters": parameters}


def _calibrated(instrument: Instrument) -> dict[str, dict[str, Any]]:
    calibration, gains = asdict(instrument.calibration), light.Gains.of(instrument)

    def with_u(name: str, u_name: str) -> dict[str, Any]:
        return {name: calibration[name], u_name: calibration[u_name]}

    return {
        "gain": {
            f"{channel.name}_{key}": getattr(channel, key)
            for channel in (gains.high, gains.low)
            for key in ("gain", "gain_u_rel", "full_scale_counts")
        },
        "linearity": with_u("nonlinearity", "nonlinearity_u"),
        "lamp": {"monitor_u_rel": calibration["monitor_u_rel"]},
        "distance": {
            **with_u("sample_offset_mm", "sample_offset_u_mm"),
            "arm_radius_mm": instrument.arm_radius_mm,
            "arm_radius_u_mm": calibration["arm_radius_u_mm"],
        },
        "stray_light": with_u("stray_light_per_sr", "stray_light_u_per_sr"),
    }
