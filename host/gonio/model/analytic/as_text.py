"""as_text.py: the record of a fitted family as lines: held-out table, both fits side by side, ties, reciprocity."""

from typing import Any

_ERRORS = (("integral", "integral", "9.5f"), ("rms_per_sr", "rms[1/sr]", "9.3g"), ("cv", "CV", "7.4f"))


def component_lines(component: dict[str, Any]) -> list[str]:
    """Lines for one component of provenance["model"]."""
    if "equal_to" in component:
        return [f"  equal to {component['equal_to']}, {component['why']}"]
    lines = [f"  family {component['family']}: {component['source']}", *_held_out(component)]
    fits = component["fits"]
    lines += _weighted(fits)
    if "as_published" in fits[0]:
        lines += _published(fits)
    tie = component["tie"]
    held = ", ".join(f"{t:.4g}: {v:.4f}" for t, v in zip(tie["theta_i_deg"], tie["value"], strict=True))
    lines.append(f"  integral tied to {tie['source']}: {held}")
    lines.append(f"  reciprocity: residual {100.0 * component['reciprocity_residual']:.2f} % rms of the mean")
    return lines + [f"  finding: {finding}" for finding in component["findings"]]


def _held_out(component: dict[str, Any]) -> list[str]:
    lines = [f"  held out ({component['held_out']['rule']}): light sent elsewhere, CV"]
    for row in sorted(component["held_out"]["table"], key=lambda line: float(line["misplaced"])):
        chosen = " <" if row["family"] == component["family"] else ""
        lines.append(f"    {row['family']:16} {100.0 * row['misplaced']:7.2f} % {row['cv']:8.4f}{chosen}")
    return lines


def _errors(found: dict[str, Any]) -> str:
    return " ".join(f"{found[key]:{form}}" for key, _, form in _ERRORS)


def _weighted(fits: list[dict[str, Any]]) -> list[str]:
    first = {name: value for name, value in fits[0]["weighted"].items() if isinstance(value, dict)}
    heading = "".join(f"{name + _unit(value['unit']):>24}" for name, value in first.items())
    lines = [
        "  weighted fit, value and standard uncertainty:",
        f"  theta_i measured  {' '.join(words for _, words, _ in _ERRORS)} {heading}",
    ]
    for fit in fits:
        own = fit["weighted"]
        values = "".join(f"{_value(own[name]):>24}" for name in first)
        lines.append(f"  {fit['theta_i_deg']:7.2f} {fit['measured_integral']:8.5f} {_errors(own)} {values}")
    return lines


def _published(fits: list[dict[str, Any]]) -> list[str]:
    lines = ["  as published (simplex, plain BSDF differences):"]
    for fit in fits:
        own = fit["as_published"]
        values = "".join(f"{own[name]:>24.5g}" for name in ("A", "B", "g"))
        lines.append(f"  {fit['theta_i_deg']:7.2f} {fit['measured_integral']:8.5f} {_errors(own)} {values}")
    return lines


def _unit(unit: str) -> str:
    return "" if unit == "1" else f" [{unit}]"


def _value(found: dict[str, Any]) -> str:
    u = "at a bound" if found["u"] is None else f"{found['u']:.2g}"
    return f"{found['value']:.5g} ({u})"
