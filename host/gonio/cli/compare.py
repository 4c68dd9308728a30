"""compare.py: the command compare: how far two datasets, or a dataset and a model, agree."""

# ruff: noqa: PLC0415 - a command imports what it needs when it runs: --help stays fast

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gonio.cli.device import JsonOption
from gonio.cli.options import Front
from gonio.cli.places import check_inputs, check_outputs

if TYPE_CHECKING:
    from gonio.compare.result import Comparison, Settings
    from gonio.dataset.bsdf import Dataset, Distribution, Side
    from gonio.dataset.scattering import Bsdf, Scattering
    from gonio.simulate.closed_form import Truth


def register(app: typer.Typer) -> None:
    """Add the commands of this module."""
    app.command("compare")(compare)


def compare(
    a: Annotated[Path, typer.Argument(metavar="A.h5", help="The reference, a dataset.")],
    b: Annotated[
        Path,
        typer.Argument(
            metavar="B",
            help="What is compared with A: a dataset or table of points, a scenario (.toml), a model that gonio fit "
            "wrote, or BSDF XML with Klems matrices or a tensor tree.",
        ),
    ],
    *,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE.html", help="Also write a report with plots.")
    ] = None,
    as_json: JsonOption = False,
    min_accordance: Annotated[
        float | None,
        typer.Option(
            metavar="PERCENT",
            min=0.0,
            max=100.0,
            help="Exit status 1 if the global accordance of any distribution is lower. 98: good, 99: very good.",
        ),
    ] = None,
    floor: Annotated[
        float,
        typer.Option(
            metavar="DSF", min=0.0, help="Points with A under this [1/sr] are counted apart in the shares within 5 %."
        ),
    ] = 1e-3,
    cone: Annotated[
        float,
        typer.Option(
            metavar="DEG", min=0.0, max=90.0, help="Half angle of the integrals about mirror, retro and through."
        ),
    ] = 7.0,
    tolerance: Annotated[
        float,
        typer.Option(metavar="DEG", min=0.0, max=90.0, help="How far apart incident directions of A and B may lie."),
    ] = 0.5,
    full: Annotated[bool, typer.Option("--full", help="Every metric in all its forms, as --json has them.")] = False,
    signature: Annotated[
        bool,
        typer.Option(
            "--signature",
            help="B.toml in closed form: taken bare, and seen through the free beam that A has measured instead of the "
            "scenario's own.",
        ),
    ] = False,
    front: Annotated[
        Front | None, typer.Option(help="B.xml: side that A's front faces; goes before what A says.")
    ] = None,
) -> None:
    """Compare B with A, the reference, at A's directions.

    Points are paired by index where both have the same (gonio simulate --like writes such), a model is evaluated at
    A's directions (a traced sample is simulated there), any other dataset is interpolated. Exit status: 0, or 1 where
    --min-accordance is not reached.
    """
    from gonio.cli.sources import kind_of
    from gonio.compare.as_json import as_json as to_json
    from gonio.compare.result import Settings
    from gonio.compare.table import overview, text
    from gonio.dataset.nexus import read_dataset
    from gonio.units.errors import UsageError

    check_inputs(a, b)
    check_outputs(output, inputs=[a, b])
    settings = Settings(incident_tolerance_deg=tolerance, floor_per_sr=floor, cone_deg=cone)
    reference = read_dataset(a)
    suffix = b.suffix.lower()
    if suffix == ".toml":
        found = _with_scenario(reference, a, b, settings, signature=signature)
    elif signature:
        raise UsageError(f"{b}: --signature is for a scenario in closed form: leave it out")
    elif (kind := kind_of(b)) in ("dataset", "points"):
        from gonio.compare.comparing import compare_datasets
        from gonio.formats.detect import read_points

        other = read_dataset(b) if kind == "dataset" else read_points([b])
        found = compare_datasets(reference, other, (str(a), str(b)), settings)
    else:
        found = _with_bsdf(reference, a, b, settings, reference.front_faces if front is None else front.value)
    if output is not None:
        from gonio.report.compare_html import write_compare

        write_compare(found, output)
    typer.echo(json.dumps(to_json(found), allow_nan=False) if as_json else text(found) if full else overview(found))
    if output is not None and not as_json:
        typer.echo(output)
    if min_accordance is not None:
        _check(found, min_accordance)


def _with_scenario(reference: "Dataset", a: Path, b: Path, settings: "Settings", *, signature: bool) -> "Comparison":
    """A closed form is evaluated; a traced sample is simulated at A's points."""
    from gonio.compare.comparing import compare_datasets, compare_with_model
    from gonio.compare.per_direction import PerDirection
    from gonio.simulate.bundle import read_document
    from gonio.simulate.closed_form import Truth
    from gonio.units.errors import UsageError

    names, sample = (str(a), str(b)), read_document(b).get("sample")
    if not isinstance(sample, dict) or not sample.keys() & {"kind", "components"}:
        raise UsageError(f"{b}: no sample: give [sample] a kind (traced) or components (closed form)")
    if "kind" not in sample:
        truth = Truth.from_scenario(b)
        model = _seen(truth, reference, a) if signature else PerDirection(truth.dsf_per_sr)
        return compare_with_model(reference, lambda _: model, names, settings, "scenario")
    if signature:
        raise UsageError(
            f"{b}: --signature is for a scenario in closed form: a traced one has its own beam; leave it out"
        )
    from gonio.simulate.progress import PhotonProgress
    from gonio.simulate.request import Request
    from gonio.simulate.simulation import simulate

    with PhotonProgress() as progress:
        done = simulate(Request(scenario=b, like=a), progress)
    for remark in done.remarks:
        typer.echo(f"gonio: {remark}", err=True)
    return compare_datasets(reference, done.dataset, names, settings, "simulation")


def _seen(truth: "Truth", reference: "Dataset", a: Path) -> "Scattering":
    from gonio.compare.per_direction import PerDirection
    from gonio.compare.seen import seen_through
    from gonio.simulate.closed_form import BareTruth
    from gonio.units.errors import UsageError

    if reference.beam is None or not len(reference.beam.theta_deg):
        raise UsageError(f"{a}: holds no scan of the free beam: leave out --signature")
    return seen_through(PerDirection(BareTruth(truth).dsf_per_sr), reference.beam)


def _with_bsdf(reference: "Dataset", a: Path, b: Path, settings: "Settings", faces: "Side") -> "Comparison":
    """A file that answers in any direction. In the frame of A: XML files have their own, which A's front ties to it."""
    from gonio.cli.sources import kind_of, open_bsdf
    from gonio.compare.comparing import compare_with_model
    from gonio.units.errors import UsageError

    kind = kind_of(b)
    in_xml = kind in ("matrices", "tree")
    bsdf = open_bsdf(b, front=faces if in_xml and faces != "undeclared" else None)
    if in_xml and faces == "undeclared":
        raise UsageError(
            f"{a}: it is not declared which way the sample's front faces: give --front exterior or --front interior"
        )
    names = {d.channel for d in reference.distributions}
    remarks = [] if in_xml else [sentence for sentence in bsdf.validity if "extrapolat" in sentence]
    return compare_with_model(
        reference,
        lambda d: channel_for(bsdf, d, names),
        (str(a), str(b)),
        settings,
        kind if kind in ("matrices", "tree") else "model",
        remarks,
    )


def channel_for(bsdf: "Bsdf", distribution: "Distribution", names: set[str]) -> "Scattering | None":
    """The channel of that name; else the only channel that is not solar for the only one that is not."""
    own, others = distribution.channel, set(bsdf.channels) - {"solar"}
    if own in bsdf.channels:
        return bsdf.channels[own]
    return bsdf.channels[others.pop()] if own != "solar" and len(names - {"solar"}) == len(others) == 1 else None


def _check(found: "Comparison", least_percent: float) -> None:
    """CheckFailed where a distribution's accordance is lower, or is not known."""
    from gonio.compare.table import pair_name
    from gonio.units.errors import CheckFailed

    for pair in found.pairs:
        value = pair.metrics["whole"].global_accordance_percent.value if pair.metrics else None
        if value is None or value < least_percent:
            reached = "undefined" if value is None else f"{value:.3f} %"
            raise CheckFailed(
                f"{found.b_name}: {pair_name(pair)}: global accordance {reached}, wanted {least_percent:g} %: see the "
                "metrics"
            )
