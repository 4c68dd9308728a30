"""photon_map.py: mkpmap's photon map of a scene: its hits, and rtrace's readings from it."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .radiance import Usage, run
from .scene import RECEIVER_MM, Beam, Scene

FloatArray = NDArray[np.float64]
BEAM = Beam()


@dataclass(frozen=True)
class PhotonMap:
    """A map on disk and how it was made."""

    where: Path
    receiver_mm: float
    emitted: float  # photons that left the port: from the last report, which can be a moment old
    stored: int
    usage: Usage

    def hits(self) -> FloatArray:
        """Unit vectors from the sample to the stored photons, sample frame, shape (n, 3)."""
        found = run(["pmapdump", "-a", "-f", "-n", str(self.stored), "map.pm"], self.where).output
        lines = b"\n".join(line for line in found.splitlines() if line.count(b"\t") >= 5)
        values = np.array(lines.split(), dtype=np.float64).reshape(-1, 6)
        if len(values) != self.stored:
            raise RuntimeError(f"pmapdump gave {len(values)} of {self.stored} photons")
        return np.asarray(values[:, :3] / self.receiver_mm, dtype=np.float64)

    def read(self, directions: FloatArray, bandwidth: int, workers: int = 2) -> tuple[FloatArray, Usage]:
        """Irradiance at sensors in these directions (sample frame), in Radiance's own unit, shape (n,)."""
        at = self.receiver_mm * directions
        rays = np.concatenate([at, -directions], 1).astype(np.float32).tobytes()
        command = ["rtrace", "-h", "-I+", "-fff", "-ab", "-1", "-n", str(workers), "-ap", "map.pm", str(bandwidth)]
        usage = run([*command, "-am", "90", "scene.oct"], self.where, rays)
        return np.frombuffer(usage.output, np.float32).reshape(-1, 3)[:, 0].astype(np.float64), usage


def make(
    scene: Scene, incident_deg: tuple[float, float], photons: int, where: Path, *, workers: int = 2,
    seed: int = 0, beam: Beam = BEAM,
) -> PhotonMap:  # fmt: skip
    """Emits until about `photons` are stored on the receiver; the sample's own surfaces store none."""
    where.mkdir(parents=True, exist_ok=True)
    (where / "scene.rad").write_text(scene.text(incident_deg, beam))
    (where / "scene.oct").write_bytes(run(["oconv", "-w", "scene.rad"], where).output)
    command = ["mkpmap", "-apg", "map.pm", str(photons), "-apo", "port", "-aps", "receiver", "-apr", str(seed)]
    for name in scene.modifiers:
        command += ["-ae", name]
    usage = run([*command, "-n", str(workers), "-fo+", "-v+", "-t", "1", "-lr", "5000", "scene.oct"], where)
    words = usage.errors + usage.output.decode(errors="replace")
    emitted = re.findall(r"(\d+) emitted, (\d+) global", words)
    stored = re.search(r"Saving \S+ \((\d+) photons", words)
    if not emitted or stored is None:
        raise RuntimeError(f"mkpmap's report is not understood: {words.strip()[-300:]}")
    kept = int(stored[1])
    return PhotonMap(where, scene.receiver_mm, int(emitted[-1][0]) / int(emitted[-1][1]) * kept, kept, usage)


def through_port(
    where: Path,
    photons: int,
    beam: Beam = BEAM,
    receiver_mm: float = RECEIVER_MM,
) -> float:
    """Share of the emitted photons that reach the sample: a perfect mirror's stored by emitted.

    Radiance emits from a ring's partitions, whose corners lie outside it. tau and rho are relative to this share.
    """
    mirror = Scene(receiver_mm=receiver_mm)
    mirror.material("perfect", "metal", 1, 1, 1, 1, 0)
    mirror.sheet("perfect", 300.0)
    made = make(mirror, (0.0, 0.0), photons, where, beam=beam)
    return made.stored / made.emitted
