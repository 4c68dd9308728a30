"""measured.py: judges without a closed form: a louver from the twin's photon map, and NIST's PTFE.

Both are judged by incident directions that are left out of the fit.
"""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

from gonio.dataset.bsdf import Dataset
from gonio.dataset.nexus import read_dataset
from gonio.formats.tables import nist as nist_csv
from gonio.reduce.imported import reduce_dataset

ROOT = Path(__file__).resolve().parents[3]
SCENARIO = ROOT / "sim" / "scenarios" / "photon" / "louver_v2.toml"
PTFE = ROOT / "docs" / "examples" / "nist_ptfe" / "PTFE.data.csv"
GONIO = Path(sys.executable).with_name("gonio")

# The slats run along x; the sun's profile angle moves with theta_i at azimuth 90.
LOUVER_DEG = ((30.0, 90.0), (50.0, 90.0), (40.0, 70.0), (40.0, 110.0), (40.0, 90.0))
LOUVER_STEP_DEG = 2.5  # between points; with many more Radiance's chain takes an hour
LOUVER_LEFT_OUT_DEG = (40.0, 90.0)
PTFE_CHANNEL = "633 nm"
PTFE_LEFT_OUT_DEG = (30.0, 60.0)


def louver(cache: Path, photons: int) -> Dataset:
    """The louver V2 of papers [1] and [4] at LOUVER_DEG, both hemispheres; kept in the folder `cache`."""
    path = cache / f"louver_{photons}_{len(LOUVER_DEG)}_{LOUVER_STEP_DEG:g}.h5"
    if not path.is_file():
        lines = SCENARIO.read_text().splitlines()
        asked = f"incident = {json.dumps(LOUVER_DEG)}\nstep_deg = {LOUVER_STEP_DEG}"
        scenario = cache / "louver.toml"
        scenario.write_text("\n".join(asked if line.startswith("incident =") else line for line in lines) + "\n")
        command = [str(GONIO), "simulate", str(scenario), "-o", str(path), "--photons", str(photons)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"gonio simulate: {done.stderr.strip()}")
    return replace(read_dataset(path), front_faces="interior", symmetry="none")


def ptfe() -> Dataset:
    """NIST's sintered PTFE at 633 nm: six incident polar angles, reflection; isotropic."""
    whole = nist_csv.read(PTFE)
    chosen = [d for d in whole.distributions if d.channel == PTFE_CHANNEL]
    return reduce_dataset(replace(whole, distributions=chosen, front_faces="interior", symmetry="isotropic"))


def without(dataset: Dataset, theta_deg: float, phi_deg: float | None = None) -> Dataset:
    """The dataset less one incident direction (any azimuth where phi_deg is None)."""
    kept = [
        d
        for d in dataset.distributions
        if abs(d.incident_theta_deg - theta_deg) > 0.01 or (phi_deg is not None and d.incident_phi_deg != phi_deg)
    ]
    if len(kept) == len(dataset.distributions):
        raise ValueError(f"no incident direction {theta_deg}, {phi_deg} in the dataset")
    return replace(dataset, distributions=kept)
