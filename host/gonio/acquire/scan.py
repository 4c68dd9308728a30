"""scan.py: one gonio scan from plan to finished raw log: the file, the session, the runner, and every way to end."""

from contextlib import ExitStack, suppress
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from gonio.acquire.awake import SleepWatch, kept_awake
from gonio.acquire.interrupt import Interrupt, ScanStopped, a_stop_is_no_fault, stop_from_elsewhere
from gonio.acquire.operator import Operator
from gonio.acquire.progress import ScanProgress
from gonio.acquire.resume import check_same_scan, digest, remaining_program
from gonio.acquire.runner import Runner
from gonio.acquire.session import Session
from gonio.link.client import SOFTWARE, Client
from gonio.link.connect import open_transport
from gonio.link.device import Device
from gonio.plan.moves import starting_at
from gonio.plan.program import PathStep, Program
from gonio.protocol.blocks import sample_block
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.protocol.generated import records
from gonio.rawlog.segment_reader import Segment, read_segment
from gonio.rawlog.segments import existing_segments, segment_path
from gonio.rawlog.writer import RawLogWriter
from gonio.units.errors import GonioError, UsageError
from gonio.units.instrument import Instrument


@dataclass(frozen=True)
class ScanRequest:
    """What the user asked for. `plan_text` is the plan file as compiled into `program`."""

    program: Program
    plan: Path
    plan_text: bytes
    instrument: Instrument
    device: Device
    output: Path
    resume: bool = False
    twin_truth: Path | None = None
    twin_journal: Path | None = None


def scan(request: ScanRequest, operator: Operator, interrupt: Interrupt) -> Path:
    """Measure, and write the raw log; its path. `interrupt` is entered by the caller, before the first slow import, so
    that a stop is never missed. Raises ScanStopped, InstrumentFault or UsageError; the log is closed
    in every case and holds what came until then."""
    segments = _segments_to_continue(request)
    program = remaining_program(request.program, segments)
    path = segment_path(request.output, len(segments) + 1)
    if not any(isinstance(step, PathStep) for step in program.steps):
        raise UsageError(f"{request.output}: the scan is complete, nothing is left to resume")
    if path.exists():
        raise UsageError(f"{path}: exists and is never overwritten: choose another name or --resume")
    interrupt.check()
    progress = ScanProgress(program.duration_s)
    checks = [interrupt.check]
    with ExitStack() as stack:
        if not request.device.lock_step:  # a twin in virtual time may sleep with us
            stack.enter_context(kept_awake(progress.say))
            checks.append(SleepWatch().check)
        transport = stack.enter_context(
            open_transport(request.device, truth=request.twin_truth, journal=request.twin_journal)
        )
        client = Client(transport)
        writer = stack.enter_context(RawLogWriter(path, _metadata(request, program, segments, client)))
        client.on_frame = lambda frame: writer.write(frame, client.link_time_ns)
        client.on_request = lambda raw: writer.write_request(raw, client.link_time_ns)

        def before_receive() -> None:
            for check in checks:
                check()

        client.before_receive = before_receive
        stack.enter_context(progress)
        session = Session(client, request.instrument)
        runner = Runner(session, operator, progress)

        def on_event(event: pb.Event) -> None:
            stop_from_elsewhere(event, interrupt)
            runner.take_event(event)

        client.on_event = on_event
        _run(session, runner, program, interrupt)
        writer.finish()
    return path


def _run(session: Session, runner: Runner, program: Program, interrupt: Interrupt) -> None:
    try:
        with a_stop_is_no_fault(interrupt, session.client):
            session.make_ready()
            session.info()  # with the drives' notes; the reply goes into the raw log
            session.lamp_on()
            session.acquire(True)
            runner.run(starting_at(program, np.array(session.status().position_counts), session.instrument))
            session.shutter(False)
            session.acquire(False)
    except ScanStopped as stop:
        session.stop(str(stop)[:60])
        session.acquire(False)
        raise ScanStopped(f"{stop}: the arm is at rest, the shutter closed; continue with --resume") from None
    except GonioError:
        # What ended the scan is what the user must read; the firmware stops by itself if this does not reach it.
        with suppress(GonioError):
            session.stop("the scan failed")
            session.acquire(False)
        raise


def _segments_to_continue(request: ScanRequest) -> list[Segment]:
    """The segments that --resume goes on from; none without it. Raises UsageError when they do not fit."""
    if not request.resume:
        return []
    paths = existing_segments(request.output)
    if not paths:
        raise UsageError(f"{request.output}: there is no raw log to resume; leave --resume out")
    segments = [read_segment(path) for path in paths]
    check_same_scan(segments, digest(request.plan_text), digest(request.instrument.text), request.plan)
    return segments


def _metadata(request: ScanRequest, program: Program, segments: list[Segment], client: Client) -> dict[str, Any]:
    """The raw log's metadata: the program's own, the paths, and all that explains them."""
    parent = segments[-1] if segments else None
    last_block = sample_block(parent.sample_payloads[-1])[0]["block"] if parent and parent.sample_payloads else None
    return program.metadata | {
        "paths": [
            {
                "path_id": step.path_id,
                "kind": step.kind,
                "name": step.name,
                "incident_theta_deg": step.incident_theta_deg,
                "incident_phi_deg": step.incident_phi_deg,
                "duration_s": step.duration_s,
            }
            for step in program.steps
            if isinstance(step, PathStep)
        ],
        "unreachable": [asdict(direction) for direction in program.unreachable],
        "plan_sha256": digest(request.plan_text),
        "instrument": request.instrument.text,
        "instrument_sha256": digest(request.instrument.text),
        "versions": {
            "host": SOFTWARE,
            "firmware": client.hello.software,
            "schema_hash": f"{records.SCHEMA_HASH:016x}",
        },
        "device": request.device.name,
        "session_id": client.hello.session_id,
        "started_utc": datetime.now(UTC).isoformat(timespec="seconds"),
        "segment": len(segments) + 1,
        "parent": parent.path.name if parent else None,
        "parent_last_block": None if last_block is None else int(last_block),
    }
