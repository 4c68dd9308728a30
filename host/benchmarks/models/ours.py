"""ours.py: our way from a dataset to simulation files, by the real command line, with what each step takes."""

import csv
import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.sim import radiance
from gonio.dataset.bsdf import Dataset
from gonio.dataset.nexus import write_dataset
from gonio.dataset.scattering import FloatArray
from gonio.geometry.directions import angles_deg_from_unit

GONIO = Path(sys.executable).with_name("gonio")


@dataclass
class Ours:
    """Files and usage (processor seconds, peak MiB) of the steps that were run."""

    folder: Path
    steps: dict[str, radiance.Usage] = field(default_factory=dict)

    @property
    def model(self) -> Path:
        """What `gonio fit` wrote."""
        return self.folder / "model.h5"

    def run(self, step: str, *arguments: str | Path) -> radiance.Usage:
        """One command; RuntimeError with its own words if it fails."""
        usage = radiance.run([str(GONIO), *map(str, arguments)], self.folder)
        self.steps[step] = usage
        return usage

    def tree(self, dimensions: int, resolution: int, size_mb: float | None = None) -> Path:
        """Tensor tree of at most 2^k cells along an axis, of the default size or at most `size_mb` million bytes."""
        path = self.folder / f"tree{resolution}_{'default' if size_mb is None else f'{size_mb:.2f}'}.xml"
        limit = [] if size_mb is None else ["--size-mb", f"{size_mb:.3f}"]
        kind = f"tensor{dimensions}"
        self.run(path.stem, "export", self.model, "--format", kind, "-o", path, "--resolution", str(resolution), *limit)
        return path

    def klems(self) -> Path:
        """Klems full, the one channel copied to the other block."""
        path = self.folder / "klems.xml"
        self.run("klems", "export", self.model, "--format", "klems-full", "--assume-flat", "-o", path)
        return path

    def query(self, path: Path, incident_deg: tuple[float, float], outgoing: FloatArray) -> FloatArray:
        """DSF [1/sr] (m,) towards outgoing (m, 3); NaN where `gonio query` has no value."""
        asked, answered = self.folder / "asked.csv", self.folder / "answered.csv"
        theta, phi = angles_deg_from_unit(outgoing)
        with asked.open("w", newline="") as file:
            lines = csv.writer(file)
            lines.writerow(["theta_i_deg", "phi_i_deg", "theta_s_deg", "phi_s_deg"])
            lines.writerows([*incident_deg, t, p] for t, p in zip(theta.tolist(), phi.tolist(), strict=True))
        self.run("query", "query", path, "--table", asked, "-o", answered)
        with answered.open(newline="") as file:
            text = [line["bsdf"] for line in csv.DictReader(row for row in file if not row.startswith("#"))]
        return np.array([float(t) if t else np.nan for t in text]) * np.abs(outgoing[:, 2])


def fit(dataset: Dataset, folder: Path, *options: str) -> Ours:
    """Writes the dataset and fits it; its symmetry is the declared one."""
    folder.mkdir(parents=True)
    ours = Ours(folder)
    write_dataset(dataset, folder / "dataset.h5")
    ours.run("fit", "fit", folder / "dataset.h5", "-o", ours.model, "--symmetry", dataset.symmetry, *options)
    return ours
