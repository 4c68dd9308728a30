"""drives.py: commands that commission CiA 402 drives over a python-can interface: drives list, check, store."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

import json
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gonio.cli.device import InstrumentOption, JsonOption

if TYPE_CHECKING:
    from gonio.drives.bus import DriveBus
    from gonio.drives.findings import Finding
    from gonio.drives.sheet import Sheet
    from gonio.drives.store import StorePlan
    from gonio.units.instrument import Axis, Instrument

HEARTBEATS = 3  # listened for before anything is sent: one lost frame must not hide a goniod

InterfaceOption = Annotated[
    str, typer.Option("--interface", metavar="NAME", help="As python-can names it: socketcan, ...")
]
ChannelOption = Annotated[str, typer.Option("--channel", metavar="CHANNEL", help="As python-can names it: can0, ...")]
BitrateOption = Annotated[
    int | None,
    typer.Option("--bitrate", metavar="BIT/S", min=1, help="Where python-can sets it; also gives the bus load."),
]
BusArgOption = Annotated[
    list[str] | None,
    typer.Option("--bus-arg", metavar="KEY=VALUE", help="More for python-can's interface; repeatable."),
]
NodeOption = Annotated[
    list[int] | None, typer.Option("--node", metavar="ID", help="Only this node of the instrument file; repeatable.")
]


def register(app: typer.Typer) -> None:
    """Add the commands of this module."""
    drives = typer.Typer(no_args_is_help=True, help="Commission the drives, without goniod.", rich_markup_mode=None)
    drives.command("list")(list_nodes)
    drives.command("check")(check)
    drives.command("store")(store)
    app.add_typer(drives, name="drives")


def list_nodes(
    channel: ChannelOption,
    interface: InterfaceOption = "socketcan",
    bitrate: BitrateOption = None,
    bus_arg: BusArgOption = None,
    instrument: InstrumentOption = None,
    as_json: JsonOption = False,
) -> None:
    """Find every node on the bus and say what it is."""
    from gonio.drives.scan import scan
    from gonio.units.instrument import load_instrument

    described = load_instrument(instrument)
    with _bus(described, interface, channel, bitrate, bus_arg) as bus:
        _listen(bus, described)
        nodes = scan(bus)
    if as_json:
        typer.echo(json.dumps({"nodes": [asdict(node) for node in nodes]}))
    for node in () if as_json else nodes:
        parts = [f"node {node.node}", node.state_words]
        if node.device_type is not None:
            kind = "CiA 402 drive" if node.is_drive else f"device type 0x{node.device_type:08X}"
            told = [f"{key} 0x{value:X}" for key, value in node.identity.items() if value is not None]
            parts += [kind, node.name or "without a name", *told]
        typer.echo(", ".join(parts) + (f": {node.problem}" if node.problem else ""))
    if not nodes:
        typer.echo("no node answers: check power, cable, bit rate and node ids", err=True)
    raise typer.Exit(1 if not nodes or any(node.problem for node in nodes) else 0)


def check(
    channel: ChannelOption,
    interface: InterfaceOption = "socketcan",
    bitrate: BitrateOption = None,
    bus_arg: BusArgOption = None,
    instrument: InstrumentOption = None,
    node: NodeOption = None,
    eds: Annotated[
        list[str] | None, typer.Option("--eds", metavar="[ID=]FILE", help="Data sheet of all drives, or of one node.")
    ] = None,
    load: Annotated[
        float | None, typer.Option("--load", metavar="SECONDS", help="Run the real PDO schedule, motors off.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Check each drive for every object that the firmware uses; with --load the bus as well. Never enables a motor."""
    from gonio.drives.check import check_drive
    from gonio.drives.findings import any_wrong
    from gonio.drives.objects import used_objects
    from gonio.drives.run_load import run_load
    from gonio.units.errors import InstrumentFault, UsageError
    from gonio.units.instrument import load_instrument

    if load is not None and not load > 0:
        raise UsageError(f"--load {load}: more than 0 seconds expected")
    described = load_instrument(instrument)
    axes = _axes(described, node)
    sheets = _sheets(eds or [], axes)
    summary: dict[str, Any] | None = None
    with _bus(described, interface, channel, bitrate, bus_arg) as bus:
        _listen(bus, described)
        checked = [check_drive(bus, described, a, a.node, used_objects(), sheets.get(a.node)) for a in axes]
        findings = [finding for drive in checked for finding in drive.findings]
        silent = [str(drive.node) for drive in checked if not drive.values]
        if len(silent) == len(checked):
            raise InstrumentFault(f"no answer from node {', '.join(silent)}: check power, cable, bit rate and node ids")
        if load is not None and silent:
            raise InstrumentFault(
                f"no answer from node {', '.join(silent)}: the load needs every drive; or name --node"
            )
        if load is not None:
            summary, found = run_load(bus, described, [a.node for a in axes], load, bitrate)
            findings += found
    if as_json:
        drives = [{"axis": drive.axis, "node": drive.node, "objects": drive.values} for drive in checked]
        text = {"drives": drives, "findings": [asdict(finding) for finding in findings], "load": summary}
        typer.echo(json.dumps(text))
    else:
        _show_load(summary)
        _show(findings)
    raise typer.Exit(1 if any_wrong(findings) else 0)


def store(
    channel: ChannelOption,
    interface: InterfaceOption = "socketcan",
    bitrate: BitrateOption = None,
    bus_arg: BusArgOption = None,
    instrument: InstrumentOption = None,
    node: NodeOption = None,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask.")] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Show what would change, write nothing.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Write the instrument file's settings into the drives, store them there, verify them after a reset."""
    from gonio.drives.findings import any_wrong
    from gonio.drives.objects import used_objects
    from gonio.drives.store import carry_out, plan_store
    from gonio.units.errors import UsageError
    from gonio.units.instrument import load_instrument

    if as_json and not (yes or dry_run):
        raise UsageError("--json cannot ask: add --yes or --dry-run")
    described = load_instrument(instrument)
    axes = _axes(described, node)
    stored: list[int] = []
    with _bus(described, interface, channel, bitrate, bus_arg) as bus:
        _listen(bus, described)
        plans = [plan_store(bus, described, axis, axis.node, used_objects()) for axis in axes]
        findings = [finding for plan in plans for finding in plan.findings]
        if not as_json:
            _show(findings)
            _show_plans(plans)
        ready = [plan for plan in plans if plan.settings]
        if ready and not dry_run:
            if not yes and not typer.confirm(f"Write and store this in {len(ready)} drive(s), and reset them?"):
                typer.echo("nothing was written")
                ready = []
            for plan in ready:
                carry_out(bus, described, plan)
                stored.append(plan.node)
                if not as_json:
                    typer.echo(f"node {plan.node}: stored, verified after its reset")
    if as_json:
        drives = [
            {
                "axis": plan.axis,
                "node": plan.node,
                "stored": plan.node in stored,
                "settings": [
                    {"object": s.used.name, "setting": s.used.setting, "old": s.old, "new": s.new}
                    for s in plan.settings
                ],
            }
            for plan in plans
        ]
        typer.echo(json.dumps({"drives": drives, "findings": [asdict(finding) for finding in findings]}))
    raise typer.Exit(1 if any_wrong(findings) else 0)


def _bus(
    described: "Instrument", interface: str, channel: str, bitrate: int | None, extra: list[str] | None
) -> AbstractContextManager["DriveBus"]:
    from gonio.drives.bus import open_bus

    return open_bus(interface, channel, bitrate, extra or [], described.cycle.sdo_timeout_ms)


def _listen(bus: "DriveBus", described: "Instrument") -> None:
    cycle = described.cycle
    bus.listen(HEARTBEATS * max(cycle.firmware_heartbeat_ms, cycle.drive_heartbeat_ms) / 1000.0)


def _axes(described: "Instrument", nodes: list[int] | None) -> list["Axis"]:
    from gonio.units.errors import UsageError

    axes = [axis for axis in described.axes if axis.driven]
    known = {axis.node for axis in axes}
    for node in nodes or []:
        if node not in known:
            raise UsageError(f"--node {node}: no axis of {described.name} has it; known are {sorted(known)}")
    chosen = [axis for axis in axes if not nodes or axis.node in nodes]
    if not chosen:
        raise UsageError(f"{described.name} has no driven axis: nothing to check")
    return chosen


def _sheets(named: Sequence[str], axes: Sequence["Axis"]) -> dict[int, "Sheet"]:
    from gonio.drives.sheet import Sheet
    from gonio.units.errors import UsageError

    for_all: Path | None = None
    for_one: dict[int, Path] = {}
    for text in named:
        node, equals, name = text.partition("=")
        if equals and node.isdecimal():
            for_one[int(node)] = Path(name)
        elif for_all is None:
            for_all = Path(text)
        else:
            raise UsageError(f"--eds {text}: a second file for all drives; name the node: --eds ID=FILE")
    for node_id, path in for_one.items():
        if node_id not in {axis.node for axis in axes}:
            raise UsageError(f"--eds {node_id}={path}: node {node_id} is not among those to check")
    paths = {axis.node: for_one.get(axis.node, for_all) for axis in axes}
    return {node_id: Sheet.read(file, node_id) for node_id, file in paths.items() if file is not None}


def _show(findings: Sequence["Finding"]) -> None:
    for finding in findings:
        typer.echo(finding.line)
    if not findings:
        typer.echo("nothing to report")


def _show_load(summary: dict[str, Any] | None) -> None:
    if summary is None:
        return
    jitter = summary["echo_jitter_us"]
    spread = f"{jitter['p50']} / {jitter['p99']} / {jitter['max']} us" if jitter else "not measured"
    typer.echo(f"{summary['syncs']} SYNCs; echo jitter 50 % / 99 % / most, by this host's clock: {spread}")
    if summary["worst_bus_load"] is not None:
        typer.echo(f"the schedule takes {100 * summary['worst_bus_load']:.0f} % of the bus at most")
    typer.echo(f"error frames: {summary['error_frames']}; state of the interface: {summary['bus_state'] or 'not told'}")
    for node in summary["nodes"]:
        counts = ", ".join(f"{node[key]} {key}" for key in ("received", "lost", "late", "duplicate"))
        typer.echo(f"node {node['node']}: TPDOs {counts}; EMCY {', '.join(node['emergencies']) or 'none'}")


def _show_plans(plans: Sequence["StorePlan"]) -> None:
    for plan in plans:
        changes = [setting for setting in plan.settings if setting.changes]
        for s in changes:
            typer.echo(
                f"node {plan.node} ({plan.axis}): {s.used.name} {s.used.why} ({s.used.setting}): {s.old} -> {s.new}"
            )
        if plan.settings and not changes:
            typer.echo(
                f"node {plan.node} ({plan.axis}): holds all {len(plan.settings)} values already; "
                "storing makes them last"
            )
