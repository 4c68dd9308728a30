"""bench_sim.py: the photon map beside Radiance in one run: a table and bench_sim.json. `make bench-sim` runs it.

bench_sim.py FOLDER [--quick]: --quick takes few photons and says nothing about speed.
"""

import argparse
import json
import statistics
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from bench import machine, row
from sim.directions import even_directions
from sim.louver import Louver
from sim.scene import RECEIVER_MM, Beam

from gonio.formats.window.klems import BASES
from sim import klems, photon_map, radiance

INCIDENT_DEG = (45.0, 90.0)
BANDWIDTH = 2000
RELATIVE_ERROR = BANDWIDTH**-0.5  # of Radiance's readings: 2.2 %
THREADS = 2
DEPTH_MM = 12.0  # of the louver


@dataclass(frozen=True)
class Size:
    """How much work."""

    photons: int  # stored
    directions: int
    runs: int
    bias_seeds: int
    bias_photons: int
    genbsdf_samples: tuple[int, int]
    reference_photons: int  # per incident patch
    facets: int  # flat strips per section of a slat, for Radiance


# With 40 facets tau is within 0.2 % of that of 200, and oconv takes seconds, not a minute.
FULL = Size(8_000_000, 250_000, 3, 16, 2_000_000, (25, 100), 400_000, 40)
QUICK = Size(50_000, 5_000, 1, 2, 50_000, (1, 2), 4_000, 8)


class Ours:
    """Jobs on our photon map, each in its own process."""

    def __init__(self, folder: Path, louver: Louver) -> None:
        self.folder = folder
        folder.mkdir()
        (folder / "louver.toml").write_text(louver.scenario(photons=1000))

    def run(self, work: str, **job: Any) -> tuple[dict[str, Any], radiance.Usage]:
        """Its result, and what the whole process took."""
        job |= {"work": work, "scenario": str(self.folder / "louver.toml"), "threads": THREADS}
        (self.folder / "job.json").write_text(json.dumps(job))
        script = str(Path(__file__).with_name("sim") / "ours.py")
        usage = radiance.run([sys.executable, script, "job.json"], self.folder)
        return json.loads(usage.output), usage


@dataclass
class Peer:
    """Radiance's photon map and readings of the same louver; None where pyradiance is not installed."""

    made: photon_map.PhotonMap
    read: radiance.Usage
    bias: float
    through_port: float


def peer_run(folder: Path, size: Size, louver: Louver) -> Peer | None:
    if radiance.folder() is None:
        return None
    through = photon_map.through_port(folder / "mirror", size.photons // 8)
    made = photon_map.make(louver.radiance(size.facets), INCIDENT_DEG, size.photons, folder / "map", workers=THREADS)
    irradiance, usage = made.read(even_directions(size.directions), BANDWIDTH, THREADS)
    integral = float(np.mean(irradiance)) * 4 * np.pi * RECEIVER_MM**2
    # The light that is in the map: the photons that were stored, each with its part of the lamp's power.
    return Peer(made, usage, integral / (Beam().power * made.stored / made.emitted) - 1, through)


def of(peer: Peer | None, value: Any) -> float | None:
    return None if peer is None else float(value(peer))


def photons_and_readings(ours: Ours, peer: Peer | None, size: Size) -> tuple[list[dict[str, Any]], list[str]]:
    """Photons through the louver, stored, read; streamed; memory; bias."""
    walks = {
        name: [ours.run("walk", photons=size.photons, embree=embree)[0] for _ in range(size.runs)]
        for name, embree in (("fast slat walk", False), ("Embree walk", True))
    }
    share = walks["Embree walk"][0]["stored_share"]
    photons = round(size.photons / share)
    common = {"photons": photons, "directions": size.directions, "relative_error": RELATIVE_ERROR}
    half_angle = ours.run("stored", half_angle_rad=0, **common)[0]["half_angle_rad"]
    common["half_angle_rad"] = half_angle
    maps = {
        name: [ours.run("stored", embree=embree, **common) for _ in range(size.runs)]
        for name, embree in (("fast slat walk", False), ("Embree walk", True))
    }
    streams = [ours.run("streamed", **common) for _ in range(size.runs)]
    many = ours.run("streamed", **(common | {"photons": 4 * photons}))[1]
    found, _ = ours.run(
        "bias", photons=size.bias_photons, directions=size.directions, seeds=size.bias_seeds, half_angle_rad=half_angle
    )
    differences = 100 * np.array(found["differences"])

    def median(name: str, part: str, key: str) -> float:
        return statistics.median(run[part][key] for run, _ in maps[name])

    rows = []
    tools = "Radiance mkpmap + rtrace"
    for name in maps:
        for key, unit in (("wall_s", "s wall"), ("cpu_s", "s cpu")):
            other = of(peer, lambda p, key=key: getattr(p.made.usage, key) + getattr(p.read, key))
            rows.append(row(f"photons, map and readings, {name}", unit, median(name, "whole", key), other, tools,
                            size.runs, high=False))  # fmt: skip
    for key, unit in (("wall_s", "s wall"), ("cpu_s", "s cpu")):
        time_s = statistics.median(run["whole"][key] for run, _ in streams)
        other = of(peer, lambda p, key=key: getattr(p.made.usage, key) + getattr(p.read, key))
        rows.append(row("photons streamed through the apertures", unit, time_s, other, tools, size.runs, high=False))
    for name, runs in walks.items():
        rate = statistics.median(size.photons / run["wall_s"] / 1e6 for run in runs)
        other = of(peer, lambda p: p.made.emitted * p.through_port / p.made.usage.wall_s / 1e6)
        rows.append(row(f"photons through the aperture, {name}", "M/s", rate, other, "mkpmap", size.runs, high=True))
        per_million = statistics.median(run["cpu_s"] / size.photons * 1e6 for run in runs)
        other = of(peer, lambda p: p.made.usage.cpu_s / (p.made.emitted * p.through_port / 1e6))
        rows.append(row(f"the same, {name}", "s cpu/M", per_million, other, "mkpmap", size.runs, high=False))
    for key, unit in (("wall_s", "s wall"), ("cpu_s", "s cpu")):
        other = of(peer, lambda p, key=key: getattr(p.read, key))
        rows.append(row("readings from the stored map", unit, median("fast slat walk", "read", key), other, "rtrace",
                        size.runs, high=False))  # fmt: skip
    mean, error = float(np.mean(differences)), float(np.std(differences, ddof=1) / len(differences) ** 0.5)
    rows += [
        row("bias of the hemispherical integral", "%", abs(mean),
            of(peer, lambda p: abs(100 * p.bias)), "mkpmap + rtrace, 1 seed",
            size.bias_seeds, high=False),
        row("peak memory, stored", "MiB", statistics.median(u.peak_mib for _, u in maps["fast slat walk"]),
            of(peer, lambda p: max(p.made.usage.peak_mib, p.read.peak_mib)), tools, size.runs, high=False),
        row("peak memory, streamed", "MiB", statistics.median(u.peak_mib for _, u in streams),
            of(peer, lambda p: max(p.made.usage.peak_mib, p.read.peak_mib)), tools, size.runs, high=False),
        row("peak memory, streamed, 4 x the photons", "MiB", many.peak_mib, None, tools, 1, high=False),
    ]  # fmt: skip
    one = maps["fast slat walk"][0][0]
    notes = [
        f"{photons / 1e6:.2f} M photons emitted, {one['stored'] / 1e6:.2f} M stored; {size.directions} directions",
        f"aperture of the readings {np.degrees(half_angle):.3f} degrees (half angle), median of the {one['lit']} lit "
        f"ones: {one['median_hits']:.0f} hits, standard error {100 * one['median_error']:.2f} %",
        f"bias: ours {mean:+.4f} % with a standard error of {error:.4f} %",
    ]
    if peer is not None:
        notes.append(f"Radiance: {size.facets} facets per section, {peer.made.stored / 1e6:.2f} M of "
                     f"{peer.made.emitted * peer.through_port / 1e6:.2f} M photons stored, "
                     f"bandwidth {BANDWIDTH}")  # fmt: skip
    return rows, notes


def klems_matrices(ours: Ours, folder: Path, size: Size, louver: Louver) -> tuple[list[dict[str, Any]], list[str]]:
    """Klems full, all 145 incident patches of both sides, at the standard error of genBSDF's 2000 samples.

    genBSDF's error and time at two small numbers of samples, against our matrix of many photons: the part of the
    squared error that falls as 1 / samples is extrapolated (what remains, facets and bounces left out, is not held
    against it), time grows in proportion to the samples.
    """
    basis = BASES["klems-full"]
    common = {"patches": basis.bounds_deg.tolist(), "out": str(folder / "ours.npz")}
    if radiance.folder() is None:
        took, _ = ours.run("klems", photons=size.reference_photons // 10, **common)
        name = f"Klems full, {size.reference_photons // 10} photons per incident patch"
        return [row(name, "s wall", took["wall_s"], None, "genBSDF", 1, high=False)], []
    ours.run("klems", photons=size.reference_photons, seed=99, **common)
    reference = np.load(common["out"])["share"]
    per_photon = float(np.mean(np.load(common["out"])["error"] ** 2)) * size.reference_photons
    squares, usages = [], []
    for samples in size.genbsdf_samples:
        matrices, usage = klems.generate(
            louver.radiance(size.facets), folder / "genbsdf", samples=samples, depth_mm=DEPTH_MM,
            cell_mm=(louver.pitch_mm, louver.pitch_mm), workers=THREADS,
        )  # fmt: skip
        squares.append(float(np.mean((klems.shares(matrices, basis) - reference) ** 2)))
        usages.append(usage)
    few, more = size.genbsdf_samples
    per_sample = (squares[0] - squares[1]) / (1 / few - 1 / more)
    target = per_sample / klems.DEFAULT_SAMPLES
    photons = int(np.ceil(per_photon / target))
    took, _ = ours.run("klems", photons=photons, **common)
    rows = []
    for key, unit in (("wall_s", "s wall"), ("cpu_s", "s cpu")):
        slope = (getattr(usages[1], key) - getattr(usages[0], key)) / (more - few)
        peer = getattr(usages[1], key) + slope * (klems.DEFAULT_SAMPLES - more)
        rows.append(row("Klems full at genBSDF's error of 2000 samples", unit, took[key], peer,
                        "genBSDF, extrapolated", 1, high=False))  # fmt: skip
    return rows, [
        f"Klems: {photons} photons per incident patch; root mean square error per element of both {target**0.5:.2e} of "
        f"the incident light; genBSDF measured {squares[0] ** 0.5:.2e} at {few} samples ({usages[0].cpu_s:.1f} s cpu), "
        f"{squares[1] ** 0.5:.2e} at {more} ({usages[1].cpu_s:.1f} s cpu)"
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", nargs="?", default="build/bench", type=Path)
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    size = QUICK if options.quick else FULL
    options.out.mkdir(parents=True, exist_ok=True)
    louver = Louver()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        ours = Ours(folder / "ours", louver)
        rows, notes = photons_and_readings(ours, peer_run(folder, size, louver), size)
        more_rows, more_notes = klems_matrices(ours, folder, size, louver)
    rows += more_rows
    text = {
        "bench": "bench_sim",
        "machine": machine(),
        "quick": options.quick,
        "rows": rows,
        "notes": notes + more_notes,
    }
    (options.out / "bench_sim.json").write_text(json.dumps(text, indent=1) + "\n")
    lines = [f"{'':52} {'unit':7} {'ours':>10} {'peer':>10} {'ratio':>8}  peer"]
    for line in rows:
        peer, ratio = ("not run", "-") if line["peer"] is None else (f"{line['peer']:.3g}", f"{line['ratio']:.3g}")
        lines.append(
            f"{line['name']:52} {line['unit']:7} {line['ours']:10.3g} {peer:>10} {ratio:>8}  {line['peer_name']}"
        )
    sys.stdout.write("\n".join([*lines, *notes, *more_notes]) + "\n")


if __name__ == "__main__":
    main()
