"""run_load.py: the load on the drives of an instrument: arms them, runs, leaves them as they were found."""

from collections.abc import Sequence
from contextlib import ExitStack

from gonio.drives.bus import PRE_OPERATIONAL, DriveBus, FirmwareInCharge
from gonio.drives.causes import bus_load, judge, percentiles
from gonio.drives.findings import Finding, Grade
from gonio.drives.load import Clock, HostClock, Load, LoadRecord
from gonio.drives.pdo_setup import NMT_START, PdoSetup
from gonio.drives.values import FIRMWARE_NODE
from gonio.units.instrument import Instrument


def run_load(
    bus: DriveBus,
    instrument: Instrument,
    nodes: Sequence[int],
    seconds: float,
    bitrate: int | None = None,
    clock: Clock | None = None,
) -> tuple[dict[str, object], list[Finding]]:
    """The real schedule with controlword 0; afterwards the nodes are pre-operational with their own PDOs.

    Answers the summary and the findings; the load of the bus is known where its bit rate is.
    """
    cycle = instrument.cycle
    left: list[Finding] = []
    with ExitStack() as stack:
        drives = []
        setups = [PdoSetup(bus, node) for node in nodes]
        for setup in setups:
            setup.refuse_torque()
        for setup in setups:
            drives.append(setup.arm())
            stack.callback(_restore, setup, left)
        for node in nodes:
            bus.nmt(NMT_START, node)
        with bus.taken_over() as bare:
            schedule = Load(bare, clock or HostClock(), drives, cycle.sync_period_us, cycle.sync_window_us)
            try:
                record = schedule.run(seconds, cycle.boot_timeout_ms / 1000.0)
            except FirmwareInCharge:
                bus.heard.nmt_state[FIRMWARE_NODE] = (
                    PRE_OPERATIONAL  # nothing more is sent: it resets the drives itself
                )
                raise
    frames = [1] + [len(drive.rpdo) for drive in drives] + [drive.tpdo_bytes for drive in drives]
    load = None if bitrate is None else bus_load(cycle.sync_period_us, frames, bitrate)
    return summary(record, load), judge(record, load) + left


def _restore(setup: PdoSetup, left: list[Finding]) -> None:
    left += [Finding(Grade.WRONG, f"node {setup.node}", "", problem) for problem in setup.restore()]


def summary(record: LoadRecord, load: float | None) -> dict[str, object]:
    """For --json and the terminal. Times are this host's: python-can's time stamps."""

    def spread(values: list[float]) -> dict[str, float] | None:
        found = percentiles(values)
        if found is None:
            return None
        return {"p50": round(found.p50_us, 1), "p99": round(found.p99_us, 1), "max": round(found.max_us, 1)}

    return {
        "syncs": record.syncs,
        "cycles_skipped_by_host": record.skipped,
        "sends_failed": record.sends_failed,
        "echoes_lost": record.echoes_lost,
        "echo_jitter_us": spread(record.echo_errors_us),
        "worst_bus_load": None if load is None else round(load, 3),
        "bus_state": record.bus_state,
        "error_frames": record.errors.frames,
        "error_counters": record.errors.counters,
        "nodes": [
            {
                "node": node.node,
                "received": node.received,
                "lost": node.lost,
                "late": node.late,
                "duplicate": node.duplicate,
                "after_sync_us": spread(node.delays_us),
                "emergencies": [f"0x{code:04X}" for code in node.emergencies],
                "boot_ups": node.boot_ups,
            }
            for node in record.nodes.values()
        ],
    }
