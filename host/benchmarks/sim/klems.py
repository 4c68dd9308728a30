"""klems.py: Klems matrices of a sample by Radiance (genBSDF's method: rfluxmtx through pyradiance), in our order."""

import json
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gonio.formats.window import read as window_reader
from gonio.formats.window.klems import KlemsBasis, LightSide, Process, direction_of_patch_deg

from .radiance import Usage, run
from .scene import Scene

FloatArray = NDArray[np.float64]
Matrices = dict[tuple[Process, LightSide], FloatArray]  # BSDF [1/sr], shape (outgoing patches, incident patches)
DEFAULT_SAMPLES = 2000  # genBSDF's own


def generate(
    scene: Scene, where: Path, *, samples: int, depth_mm: float, cell_mm: tuple[float, float],
    workers: int = 2, parameters: tuple[str, ...] = (), basis: str = "kf", front: bool = True,
) -> tuple[Matrices, Usage]:  # fmt: skip
    """The sample's front is the exterior. Rays start on a cell of x by y mm, in the middle; `depth_mm` of the sample.

    `front` False: light from the interior only.
    """
    where.mkdir(parents=True, exist_ok=True)
    (where / "device.rad").write_text(scene.device_text(depth_mm))
    x, y = cell_mm
    job = {
        "box": [-x / 2, x / 2, -y / 2, y / 2, -depth_mm, 0.0],
        "samples": samples,
        "workers": workers,
        "parameters": list(parameters),
        "basis": basis,
        "front": front,
    }
    (where / "job.json").write_text(json.dumps(job))
    script = str(Path(__file__).with_name("genbsdf.py"))
    usage = run([sys.executable, script, "device.rad", "job.json", "bsdf.xml"], where)
    found = window_reader.read(where / "bsdf.xml")
    wanted = ("Front", "Back") if front else ("Back",)
    kept = {
        (process, side): matrix
        for (band, process, side), matrix in found.matrices.items()
        if band == "Visible" and side in wanted
    }
    return kept, usage


def shares(matrices: Matrices, basis: KlemsBasis) -> FloatArray:
    """Share of the light that leaves through each patch, in the order and frame of _photons.PatchMatrix.

    Shape (2: front lit, back lit; incident patches; reflected patches, then transmitted). The front faces the exterior.
    """
    size = basis.size
    result = np.zeros((2, size, 2 * size))
    for (process, side), matrix in matrices.items():
        pairs = [
            direction_of_patch_deg(basis, process, side, row=patch, column=patch, front_faces="exterior")
            for patch in range(size)
        ]
        incident, outgoing = (patch_numbers(basis, [pair[end] for pair in pairs]) for end in (0, 1))
        part = outgoing + (size if process == "Transmission" else 0)
        share = matrix * basis.projected_solid_angle_sr[:, None]
        result[0 if side == "Front" else 1][np.ix_(incident, part)] = share.T
    return result


def patch_numbers(basis: KlemsBasis, directions_deg: list[tuple[float, float]]) -> NDArray[np.int64]:
    """Patches of directions of ours, each about the normal of its own side."""
    theta, phi = np.array(directions_deg).T
    return basis.patch_of(np.minimum(theta, 180 - theta), phi)
