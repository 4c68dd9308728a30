"""reduce.py: the command reduce: raw logs to a dataset."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gonio.cli.options import OutputOption
from gonio.cli.places import check_inputs, check_outputs

if TYPE_CHECKING:
    from gonio.rawlog.reader import RawLog
    from gonio.reduce.options import OtherBeam


def register(app: typer.Typer) -> None:
    """Add the command of this module."""
    app.command("reduce")(reduce)


def reduce(
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILE...", help="Raw logs (.mcap) of one scan, or one dataset that import wrote."),
    ],
    output: OutputOption,
    without: Annotated[
        list[str] | None,
        typer.Option(
            metavar="CORRECTION",
            help="Leave out dark, gain, linearity, lamp, distance, stray_light or masks; may be repeated.",
        ),
    ] = None,
    reach: Annotated[
        float, typer.Option(metavar="FACTOR", help="No point owns area farther than this times the local path pitch.")
    ] = 1.5,
    calibration: Annotated[
        Path | None,
        typer.Option(metavar="FILE.toml", help="Table [calibration] that goes before that of the instrument file."),
    ] = None,
    p_i: Annotated[
        float | None, typer.Option("--p-i", metavar="VALUE", help="Declared P_i in counts*sr; no reference scan.")
    ] = None,
    p_i_u: Annotated[
        float, typer.Option("--p-i-u", metavar="VALUE", help="Standard uncertainty of --p-i in counts*sr.")
    ] = 0.0,
    beam: Annotated[
        Path | None, typer.Option(metavar="OTHER.h5", help="Reduced dataset whose reference scan gives P_i.")
    ] = None,
) -> None:
    """Turn the raw log of a scan, or imported points, into a BSDF dataset.

    A scan that was resumed has several raw logs: name all of them in order, or the first one alone.
    """
    from gonio.dataset.nexus import PointPacker, begin_points, read_dataset, write_dataset
    from gonio.rawlog.segments import SUFFIX
    from gonio.reduce.imported import reduce_dataset
    from gonio.reduce.options import ReduceOptions
    from gonio.reduce.pipeline import reduce_rawlog
    from gonio.units.errors import UsageError

    inputs = [*files, *(file for file in (calibration, beam) if file is not None)]
    check_inputs(*inputs)
    check_outputs(output, inputs=inputs)
    text = "" if calibration is None else calibration.read_text(encoding="utf-8", errors="replace")
    if calibration is not None and not text.strip():
        raise UsageError(f"{calibration}: is empty: it must hold a table [calibration]")
    options = ReduceOptions(
        without=tuple(without or ()),
        reach_factor=reach,
        calibration_text=text,
        calibration_name=str(calibration or "--calibration"),
        p_i=p_i,
        p_i_u=p_i_u,
    )
    if all(file.suffix == SUFFIX for file in files):
        with PointPacker() as packer:
            other = None if beam is None else _other_beam(beam)
            dataset = reduce_rawlog(_read(files), options, other, lambda found: begin_points(found, packer))
            write_dataset(dataset, output, packer)
        typer.echo(output)
        return
    if len(files) != 1:
        raise UsageError("reduce takes the raw logs of one scan, or one dataset of imported points")
    if without or text or p_i is not None or beam is not None:
        raise UsageError(
            f"{files[0]}: of the options only --reach works on imported points; P_i is given to gonio import"
        )
    dataset = reduce_dataset(read_dataset(files[0]), options.reach_factor)
    write_dataset(dataset, output)
    typer.echo(output)


def _read(files: list[Path]) -> "RawLog":
    from gonio.rawlog.reader import read_rawlog
    from gonio.rawlog.segments import existing_segments
    from gonio.units.errors import UsageError

    paths = files
    if len(files) == 1 and len(existing_segments(files[0])) > 1:
        paths = existing_segments(files[0])
        typer.echo(f"gonio: {files[0]}: {len(paths)} segments of this scan are joined", err=True)
    log = read_rawlog(paths)
    if log.damaged:
        raise UsageError(f"{log.problem}; the file is damaged and not reduced")
    if log.problem:
        typer.echo(f"gonio: {log.problem}; continuing with them", err=True)
    return log


def _other_beam(file: Path) -> "OtherBeam":
    from gonio.dataset.nexus import read_provenance
    from gonio.reduce.options import OtherBeam

    return OtherBeam(file.name, read_provenance(file).get("beam", {}))
