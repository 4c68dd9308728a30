"""repeatability.py: results of one sample, measured again and again: which step makes them scatter, and whether the
stated uncertainties say so."""

import csv
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Distribution
from gonio.dataset.effects import effect_of
from gonio.merge.variance_components import Analysis, analyse
from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]

COLUMNS = ("file", "mount", "position", "day")
NESTING = ("day", "mount", "position")  # outermost first
LEVELS = (*NESTING, "repeat")
_RESULTS = ("tau_measured", "rho_measured", "tau_direct", "rho_direct", "tau_diffuse", "rho_diffuse")
_OF_PEAK = ("theta_deg", "height_per_sr", "sigma_deg", "integral")
_EXPLAINED = 0.05  # probability below which scatter is not explained
# No run's samples fall where another's do: what lies between and beyond them is each run's own.
_OF_RUN = ("independent", "quadrature", "coverage")


@dataclass(frozen=True)
class Run:
    """One row of the table: a dataset's place and its labels, outermost first."""

    path: Path
    labels: tuple[str, ...]


@dataclass(frozen=True)
class Scatter:
    """A chi-square of the results about their mean, against stated uncertainties: with what results share left out of
    their differences. `probability` of at least so much scatter, were they right."""

    chi2: float
    dof: int
    probability: float
    stated_u: float  # median of the results'
    budgets: bool  # whether the results said what they share: else all of the uncertainty was taken as their own

    @property
    def explained(self) -> bool:
        """Whether the uncertainties explain the scatter."""
        return self.probability >= _EXPLAINED


@dataclass(frozen=True)
class Quantity:
    """One result of one channel and incident direction over all runs."""

    channel: str
    incident_deg: tuple[float, float]
    name: str
    analysis: Analysis
    scatter: Scatter | None

    def as_json(self) -> dict[str, Any]:
        """Plain values; what the design does not tell is null."""
        scatter = None if self.scatter is None else asdict(self.scatter) | {"explained": self.scatter.explained}
        return {
            "channel": self.channel,
            "incident_deg": list(self.incident_deg),
            "name": self.name,
            "mean": self.analysis.mean,
            "count": self.analysis.count,
            "u_of_mean": float(np.sqrt(self.analysis.variance_of_mean)),
            "components": [asdict(component) for component in self.analysis.components],
            "scatter": scatter,
        }


def read_table(path: Path) -> list[Run]:
    """Rows of a CSV table with the columns file, mount, position, day; files lie beside it. Raises UsageError."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as text:
            reader = csv.DictReader(text)
            missing = [name for name in COLUMNS if name not in (reader.fieldnames or ())]
            if missing:
                raise UsageError(f"{path}: no column {', '.join(missing)}: the first line names {','.join(COLUMNS)}")
            runs = []
            for row in reader:
                if any(not row[name] for name in COLUMNS):
                    raise UsageError(
                        f"{path}: line {reader.line_num}: an empty cell: every run has {','.join(COLUMNS)}"
                    )
                labels = tuple(row[name].strip() for name in NESTING)
                runs.append(Run(path.parent / row["file"].strip(), labels))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise UsageError(f"{path}: cannot be read as a table ({error}): save it as CSV, UTF-8") from error
    if len(runs) < 2:
        raise UsageError(f"{path}: {len(runs)} runs: scatter needs two or more")
    return runs


def repeatability(datasets: Sequence[Dataset], runs: Sequence[Run]) -> list[Quantity]:
    """Analysis of every result that all datasets have, in the order of the first one."""
    names = {dataset.sample_name for dataset in datasets}
    if len(names) > 1:
        one, two = sorted(names)[:2]
        raise UsageError(f'the table names datasets of different samples ("{one}", "{two}"): repeats are of one sample')
    found = []
    for first in datasets[0].distributions:
        place = _place(first)
        same = [next((d for d in dataset.distributions if _place(d) == place), None) for dataset in datasets]
        alike = [d for d in same if d is not None]
        if len(alike) < len(datasets):
            continue
        for name in _names(first):
            if all(name in d.integrals for d in alike):
                found.append(_quantity(name, alike, runs))
    if not found:
        raise UsageError(
            "the datasets have no result in common: channel, planned incident direction and name must agree"
        )
    return found


def _place(distribution: Distribution) -> tuple[str, float, float]:
    return distribution.channel, distribution.incident_theta_deg, distribution.incident_phi_deg


def _names(distribution: Distribution) -> list[str]:
    known = distribution.integrals
    peaks = [name for name in known if name.startswith("peak ") and name.rpartition(" ")[2] in _OF_PEAK]
    cones = [name for name in known if name.startswith("cone ") and not name.endswith(("_u", "_measured_share"))]
    return [*(name for name in _RESULTS if name in known), *cones, *peaks]


def _quantity(name: str, distributions: Sequence[Distribution], runs: Sequence[Run]) -> Quantity:
    values = np.array([d.integrals[name] for d in distributions])
    first = distributions[0]
    return Quantity(
        channel=first.channel,
        incident_deg=(first.incident_theta_deg, first.incident_phi_deg),
        name=name,
        analysis=analyse(values, [run.labels for run in runs], LEVELS),
        scatter=_scatter(name, values, distributions, runs),
    )


def _scatter(
    name: str, values: FloatArray, distributions: Sequence[Distribution], runs: Sequence[Run]
) -> Scatter | None:
    """Chi-square about the generalised least-squares mean; None where a result states no uncertainty."""
    from scipy.stats import chi2 as chi2_distribution  # noqa: PLC0415 - scipy's statistics load slowly

    stated = np.array([_stated_u(name, d) for d in distributions])
    if not np.all(stated > 0.0):
        return None
    budgets = [_budget(name, d) for d in distributions]
    have = all(budgets)
    covariance = _covariance(budgets, runs) if have else np.diag(stated**2)
    if not np.all(np.diag(covariance) > 0.0):
        return None  # all that is stated is shared by all: nothing said about scatter
    precision = np.linalg.pinv(covariance, hermitian=True)
    ones = np.ones(len(values))
    mean = float(ones @ precision @ values) / float(ones @ precision @ ones)
    chi2 = float((values - mean) @ precision @ (values - mean))
    dof = len(values) - 1
    return Scatter(chi2, dof, float(chi2_distribution.sf(chi2, dof)), float(np.median(stated)), have)


def _stated_u(name: str, distribution: Distribution) -> float:
    """X_u beside X; rho_u, tau_u of the hemispheres' sums, as they are also named."""
    known = distribution.integrals
    return known.get(f"{name}_u", known.get(f"{name.partition('_measured')[0]}_u", 0.0))


def _budget(name: str, distribution: Distribution) -> Mapping[str, float]:
    return distribution.budgets.get(name) or distribution.budgets.get(name.partition("_measured")[0]) or {}


def _covariance(budgets: Sequence[Mapping[str, float]], runs: Sequence[Run]) -> FloatArray:
    """Covariance (n, n) of the results' differences: effects of the instrument are common to all and left out, those of
    a mounting are common to runs of one day and mount; noise, quadrature and what a session shares are each run's
    own."""
    mounts = [run.labels[:2] for run in runs]
    same_mount = np.array([[float(a == b) for b in mounts] for a in mounts])
    found = np.zeros((len(runs), len(runs)))
    for key in dict.fromkeys(key for budget in budgets for key in budget):
        part = np.array([budget.get(key, 0.0) for budget in budgets])
        effect = effect_of(key)
        if key in _OF_RUN or effect.reach == "session":
            found += np.diag(part**2)
        elif effect.reach == "mount":
            found += np.outer(part, part) * same_mount
    return found
