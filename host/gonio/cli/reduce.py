"""reduce.py: the command reduce: raw logs to a dataset."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

from pathlib import Path
from typing import Annotated

import typer

from gonio.cli.options import OutputOption
from gonio.cli.places import check_inputs, check_outputs


def register(app: typer.Typer) -> None:
    """Add the command of this module."""
    app.command("reduce")(reduce)


def reduce(
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILE...", help="Raw logs (.mcap) of one scan, or one dataset that import wrote."),
    ],
    output: OutputOption,
) -> None:
    """Turn the raw log of a scan, or imported points, into a BSDF dataset.

    A scan that was resumed has several raw logs: name all of them in order, or the first one alone.
    """
    from gonio.dataset.nexus import read_dataset, write_dataset
    from gonio.rawlog.reader import read_rawlog
    from gonio.rawlog.segments import SUFFIX, existing_segments
    from gonio.reduce.pipeline import ReduceOptions, reduce_dataset, reduce_rawlog
    from gonio.units.errors import UsageError

    check_inputs(*files)
    check_outputs(output, inputs=files)
    if all(file.suffix == SUFFIX for file in files):
        paths = files
        if len(files) == 1 and len(existing_segments(files[0])) > 1:
            paths = existing_segments(files[0])
            typer.echo(f"gonio: {files[0]}: {len(paths)} segments of this scan are joined", err=True)
        log = read_rawlog(paths)
        if log.damaged:
            raise UsageError(f"{log.problem}; the file is damaged and not reduced")
        if log.problem:
            typer.echo(f"gonio: {log.problem}; continuing with them", err=True)
        dataset = reduce_rawlog(log, ReduceOptions())
    elif len(files) == 1:
        dataset = reduce_dataset(read_dataset(files[0]))
    else:
        raise UsageError("reduce takes the raw logs of one scan, or one dataset of imported points")
    write_dataset(dataset, output)
    typer.echo(output)
