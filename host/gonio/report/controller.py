"""controller.py: the report's section on the controller: kernel, missed cycles, how late its threads woke, notes."""

from typing import Any

from gonio.dataset.bsdf import Dataset
from gonio.reduce.samples.controller import late_at_most_us
from gonio.report.html_parts import bullets, facts, number, paragraph, table

_SHARE = 0.999


def controller(dataset: Dataset) -> str:
    """Empty for what no real controller measured."""
    found: dict[str, Any] = dataset.provenance.get("controller", {})
    if not found:
        return ""
    shown = _facts(found, dataset.provenance.get("counters", {}))
    parts = [facts(shown)] if shown else []
    if found.get("kernel") and not found["realtime"]:
        parts.append(
            paragraph(
                f"{found['kernel']} has no PREEMPT_RT, or the threads did not run under SCHED_FIFO: a busy controller "
                "may miss cycles.",
                "warn",
            )
        )
    if latency := found.get("latency"):
        rows = [
            [thread, f"{of['wakeups']:,}", number(late_at_most_us(of, _SHARE), 6), f"{of['max_us']:,}"]
            for thread, of in latency.items()
        ]
        parts.append(table(["thread", "wake-ups", f"{_SHARE:.1%} within [\u00b5s]", "latest [\u00b5s]"], rows))
        parts.append(
            paragraph(
                "How late the controller's threads woke during the scan, in steps of two; latest: since its start. A "
                "position belongs to the SYNC's own stamp, so a late one costs no accuracy.",
                "note",
            )
        )
    if notes := found.get("notes"):
        parts.append(bullets(f"{drive}: {note}" for drive, note in notes.items()))
    return "".join(parts)


def _facts(found: dict[str, Any], counters: dict[str, int]) -> dict[str, str]:
    shown = {}
    if found.get("kernel"):
        shown["Kernel"] = str(found["kernel"])
        shown["PREEMPT_RT"] = "yes" if found["realtime"] else "no"
    if "latency" in found and "cycles_missed" in counters:
        shown["Cycles missed"] = f"{counters['cycles_missed']:,}"
    if of_axes := found.get("position_time_u_us"):
        shown["Time of a position, u (k = 1)"] = f"{max(of_axes.values()):.3g} \u00b5s"
    return shown
