"""through_radiance.py: what Radiance reads in an XML file: its BSDF library asked in a process of its own.

One process per file: the library can crash when one process loads many.
"""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np

from gonio.dataset.scattering import FloatArray
from gonio.geometry.directions import angles_deg_from_unit

# Arguments: file, queries (m, 4) as .npy, answers as .npy, incident directions (j, 2) whose integrals are printed.
_ASK = """
import json, sys
import numpy as np
import pyradiance.bsdf as b
sd = b.load_file(sys.argv[1])
asked = np.load(sys.argv[2])
np.save(sys.argv[3], np.array([b.query(sd, *map(float, q))[1] for q in asked]))
print(json.dumps([float(b.direct_hemi(sd, t, p, b.SAMPLE_ALL)) for t, p in json.loads(sys.argv[4])]))
"""


def read(path: Path, incident_deg: tuple[float, float], outgoing: FloatArray, folder: Path) -> tuple[FloatArray, float]:
    """DSF [1/sr] (m,) towards outgoing (m, 3), and the sum of the hemispherical integrals, both for one incident
    direction; Radiance's frame, which is the sample's where the front faces the interior. RuntimeError if it fails."""
    theta, phi = angles_deg_from_unit(outgoing)
    count = len(theta)
    asked = np.column_stack((np.full(count, incident_deg[0]), np.full(count, incident_deg[1]), theta, phi))
    np.save(folder / "asked.npy", asked)
    done = subprocess.run(
        [sys.executable, "-c", _ASK, str(path.resolve()), "asked.npy", "answers.npy", json.dumps([incident_deg])],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise RuntimeError(f"{path.name}: pyradiance ends with {done.returncode}: {done.stderr.strip()[-300:]}")
    bsdf = np.load(folder / "answers.npy")
    return bsdf * np.abs(outgoing[:, 2]), float(json.loads(done.stdout)[0])
