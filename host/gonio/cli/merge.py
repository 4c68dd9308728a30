"""merge.py: the commands that join datasets of one sample: merge, repeatability."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gonio.cli.device import JsonOption
from gonio.cli.options import OutputOption
from gonio.cli.places import check_inputs, check_outputs

if TYPE_CHECKING:
    from gonio.merge.merging import Merged
    from gonio.merge.retro import Plate


def register(app: typer.Typer) -> None:
    """Add the commands of this module."""
    app.command("merge")(merge)
    app.command("repeatability")(repeatability)


def merge(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Datasets (.h5) of one sample.")],
    output: OutputOption,
    *,
    as_json: JsonOption = False,
    tolerance: Annotated[
        float, typer.Option(metavar="DEG", min=0.0, max=5.0, help="Incident directions so near are one.")
    ] = 0.1,
    reach: Annotated[
        float, typer.Option(metavar="PITCHES", min=0.5, help="No point owns area farther off than so many pitches.")
    ] = 1.5,
    together: Annotated[
        float | None,
        typer.Option(
            metavar="DEG", min=0.001, help="Points so near share their area by weight. Without it: a quarter aperture."
        ),
    ] = None,
    limit: Annotated[
        float, typer.Option(metavar="K", min=0.5, help="Uncertainties at which a pass is an outlier, a seam a step.")
    ] = 3.0,
    drop_outliers: Annotated[bool, typer.Option("--drop-outliers", help="Leave out the passes named as outliers.")] = (
        False
    ),
    same_mount: Annotated[
        bool, typer.Option("--same-mount", help="The sample stayed on its mount between the scans.")
    ] = False,
    force: Annotated[
        bool, typer.Option("--force", help="Join sets of different sample names or polarisations.")
    ] = False,
    retro: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="RIG.h5",
            help="A scan through the two beam splitters, for what is about the retro direction.",
        ),
    ] = None,
    reference: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.h5",
            help="Where its reference beam about (90, 180) is. Without it: in RIG.h5 itself.",
        ),
    ] = None,
    retro_radius: Annotated[
        float,
        typer.Option(metavar="DEG", min=0.5, max=30.0, help="Kept about the retro direction."),
    ] = 7.5,
    sample_distance: Annotated[
        str,
        typer.Option(
            metavar="MM[,U]",
            help="From the arm's centre back to the sample, and standard uncertainty.",
        ),
    ] = "105,0.5",
    plate: Annotated[
        str | None,
        typer.Option(
            metavar="RS,RP,TS,TP",
            help="Splitter's reflectance and transmittance: corrects for its polarisation.",
        ),
    ] = None,
    depolarisation: Annotated[
        str | None,
        typer.Option(
            metavar="D[,U]",
            help="Share that leaves the sample depolarised. Without it: unknown, 0 to 1.",
        ),
    ] = None,
    align: Annotated[
        bool,
        typer.Option("--align", help="Turn the scan so that its maximum is retro."),
    ] = False,
) -> None:
    """Join datasets of one sample: scans, passes, sides, detectors, s and p, mountings, and the retro rig.

    A pass is left out only with --drop-outliers; overlaps, seams, outliers and what gives way to another set are told.
    """
    import hashlib
    from dataclasses import replace

    from gonio.dataset.nexus import read_dataset, write_dataset
    from gonio.merge.merging import MergeOptions, Rig
    from gonio.merge.merging import merge as run
    from gonio.merge.retro import RetroOptions
    from gonio.merge.sources import arm_radius_mm, sources_of, together_deg
    from gonio.units.errors import UsageError

    rigs_at = retro or []
    inputs = [*files, *rigs_at, *([reference] if reference is not None else [])]
    check_inputs(*inputs)
    check_outputs(output, inputs=inputs)
    if not rigs_at and (reference is not None or plate or depolarisation or align):
        raise UsageError("--reference, --plate, --depolarisation and --align go with --retro RIG.h5")
    if depolarisation and not plate:
        raise UsageError("--depolarisation: says nothing without the splitter's --plate RS,RP,TS,TP")
    names = [path.name for path in inputs]
    called = [path.name if names.count(path.name) == 1 else str(path) for path in inputs]
    read = [
        (name, hashlib.sha256(path.read_bytes()).hexdigest(), read_dataset(path))
        for name, path in zip(called, inputs, strict=True)
    ]
    sources = sources_of(read, same_mount=same_mount)
    measured, rest = sources[: len(files)], sources[len(files) :]
    distance = _numbers(sample_distance, "--sample-distance", (1, 2))
    settings = RetroOptions(
        sample_distance_mm=distance[0],
        sample_distance_u_mm=distance[1] if len(distance) == 2 else 0.0,
        radius_deg=retro_radius,
        plate=_plate(plate),
        align=align,
    )
    if depolarisation:
        share = _numbers(depolarisation, "--depolarisation", (1, 2))
        if share[0] > 1.0:
            raise UsageError(f"--depolarisation {depolarisation}: a share is 1 at most")
        u = share[1] if len(share) == 2 else 0.0
        settings = replace(settings, depolarisation=share[0], depolarisation_u=u)
    referred = rest[-1] if reference is not None else None
    rigs: list[Rig] = []
    for source in rest[: len(rigs_at)]:
        radius_mm = arm_radius_mm(source.dataset) or settings.arm_radius_mm
        rigs.append(Rig(source, referred, replace(settings, arm_radius_mm=radius_mm)))
    options = MergeOptions(
        tolerance_deg=tolerance,
        reach=reach,
        together_deg=together_deg(measured[0].dataset) if together is None else together,
        limit=limit,
        drop_outliers=drop_outliers,
        force=force,
    )
    done = run(measured, rigs, options)
    write_dataset(done.dataset, output)
    for line in _told(done):
        typer.echo(line, err=True)
    if as_json:
        typer.echo(json.dumps({"output": str(output), "remarks": done.remarks} | done.statistics))
    else:
        typer.echo(output)


def repeatability(
    table: Annotated[
        Path, typer.Argument(metavar="TABLE.csv", help="Columns file, mount, position, day; one dataset per row.")
    ],
    *,
    as_json: JsonOption = False,
) -> None:
    """Analyse repeats of one sample: what same mount, remounting, another position and another day add to the scatter.

    Levels are nested: a mount is one of its day, a position one of its mount. Files are looked for beside the table.
    """
    from gonio.dataset.nexus import read_dataset
    from gonio.merge.repeatability import read_table
    from gonio.merge.repeatability import repeatability as run
    from gonio.merge.repeatability_text import lines

    check_inputs(table)
    runs = read_table(table)
    check_inputs(*(entry.path for entry in runs))
    found = run([read_dataset(entry.path) for entry in runs], runs)
    if as_json:
        typer.echo(json.dumps({"table": str(table), "runs": len(runs), "results": [q.as_json() for q in found]}))
        return
    for line in lines(found):
        typer.echo(line)


def _told(done: "Merged") -> list[str]:
    """What was done, then what to look at."""
    told = []
    for entry in done.statistics["distributions"]:
        where = f"{entry['channel']}, incident ({entry['incident_deg'][0]:g}, {entry['incident_deg'][1]:g})"
        for one in entry["sets"]:
            told.append(f"gonio: {where}: {one['points']} points of {', '.join(one['passes'])}{_counts(one['counts'])}")
            told += [f"gonio:   {_pair(pair)}" for pair in one["overlaps"]]
            told += [f"gonio:   {_border(border)}" for border in one["seams"]]
        if pairs := entry.get("mean_of_s_and_p"):
            told.append(f"gonio:   mean of s and p at {pairs['paired']} points, {pairs['unpaired']} without partner")
    for rig in done.statistics["retro"]:
        for entry in rig["distributions"]:
            theta, phi = entry["incident_deg"]
            told.append(
                f"gonio: {rig['source']}: incident ({theta:g}, {phi:g}): {entry['points']} points to "
                f"{entry['radius_deg']:.2f} degrees from retro take the place of {entry['points_removed_elsewhere']}; "
                f"reference beam +- {entry['reference_u_rel']:.2%}"
            )
    return told + [f"gonio: {remark}" for remark in done.remarks]


def _counts(counts: dict[str, int]) -> str:
    words = {
        "weighted": "weighted against another session",
        "repeated": "there twice, used once",
        "masked_but_measured": "masked in one session and measured in another",
    }
    return "".join(f"; {counts[name]} {text}" for name, text in words.items() if counts.get(name))


def _pair(pair: dict[str, Any]) -> str:
    return (
        f"{pair['one']} / {pair['other']} = {pair['ratio']:.4f} +- {pair['ratio_u']:.4f} over {pair['points']} points, "
        f"offset {pair['offset_in_u']:+.1f} u, chi2/dof {pair['chi2_per_dof']:.2f}, of noise alone "
        f"{pair['noise_chi2_per_dof']:.2f}"
    )


def _border(border: dict[str, Any]) -> str:
    return (
        f"seam {border['one']} | {border['other']}: log ratio {border['mean_log_ratio']:+.4f} +- "
        f"{border['mean_log_ratio_u']:.4f} (rms {border['rms_log_ratio']:.4f}) at {border['places']} places, "
        f"step {border['step_in_u']:+.1f} u"
    )


def _numbers(text: str, option: str, allowed: tuple[int, ...]) -> list[float]:
    from math import isfinite

    from gonio.units.errors import UsageError

    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) not in allowed or not all(isfinite(value) and value >= 0.0 for value in values):
        raise UsageError(
            f"{option} {text}: wants {' or '.join(str(n) for n in allowed)} numbers of 0 or more, with commas"
        )
    return values


def _plate(text: str | None) -> "Plate | None":
    from gonio.merge.retro import Plate
    from gonio.units.errors import UsageError

    if text is None:
        return None
    rs, rp, ts, tp = _numbers(text, "--plate", (4,))
    if rs + ts > 1.0 or rp + tp > 1.0 or not rs * ts + rp * tp > 0.0:
        raise UsageError(f"--plate {text}: R + T must be 1 at most for s and for p, and some light must come through")
    return Plate(rs, rp, ts, tp)
