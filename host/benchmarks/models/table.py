"""table.py: a line of the judges' table: ours, what is to be reached, Radiance, and what the resolution allows."""

from collections.abc import Mapping
from typing import Any, Literal

from benchmarks.rows import row

RADIANCE = "Radiance -g 7"
_LEAST = 1e-6  # an error of 0 has no ratio

# More is better; less is better; a share in percent that should be 100; a signed error that should be 0.
Better = Literal["high", "low", "kept", "error"]


def line(
    name: str,
    unit: str,
    ours: float,
    peer: float | None,
    better: Better,
    *,
    target: float | None = None,
    beside: Mapping[str, float] | None = None,
    peer_name: str = RADIANCE,
) -> dict[str, Any]:
    """A row as rows.row makes it, with the issue's `target`, whether it is `reached`, and what stands `beside`
    (ceilings, other settings of the peer). A kept share of 105 % is as far off as one of 95 %; targets of "kept" are
    given as for shares under 100 %."""

    def merit(value: float) -> float:
        return abs(100.0 - value) if better == "kept" else abs(value) if better == "error" else value

    high = better == "high"
    compared = None if peer is None else max(merit(peer), _LEAST)
    found = row(name, unit, max(merit(ours), _LEAST), compared, peer_name, 1, high=high)
    found |= {"ours": ours, "peer": peer, "target": target, "beside": dict(beside or {})}
    if target is None:
        found["reached"] = None
    else:
        found["reached"] = ours >= target if high else merit(ours) <= merit(target)
    return found


def printed(rows: list[dict[str, Any]]) -> list[str]:
    """The table."""
    lines = [f"{'':58} {'unit':8} {'ours':>9} {'target':>7} {'':3} {'peer':>9}  peer, and what else stands beside"]
    for r in rows:
        target = "" if r["target"] is None else f"{r['target']:.4g}"
        mark = {None: "", True: "yes", False: "NO"}[r["reached"]]
        peer = "-" if r["peer"] is None else f"{r['peer']:.4g}"
        beside = "".join(f"; {name} {value:.3g}" for name, value in r["beside"].items())
        lines.append(
            f"{r['name']:58} {r['unit']:8} {r['ours']:9.4g} {target:>7} {mark:3} {peer:>9}  {r['peer_name']}{beside}"
        )
    return lines
