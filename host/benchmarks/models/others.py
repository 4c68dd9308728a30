"""others.py: judges beside the retro coating: two lopsided peaks at five azimuths, the louver of the twin, PTFE."""

from pathlib import Path
from typing import Any

import numpy as np

from gonio.dataset.bsdf import Dataset
from gonio.dataset.scattering import FloatArray
from gonio.geometry.directions import unit_from_angles_deg

from . import measured, metrics, ours, radiance_chain, through_radiance
from .ceilings import DenseTree
from .points import cap, sampled
from .samples import TwoPeaked
from .size import Size
from .table import line

Rows = list[dict[str, Any]]
TWO_PEAKED_DEG = tuple((t, p) for t in (15.0, 35.0, 55.0) for p in (270.0, 315.0, 0.0, 45.0, 90.0))
TWO_PEAKED_JUDGED_DEG = ((35.0, 45.0), (35.0, 90.0), (45.0, 20.0))
_UPPER, _WEIGHT = metrics.hemisphere()


def two_peaked(folder: Path, size: Size) -> tuple[Rows, list[str]]:
    """Anisotropic: two measured incident directions and one between, over the whole hemisphere; both peaks."""
    sample = TwoPeaked()
    dataset = sampled(sample, TWO_PEAKED_DEG, size.points, symmetry="bilateral")
    chain, made = radiance_chain.fit(dataset, folder / "radiance"), ours.fit(dataset, folder / "ours")
    k = size.anisotropic_k
    peer_tree = chain.tree(k)
    tree = made.tree(4, k + 1, peer_tree.stat().st_size / 1e6)
    rows: Rows = []
    for incident in TWO_PEAKED_JUDGED_DEG:
        toward = unit_from_angles_deg([incident[0]], [incident[1]])
        centres = [facet.centre(toward)[0] for facet in sample.facets]
        outgoing = np.concatenate([_UPPER[::8], *(cap(1000, c, 3.0 * f.sigma_deg)
                                                   for c, f in zip(centres, sample.facets, strict=True))])  # fmt: skip
        outgoing = outgoing[outgoing[:, 2] > 0.05]
        ground = outgoing[:, None] @ np.array(centres).T
        strong, weak = (np.argmax(ground[:, 0, number]) for number in (0, 1))
        truth = sample.dsf_per_sr(toward, outgoing)
        found = {
            "model": made.query(made.model, incident, outgoing),
            "tree": through_radiance.read(tree, incident, outgoing, folder)[0],
        }
        peer = through_radiance.read(peer_tree, incident, outgoing, folder)[0]
        dense = DenseTree(sample, k, isotropic=False, order=4).dsf_per_sr(toward[0], outgoing)
        even = len(_UPPER[::8][_UPPER[::8, 2] > 0.05])
        for which, values in found.items():
            name = f"two peaks {incident[0]:g}/{incident[1]:g} {which}"
            rows += _field_lines(
                name, truth[:even], values[:even], peer[:even], _WEIGHT[::8][:even], f"Radiance -g {k}"
            )
            for peak, at in (("strong", strong), ("weak", weak)):
                rows.append(line(f"{name}: {peak} peak kept", "%", 100 * values[at] / truth[at],
                                 100 * peer[at] / truth[at], "kept", peer_name=f"Radiance -g {k}",
                                 beside={f"dense k={k}": 100 * dense[at] / truth[at]}))  # fmt: skip
    rows.append(line("two peaks tree file", "MB", tree.stat().st_size / 1e6, peer_tree.stat().st_size / 1e6, "low",
                     peer_name=f"Radiance -g {k}"))  # fmt: skip
    return rows, [_took("two peaks", made, chain)]


def louver(folder: Path, size: Size, cache: Path) -> tuple[Rows, list[str]]:
    """The middle incident direction left out; transmission and reflection apart."""
    whole = measured.louver(cache, size.photons)
    rest = measured.without(whole, *measured.LOUVER_LEFT_OUT_DEG)
    k = size.anisotropic_k
    return _predicted("louver", whole, rest, [measured.LOUVER_LEFT_OUT_DEG], folder, k)


def ptfe(folder: Path, size: Size) -> tuple[Rows, list[str]]:
    """Incident polar angles left out together, predicted at the points that NIST measured."""
    whole = measured.ptfe()
    rest = whole
    for theta in measured.PTFE_LEFT_OUT_DEG:
        rest = measured.without(rest, theta)
    asked = [(d.incident_theta_deg, d.incident_phi_deg) for d in whole.distributions
             if round(d.incident_theta_deg) in measured.PTFE_LEFT_OUT_DEG]  # fmt: skip
    return _predicted("PTFE", whole, rest, asked, folder, size.resolutions[0])


def _predicted(
    name: str, whole: Dataset, rest: Dataset, asked: list[tuple[float, float]], folder: Path, k: int
) -> tuple[Rows, list[str]]:
    """Directions left out, at the points that were measured there."""
    chain, made = radiance_chain.fit(rest, folder / "radiance"), ours.fit(rest, folder / "ours")
    peer_tree = chain.tree(k)
    rows: Rows = []
    for incident in asked:
        truth = next(d for d in whole.distributions
                     if (d.incident_theta_deg, d.incident_phi_deg) == incident and d.measured.any())  # fmt: skip
        unit = unit_from_angles_deg(truth.theta_deg, truth.phi_deg)
        mine = made.query(made.model, incident, unit)
        peer, _ = through_radiance.read(peer_tree, incident, unit, folder)
        for side, z in (("reflection", 1.0), ("transmission", -1.0)):
            used = truth.measured & (truth.solid_angle_sr > 0.0) & (unit[:, 2] * z > 0.02)
            if np.count_nonzero(used):
                label = f"{name} {incident[0]:g}/{incident[1]:g} left out, {side}, model"
                rows += _field_lines(label, truth.dsf_per_sr[used], mine[used], peer[used],
                                     truth.solid_angle_sr[used], f"Radiance -g {k}")  # fmt: skip
    return rows, [_took(name, made, chain)]


def _field_lines(
    name: str, truth: FloatArray, found: FloatArray, peer: FloatArray, weight_sr: FloatArray, peer_name: str
) -> Rows:
    mine, theirs = metrics.field(truth, found, weight_sr), metrics.field(truth, peer, weight_sr)
    rows = [
        line(f"{name}: CV(RMSD)", "", mine.cv, theirs.cv, "low", peer_name=peer_name),
        line(f"{name}: highest value kept", "%", mine.peak_kept, theirs.peak_kept, "kept", peer_name=peer_name),
        line(f"{name}: integral", "% error", mine.integral_error, theirs.integral_error, "error", peer_name=peer_name),
    ]
    for number, percent in enumerate(metrics.SHARES_PERCENT):
        rows.append(line(f"{name}: within {percent} %", "%", mine.within[number], theirs.within[number], "high",
                         peer_name=peer_name))  # fmt: skip
    return rows


def _took(name: str, made: ours.Ours, chain: radiance_chain.Chain) -> str:
    def cpu(steps: dict[str, Any]) -> str:
        return ", ".join(f"{step} {usage.cpu_s:.2f}" for step, usage in steps.items())

    return f"{name}: s cpu: ours {cpu(made.steps)}; Radiance {cpu(chain.steps)}"
