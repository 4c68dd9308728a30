"""simulate.py: the command that traces a scenario's sample (or takes its closed form) into a dataset or WINDOW XML."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

import json
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gonio.cli.device import JsonOption
from gonio.cli.options import Front, OutputOption
from gonio.cli.places import check_inputs, check_outputs

if TYPE_CHECKING:
    from gonio.dataset.bsdf import Side
    from gonio.simulate.request import Request


_MOST_PHOTONS = 10**12  # sums of weights have 64 bits
_MOST_SEED = 2**63 - 1  # as in a scenario file
_MOST_THREADS = 1024


class SimulationFormat(StrEnum):
    """What simulate can write."""

    DATASET = "dataset"
    KLEMS_FULL = "klems-full"
    KLEMS_HALF = "klems-half"
    KLEMS_QUARTER = "klems-quarter"


def register(app: typer.Typer) -> None:
    """Add the command of this module."""
    app.command("simulate")(simulate)


def simulate(
    scenario: Annotated[Path, typer.Argument(metavar="SCENARIO.toml", help="Sample, beam, detector, what to read.")],
    *,
    output: OutputOption,
    kind: Annotated[
        SimulationFormat,
        typer.Option(
            "--format",
            help="dataset: what an instrument would measure. klems-...: WINDOW XML, all columns of all four matrices; "
            "light fills each incident patch, on one period of the sample.",
        ),
    ] = SimulationFormat.DATASET,
    front: Annotated[Front | None, typer.Option(help="klems-...: side that the front faces.")] = None,
    assume_flat: Annotated[
        bool,
        typer.Option(
            "--assume-flat",
            help="klems-...: the sample scatters all wavelengths alike; the block (visible, solar) that no band gives "
            "is a copy of the other, recorded in <Comments>.",
        ),
    ] = False,
    like: Annotated[
        Path | None,
        typer.Option(metavar="MEASURED.h5", help="Simulate at exactly the points of this dataset."),
    ] = None,
    photons: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            min=1,
            max=_MOST_PHOTONS,
            help="Per incident direction and band; without it the scenario's. klems-...: per incident patch; without "
            "it 20000.",
        ),
    ] = None,
    error: Annotated[
        float | None,
        typer.Option(metavar="REL", min=0.0, max=1.0, help="Photons until the median relative error is so small."),
    ] = None,
    seed: Annotated[int | None, typer.Option(metavar="N", min=0, max=_MOST_SEED, help="Of the random numbers.")] = None,
    threads: Annotated[
        int | None, typer.Option(metavar="N", min=1, max=_MOST_THREADS, help="Without it: all cores.")
    ] = None,
    workers: Annotated[
        int, typer.Option(metavar="N", min=0, help="Trace on so many Dask workers of this machine.")
    ] = 0,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Trace at this Dask scheduler, as tcp://HOST:PORT.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Simulate what an instrument would measure of a scenario's sample, as a BSDF dataset; or its BSDF matrices.

    The same seed gives the same file, however the work is divided.
    """
    from gonio.simulate.request import Request, usable_cores
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
    if kind is SimulationFormat.DATASET:
        if front is not None or assume_flat:
            raise UsageError("--front and --assume-flat are for matrices: name one of the klems formats with --format")
        report = _write_dataset(request, output)
    else:
        if like is not None:
            raise UsageError(f"--like goes with a dataset, not with --format {kind.value}: export the dataset instead")
        report = _write_matrices(request, output, kind, front, assume_flat=assume_flat)
    for remark in report["remarks"]:
        typer.echo(f"gonio: {remark}", err=True)
    if as_json:
        typer.echo(json.dumps({"output": str(output)} | report))
        return
    for line in _balance_lines(report["balance"]):
        typer.echo(line, err=True)
    typer.echo(output)


def _write_dataset(request: "Request", output: Path) -> dict[str, Any]:
    from gonio.dataset.nexus import write_dataset
    from gonio.simulate.progress import PhotonProgress
    from gonio.simulate.simulation import simulate as run

    with PhotonProgress() as progress:
        done = run(request, progress)
    write_dataset(done.dataset, output)
    return {"balance": done.balance, "distributions": done.distributions, "remarks": done.remarks}


def _write_matrices(
    request: "Request", output: Path, kind: SimulationFormat, front: Front | None, *, assume_flat: bool
) -> dict[str, Any]:
    from gonio.formats import atomic
    from gonio.simulate.patches import simulate_matrices
    from gonio.simulate.progress import PhotonProgress

    faces: Side = "undeclared" if front is None else front.value
    with PhotonProgress() as progress:
        done = simulate_matrices(request, kind.value, faces, progress, assume_flat=assume_flat)
    atomic.write_bytes(output, done.render())
    return {"balance": done.balance, "blocks": done.blocks, "remarks": done.remarks}


def _balance_lines(balance: dict[str, Any]) -> list[str]:
    """Where the light went, in shares of what was emitted."""
    if not balance:
        return ["closed form: no photons"]
    lines = [f"{'photons':<10}{balance['photons']:>16,}"]
    for name in ("emitted", "stored", "absorbed", "lost", "roulette"):
        share = round(balance[name] / balance["emitted"], 6) + 0.0  # no negative zero
        lines.append(f"{name:<10}{share:>16.4%}")
    return lines
