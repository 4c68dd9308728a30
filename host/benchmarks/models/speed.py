"""speed.py: processor time, memory and file sizes of fit, tensor tree and Klems matrix, and who loads the matrix."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

from . import metrics, ours, radiance_chain, retro, through_radiance
from .samples import RetroCoating
from .size import Size
from .table import line

Rows = list[dict[str, Any]]

# Arguments: file. Prints the direct-hemispherical visible reflectance of the front at normal incidence.
_WINDOW = """
import sys
import pywincalc as p
product = p.parse_bsdf_xml_file(sys.argv[1])
standard = p.load_standard(str(p.standard_path / "W5_NFRC_2003.std"))
basis = p.BSDFHemisphere.create(p.BSDFBasisType.FULL)
system = p.GlazingSystem(optical_standard=standard, solid_layers=[product], bsdf_hemisphere=basis)
found = system.optical_method_results("PHOTOPIC", 0.0, 0.0).system_results
print(found.back.reflectance.direct_hemispherical)
"""


def judge(folder: Path, size: Size) -> tuple[Rows, list[str]]:
    """Eight directions of size.many_points; targets in processor seconds of whole processes."""
    sample = RetroCoating()
    measured = retro.dataset(sample, size.many_points)
    made, chain = ours.fit(measured, folder / "ours"), radiance_chain.fit(measured, folder / "radiance")
    k = size.resolutions[0]
    tree, peer_tree = made.tree(3, k), chain.tree(k)
    klems, peer_klems = made.klems(), chain.klems()
    names = {
        f"model fit of 8 x {size.many_points} points": ("fit", "fit front_reflection", "pabopto2bsdf", 2.0),
        f"tensor tree k = {k} from the fit": (tree.stem, f"tree{k}", "bsdf2ttree", 3.0),
        "Klems full from the fit": ("klems", "klems", "bsdf2klems", 5.0),
    }
    rows: Rows = []
    for name, (mine, theirs, peer_name, target) in names.items():
        took, peer = made.steps[mine], chain.steps[theirs]
        rows.append(line(name, "s cpu", took.cpu_s, peer.cpu_s, "low", target=target, peer_name=peer_name))
        rows.append(line(f"{name}: memory", "MiB", took.peak_mib, peer.peak_mib, "low", peer_name=peer_name))
    files = {"model file": (made.model, chain.fits[0]), "tree file": (tree, peer_tree), "Klems": (klems, peer_klems)}
    rows += [line(f"{name}, size", "MB", a.stat().st_size / 1e6, b.stat().st_size / 1e6, "low", peer_name="Radiance")
             for name, (a, b) in files.items()]  # fmt: skip
    return rows, [*loads(klems, folder), f"Radiance's own Klems file: {'; '.join(loads(peer_klems, folder))}"]


def loads(klems: Path, folder: Path) -> list[str]:
    """Whether the engine of WINDOW and Radiance load a Klems file, and what they say of normal incidence."""
    done = subprocess.run([sys.executable, "-c", _WINDOW, str(klems)], capture_output=True, text=True, check=False)
    said = done.stdout.strip() if done.returncode == 0 else f"does not load it (exit {done.returncode})"
    answers = [f"pywincalc, reflectance at normal incidence: {said}"]
    try:
        _, integral = through_radiance.read(klems, (0.0, 0.0), metrics.plane(0.0)[:1], folder)
        answers.append(f"Radiance, the same: {json.dumps(round(integral, 5))}")
    except RuntimeError as error:
        answers.append(f"Radiance does not load it: {error}")
    return answers
