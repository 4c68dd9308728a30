"""retro.py: the retro coating in closed form: model and tree files beside Radiance's, ceilings, directions left out."""

from pathlib import Path
from typing import Any

from gonio.dataset.bsdf import Dataset
from gonio.dataset.scattering import FloatArray
from gonio.geometry.directions import unit_from_angles_deg

from . import metrics, ours, radiance_chain, through_radiance
from .ceilings import DenseTree
from .measured import without
from .metrics import Judged
from .points import ARRANGEMENTS, Noise, sampled
from .samples import RetroCoating
from .size import Size
from .table import line

INCIDENT_DEG = (5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0)
JUDGED_DEG = (30.0, 45.0, 60.0)
Rows = list[dict[str, Any]]
_UPPER, _WEIGHT = metrics.hemisphere()


def dataset(sample: RetroCoating, count: int, arrangement: str = "refined", noise: Noise | None = None) -> Dataset:
    """The coating as measured at INCIDENT_DEG."""
    incident = [(theta, 0.0) for theta in INCIDENT_DEG]
    return sampled(sample, incident, count, ARRANGEMENTS[arrangement], noise=noise)


def true_plane(sample: RetroCoating, theta_deg: float) -> FloatArray:
    """DSF [1/sr] of the scatter plane."""
    return sample.dsf_per_sr(unit_from_angles_deg([theta_deg], [0.0]), metrics.plane(0.0))


def true_integral(sample: RetroCoating, theta_deg: float) -> float:
    """Hemispherical reflectance."""
    return float(_WEIGHT @ sample.dsf_per_sr(unit_from_angles_deg([theta_deg], [0.0]), _UPPER))


def of_file(sample: RetroCoating, path: Path, theta_deg: float, folder: Path) -> Judged:
    """A file, read through Radiance."""
    found, integral = through_radiance.read(path, (theta_deg, 0.0), metrics.plane(0.0), folder)
    error = 100.0 * (integral / true_integral(sample, theta_deg) - 1.0)
    return metrics.judged(true_plane(sample, theta_deg), found, error)


def of_model(sample: RetroCoating, made: ours.Ours, theta_deg: float) -> Judged:
    """Our model, read through `gonio query`."""
    found = made.query(made.model, (theta_deg, 0.0), metrics.plane(0.0))
    integral = float(_WEIGHT @ made.query(made.model, (theta_deg, 0.0), _UPPER))
    return metrics.judged(
        true_plane(sample, theta_deg), found, 100.0 * (integral / true_integral(sample, theta_deg) - 1)
    )


def of_dense(sample: RetroCoating, k: int, theta_deg: float) -> Judged:
    """The exact tree of resolution k."""
    incident = unit_from_angles_deg([theta_deg], [0.0])[0]
    return metrics.judged(true_plane(sample, theta_deg), DenseTree(sample, k).dsf_per_sr(incident, metrics.plane(0.0)))


def judge(
    name: str, sample: RetroCoating, measured: Dataset, folder: Path, size: Size, *, targets: bool
) -> tuple[Rows, list[str]]:
    """Model, small tree and large tree at JUDGED_DEG. `targets`: those of the issue stand beside."""
    chain = radiance_chain.fit(measured, folder / "radiance")
    trees = {k: chain.tree(k) for k in size.resolutions}
    first, *others = size.resolutions
    limit_mb = trees[first].stat().st_size / 1e6
    made = ours.fit(measured, folder / "ours")
    small, large = made.tree(3, size.finest, limit_mb), made.tree(3, size.finest, size.large_mb)
    rows: Rows = []
    for theta in JUDGED_DEG:
        peer = of_file(sample, trees[first], theta, folder)
        beside = {f"Radiance -g {k}": of_file(sample, trees[k], theta, folder) for k in others}
        beside |= {f"dense k={k}": of_dense(sample, k, theta) for k in size.ceilings}
        at = f"{name} {theta:g}"
        rows += _lines(
            f"{at} model", of_model(sample, made, theta), peer, {}, (95.0, 0.3, 0, 95.0) if targets else None
        )
        goals = (88.0, 1.5, 1, 90.0) if targets else None
        rows += _lines(f"{at} tree, Radiance's size", of_file(sample, small, theta, folder), peer, beside, goals)
        goals = (93.0, 0.7, 1, 90.0) if targets else None
        rows += _lines(f"{at} tree, {size.large_mb:g} MB", of_file(sample, large, theta, folder), peer, beside, goals)
    for k in others:
        rows.append(_file_line(f"{name} tree file against -g {k}", large, trees[k], f"Radiance -g {k}"))
    rows.append(_file_line(f"{name} tree file", small, trees[first], f"Radiance -g {first}"))
    return rows, _took(name, made, chain)


def left_out(name: str, sample: RetroCoating, measured: Dataset, folder: Path, size: Size, *, targets: bool) -> Rows:
    """Each of size.left_out_deg predicted from the other directions; Radiance's chain the same way."""
    rows: Rows = []
    for theta in size.left_out_deg:
        rest = without(measured, theta)
        chain = radiance_chain.fit(rest, folder / f"radiance_{theta:g}")
        made = ours.fit(rest, folder / f"ours_{theta:g}")
        peer = of_file(sample, chain.tree(size.resolutions[0]), theta, folder)
        found = of_model(sample, made, theta)
        rows += _lines(f"{name} {theta:g} left out, model", found, peer, {}, (90.0, 0.5, 0, None) if targets else None)
    return rows


def _lines(
    name: str,
    found: Judged,
    peer: Judged,
    beside: dict[str, Judged],
    targets: tuple[float, float, int, float | None] | None,
) -> Rows:
    """`targets`: peak kept, CV, which share, that share."""
    peak, cv, which, share = targets or (None, None, None, None)

    def other(value: Any) -> dict[str, float]:
        return {key: value(judged) for key, judged in beside.items()}

    rows = [
        line(f"{name}: peak kept", "%", found.peak_kept, peer.peak_kept, "kept", target=peak,
             beside=other(lambda j: j.peak_kept)),
        line(f"{name}: CV(RMSD)", "", found.cv, peer.cv, "low", target=cv, beside=other(lambda j: j.cv)),
    ]  # fmt: skip
    for number, percent in enumerate(metrics.SHARES_PERCENT):
        rows.append(line(f"{name}: within {percent} %", "%", found.within[number], peer.within[number], "high",
                         target=share if number == which else None,
                         beside=other(lambda j, number=number: j.within[number])))  # fmt: skip
    rows.append(line(f"{name}: width kept", "%", found.width_kept, peer.width_kept, "kept",
                     beside=other(lambda j: j.width_kept)))  # fmt: skip
    if found.integral_error is not None:
        rows.append(line(f"{name}: reflectance", "% error", found.integral_error, peer.integral_error, "error",
                         target=None if targets is None else 0.2))  # fmt: skip
    return rows


def _file_line(name: str, mine: Path, theirs: Path, peer_name: str) -> dict[str, Any]:
    return line(name, "MB", mine.stat().st_size / 1e6, theirs.stat().st_size / 1e6, "low", peer_name=peer_name)


def _took(name: str, made: ours.Ours, chain: radiance_chain.Chain) -> list[str]:
    """What each step took, as notes."""

    def text(steps: dict[str, Any]) -> str:
        return ", ".join(f"{step} {u.cpu_s:.2f} s cpu {u.peak_mib:.0f} MiB" for step, u in steps.items())

    return [f"{name}: ours: {text(made.steps)}", f"{name}: Radiance: {text(chain.steps)}"]
