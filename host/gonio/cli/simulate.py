"""simulate.py: the command that traces a scenario's sample (or takes its closed form) into a dataset."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from gonio.cli.data import OutputOption
from gonio.cli.device import JsonOption
from gonio.cli.places import check_inputs, check_outputs


def register(app: typer.Typer) -> None:
    """Add the command of this module."""
    app.command("simulate")(simulate)


def simulate(
    scenario: Annotated[Path, typer.Argument(metavar="SCENARIO.toml", help="Sample, beam, detector, what to read.")],
    *,
    output: OutputOption,
    like: Annotated[
        Path | None,
        typer.Option(metavar="MEASURED.h5", help="Simulate at exactly the points of this dataset."),
    ] = None,
    photons: Annotated[
        int | None, typer.Option(metavar="N", min=1, help="Per incident direction and band; without it the scenario's.")
    ] = None,
    error: Annotated[
        float | None,
        typer.Option(metavar="REL", min=0.0, max=1.0, help="Photons until the median relative error is so small."),
    ] = None,
    seed: Annotated[int | None, typer.Option(metavar="N", min=0, help="Of the random numbers.")] = None,
    threads: Annotated[int | None, typer.Option(metavar="N", min=1, help="Without it: all cores.")] = None,
    workers: Annotated[
        int, typer.Option(metavar="N", min=0, help="Trace on so many Dask workers of this machine.")
    ] = 0,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Trace at this Dask scheduler, as tcp://HOST:PORT.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Simulate what an instrument would measure of a scenario's sample, as a BSDF dataset.

    The same seed gives the same file, however the work is divided.
    """
    from gonio.dataset.nexus import write_dataset
    from gonio.simulate.progress import PhotonProgress
    from gonio.simulate.request import Request, usable_cores
    from gonio.simulate.simulation import simulate as run
    from gonio.units.errors import UsageError

    check_inputs(scenario, like)
    check_outputs(output, inputs=[scenario, like])
    if scheduler is not None and workers:
        raise UsageError("--scheduler and --workers: choose one, workers of another machine are started there")
    if threads is not None and (scheduler is not None or workers):
        raise UsageError(
            "--threads goes with neither --workers nor --scheduler: a worker traces on one thread per task"
        )
    request = Request(
        scenario=scenario,
        like=like,
        photons=photons,
        relative_error=error,
        seed=seed,
        threads=threads or usable_cores(),
        workers=workers,
        scheduler=scheduler,
    )
    with PhotonProgress() as progress:
        done = run(request, progress)
    write_dataset(done.dataset, output)
    for remark in done.remarks:
        typer.echo(f"gonio: {remark}", err=True)
    if as_json:
        report = {"output": str(output), "balance": done.balance, "distributions": done.distributions}
        typer.echo(json.dumps(report | {"remarks": done.remarks}))
        return
    for line in _balance_lines(done.balance):
        typer.echo(line, err=True)
    typer.echo(output)


def _balance_lines(balance: dict[str, Any]) -> list[str]:
    """Where the light went, in shares of what was emitted."""
    if not balance:
        return ["closed form: no photons"]
    lines = [f"{'photons':<10}{balance['photons']:>16,}"]
    for name in ("emitted", "stored", "absorbed", "lost", "roulette"):
        lines.append(f"{name:<10}{balance[name] / balance['emitted']:>16.4%}")
    return lines
