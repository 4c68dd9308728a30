"""scan.py: commands that plan and measure: plan, scan."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gonio.cli.device import DeviceOption, InstrumentOption, JsonOption
from gonio.cli.places import check_inputs, check_outputs

if TYPE_CHECKING:
    from gonio.acquire.interrupt import Interrupt
    from gonio.link.device import Device


def register(app: typer.Typer) -> None:
    """Add the commands of this module."""
    app.command("plan")(plan)
    app.command("scan")(scan)


def plan(
    plan_file: Annotated[Path, typer.Argument(metavar="PLAN.toml", help="What to measure.")],
    preview: Annotated[Path | None, typer.Option(metavar="OUT.html", help="Draw the detector's path.")] = None,
    instrument: InstrumentOption = None,
    as_json: JsonOption = False,
) -> None:
    """Check a plan against the instrument, and say how long it takes."""
    from gonio.plan.compile import compile_plan
    from gonio.plan.program import PathStep
    from gonio.units.instrument import load_instrument

    check_inputs(plan_file)
    check_outputs(preview, inputs=[plan_file, instrument])
    described = load_instrument(instrument)
    program = compile_plan(plan_file, described)
    if preview:
        from gonio.plan.preview import write_preview

        write_preview(program, described, preview)
    paths = [step for step in program.steps if isinstance(step, PathStep)]
    if as_json:
        report = {
            "duration_s": program.duration_s,
            "paths": [
                {
                    "path_id": path.path_id,
                    "kind": path.kind,
                    "name": path.name,
                    "duration_s": path.duration_s,
                    "knots": len(path.knots),
                }
                for path in paths
            ],
            "unreachable": len(program.unreachable),
        }
        typer.echo(json.dumps(report))
        return
    for path in paths:
        typer.echo(f"{path.name:<32} {path.duration_s:8.1f} s {len(path.knots):6d} knots")
    minutes = program.duration_s / 60.0
    typer.echo(f"{len(paths)} paths, {minutes:.1f} min; {len(program.unreachable)} unreachable directions")


def scan(
    plan_file: Annotated[Path, typer.Argument(metavar="PLAN.toml", help="What to measure.")],
    *,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="RAW.mcap", help="Raw log; must not exist.")],
    device: DeviceOption,
    instrument: InstrumentOption = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with an interrupted scan, in a next file.")] = False,
    yes: Annotated[bool, typer.Option("--yes", help="Take what is done by hand as done; never prompt.")] = False,
    twin_truth: Annotated[Path | None, typer.Option(metavar="FILE", help="The twin writes the truth here.")] = None,
    twin_journal: Annotated[Path | None, typer.Option(metavar="FILE", help="The twin writes its end state.")] = None,
) -> None:
    """Measure a plan into a raw log. Ctrl-C stops safely; --resume continues."""
    from gonio.acquire.control import ControlSocket
    from gonio.acquire.interrupt import Interrupt
    from gonio.link.device import parse_device

    check_inputs(plan_file)
    check_outputs(output, twin_truth, twin_journal, inputs=[plan_file, instrument])
    named = parse_device(device)
    with ControlSocket(named.name) as control, Interrupt(control) as interrupt:
        _scan(plan_file, output, named, instrument, interrupt, resume, yes, (twin_truth, twin_journal))


def _scan(
    plan_file: Path,
    output: Path,
    named: "Device",
    instrument: Path | None,
    interrupt: "Interrupt",
    resume: bool,
    yes: bool,
    twin_files: tuple[Path | None, Path | None],
) -> None:
    from gonio.acquire.operator import AssumedOperator, PromptingOperator
    from gonio.acquire.scan import ScanRequest
    from gonio.acquire.scan import scan as run_scan
    from gonio.plan.compile import compile_plan
    from gonio.units.instrument import load_instrument

    described = load_instrument(instrument)
    program = compile_plan(plan_file, described)
    request = ScanRequest(
        program=program,
        plan=plan_file,
        plan_text=plan_file.read_bytes(),
        instrument=described,
        device=named,
        output=output,
        resume=resume,
        twin_truth=twin_files[0],
        twin_journal=twin_files[1],
    )
    prompting = not yes and not named.lock_step
    operator = PromptingOperator(lambda text: typer.echo(text, err=True)) if prompting else AssumedOperator()
    typer.echo(run_scan(request, operator, interrupt))
