"""device.py: commands that talk to an instrument: twin run, info, home, stop."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

import json
import os
from pathlib import Path
from typing import Annotated

import typer

DeviceOption = Annotated[
    str,
    typer.Option(
        "--device",
        metavar="DEVICE",
        envvar="GONIO_DEVICE",
        help="usb:, usb:SERIAL, tcp://HOST:PORT, or twin:SCENARIO.toml (virtual time).",
    ),
]
InstrumentOption = Annotated[
    Path | None, typer.Option("--instrument", metavar="FILE", help="Instrument file; without it the reference one.")
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]


def register(app: typer.Typer) -> None:
    """Add the commands of this module."""
    twin = typer.Typer(no_args_is_help=True, help="The simulated instrument.", rich_markup_mode=None)
    twin.command("run")(twin_run)
    app.add_typer(twin, name="twin")
    app.command("info")(info)
    app.command("home")(home)
    app.command("stop")(stop)


def twin_run(
    scenario: Annotated[Path, typer.Argument(metavar="SCENARIO.toml", help="Sample, beam, errors, faults.")],
    virtual: Annotated[bool, typer.Option("--virtual", help="Lock-step virtual time instead of real time.")] = False,
    listen: Annotated[str, typer.Option(metavar="HOST:PORT", help="Port 0: a free one.")] = "127.0.0.1:0",
    truth: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the true state at every sample.")] = None,
    journal: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the final state, JSON.")] = None,
) -> None:
    """Start a simulated instrument and print its address; Ctrl-C ends it."""
    from gonio.link.twin import twin_program

    program = twin_program()
    command = [str(program), str(scenario), "--virtual" if virtual else "--paced", "--listen", listen]
    command += ["--truth", str(truth)] if truth else []
    command += ["--journal", str(journal)] if journal else []
    os.execv(program, command)


def info(device: DeviceOption, as_json: JsonOption = False) -> None:
    """Say what the instrument is and how it is."""
    from gonio.link.client import Client
    from gonio.link.connect import open_transport
    from gonio.link.device import parse_device
    from gonio.protocol.generated import gonio_pb2 as pb
    from gonio.protocol.messages import state_name

    named = parse_device(device)
    # A twin of our own needs a driver, or its time stands still; anywhere else we only visit.
    role = pb.ROLE_DRIVER if named.lock_step else pb.ROLE_VISITOR
    with open_transport(named) as transport, Client(transport, role) as client:
        answer = client.request(get_info=pb.GetInfo()).info
    report = {
        "device": answer.device,
        "firmware": answer.firmware,
        "state": state_name(answer.state),
        "driver_connected": answer.driver_connected,
        "last_fault": answer.last_fault,
        "kernel": answer.kernel,
        "realtime": answer.realtime,
        "nodes": [
            {
                "node": node.node,
                "device_type": node.device_type,
                "vendor": node.vendor,
                "product": node.product,
                "revision": node.revision,
                "serial": node.serial,
                "notes": node.notes,
            }
            for node in answer.nodes
        ],
    }
    if as_json:
        typer.echo(json.dumps(report))
        return
    typer.echo(f"{answer.device}, firmware {answer.firmware}, state {state_name(answer.state)}")
    if answer.kernel:  # none in virtual time
        typer.echo(f"{answer.kernel}, PREEMPT_RT: {'yes' if answer.realtime else 'no'}")
    if answer.last_fault:
        typer.echo(f"last fault: {answer.last_fault}")
    for node in answer.nodes:
        notes = f"; {node.notes}" if node.notes else ""
        typer.echo(f"node {node.node}: vendor {node.vendor:#010x}, product {node.product:#010x}{notes}")


def home(device: DeviceOption, instrument: InstrumentOption = None) -> None:
    """Configure and boot the drives and find their positions."""
    from contextlib import ExitStack

    from gonio.acquire.control import ControlSocket
    from gonio.acquire.interrupt import Interrupt, ScanStopped, a_stop_is_no_fault, stop_from_elsewhere
    from gonio.acquire.session import Session
    from gonio.link.client import Client
    from gonio.link.connect import open_transport
    from gonio.link.device import parse_device
    from gonio.units.instrument import load_instrument

    described = load_instrument(instrument)
    named = parse_device(device)
    with ExitStack() as stack:
        control = stack.enter_context(ControlSocket(named.name))
        interrupt = stack.enter_context(Interrupt(control))
        client = stack.enter_context(Client(open_transport(named)))
        client.before_receive = interrupt.check
        client.on_event = lambda event: stop_from_elsewhere(event, interrupt)
        session = Session(client, described)
        try:
            with a_stop_is_no_fault(interrupt, client):
                session.make_ready()
        except ScanStopped as stopped:
            session.stop(str(stopped))
            raise
        counts = list(session.status().position_counts)
    for axis, position in zip(described.axes, counts, strict=False):
        typer.echo(f"{axis.name}: {position / axis.counts_per_deg:.4f} deg")


def stop(
    device: Annotated[
        str | None, typer.Option("--device", metavar="DEVICE", help="Without it: everything that you drive.")
    ] = None,
) -> None:
    """Stop a running scan, from anywhere and at any time: controlled stop, shutter closed."""
    from gonio.acquire.control import stop_running
    from gonio.link.client import Client
    from gonio.link.connect import open_transport
    from gonio.link.device import parse_device
    from gonio.protocol.generated import gonio_pb2 as pb
    from gonio.units.errors import UsageError

    stopped = stop_running(device)
    for process in stopped:
        typer.echo(f"process {process.pid} stops {process.device}")
    if stopped:
        return
    if device is None:
        raise UsageError("no process of yours drives an instrument; name one with --device")
    named = parse_device(device)
    if named.lock_step:
        raise UsageError(f"{device}: no process of yours drives it")
    with Client(open_transport(named), pb.ROLE_VISITOR) as client:
        client.request(stop=pb.Stop(reason="gonio stop"))
    typer.echo(f"{device} stops")
