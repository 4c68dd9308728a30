"""radiance_chain.py: Radiance's own way from measured points to simulation files, with what each step takes.

pabopto2bsdf (one set of files per pair of hemispheres) fits lobes, bsdf2ttree writes a tensor tree, bsdf2klems a
matrix.
"""

from dataclasses import dataclass, field
from pathlib import Path

from benchmarks.sim import radiance
from gonio.dataset.bsdf import Dataset
from gonio.formats.pab import write as pab_write

WORKERS = 1


@dataclass
class Chain:
    """Files and usage (processor seconds, peak MiB) of the steps that were run."""

    folder: Path
    fits: list[Path] = field(default_factory=list)
    steps: dict[str, radiance.Usage] = field(default_factory=dict)

    def tree(self, resolution: int, percent: int = 95) -> Path:
        """Tensor tree of resolution k from which `percent` of the leaves were merged."""
        # Never -t3: whether a sample is isotropic is taken from the fits.
        return self._write(f"tree{resolution}", ["bsdf2ttree", "-g", str(resolution), "-t", str(percent)])

    def klems(self) -> Path:
        """Klems full."""
        return self._write("klems", ["bsdf2klems"])

    def _write(self, name: str, command: list[str]) -> Path:
        usage = radiance.run([*command, *(str(fit) for fit in self.fits)], self.folder)
        self.steps[name] = usage
        path = self.folder / f"{name}.xml"
        path.write_bytes(usage.output)
        return path


def fit(dataset: Dataset, folder: Path) -> Chain:
    """Writes the dataset as pab text and fits each pair of hemispheres."""
    folder.mkdir(parents=True)
    files = pab_write.write(dataset, folder / "pab").paths
    sets: dict[str, list[Path]] = {}
    for path in files:
        sets.setdefault(path.stem.rpartition("_t")[0], []).append(path)
    chain = Chain(folder)
    for kind, paths in sets.items():
        usage = radiance.run(["pabopto2bsdf", "-n", str(WORKERS), *map(str, paths)], folder)
        target = folder / f"{kind}.sir"
        target.write_bytes(usage.output)
        chain.fits.append(target)
        chain.steps[f"fit {kind}"] = usage
    return chain
