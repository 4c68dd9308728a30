"""nist_csv.py: reads the BRDF tables that NIST published for sintered PTFE (Germer 2017) into a dataset."""

import csv
import hashlib
import io
from collections import defaultdict
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Distribution, PointFlag
from gonio.formats import xml_guard
from gonio.units.errors import UsageError

COLUMNS = ("lambda", "thetai", "phi", "thetar", "phir", "f_r11")
FloatArray = NDArray[np.float64]


def read(path: Path) -> Dataset:
    """One distribution per wavelength and incident direction, channel "633 nm" and so on, in the file's order.

    The file writes incidence as a negative theta; (-theta, phi) is (theta, phi + 180) in our angles, so that phi_r = 0
    is the mirror side (the evidence is in docs/examples/nist_ptfe/README.md). DSF = f_r11 cos(theta_r) [1/sr].
    The file states no uncertainty: the variance is that of rounding f_r11 to three digits. Solid angles are 0 until
    `reduce_dataset`.
    Raises UsageError for anything that is not such a table.
    """
    content = xml_guard.read_limited(path)
    table, text_f = _table(content, path.name)
    groups: dict[tuple[float, float, float], list[int]] = defaultdict(list)
    for row, (wavelength_um, theta_i, phi_i) in enumerate(table[:, :3].tolist()):
        groups[wavelength_um, theta_i, phi_i].append(row)
    distributions = []
    for (wavelength_um, theta_i, phi_i), rows in groups.items():
        incident_theta, incident_phi = fold_deg(np.array([theta_i]), np.array([phi_i]))
        theta, phi = fold_deg(table[rows, 3], table[rows, 4])
        cosine = np.cos(np.radians(theta))
        unit = np.array([_last_digit(text_f[row]) for row in rows])
        n = len(rows)
        distributions.append(
            Distribution(
                incident_theta_deg=float(incident_theta[0]),
                incident_phi_deg=float(incident_phi[0]),
                theta_deg=theta,
                phi_deg=phi,
                dsf_per_sr=table[rows, 5] * cosine,
                variance_per_sr2=(unit * cosine) ** 2 / 12.0,
                signal=table[rows, 5] * cosine,
                normalisation=np.ones(n),
                count=np.ones(n, dtype=np.int32),
                flags=np.full(n, PointFlag.MEASURED, dtype=np.uint16),
                solid_angle_sr=np.zeros(n),
                time_ns=np.zeros(n, dtype=np.int64),
                channel=f"{wavelength_um * 1000:.6g} nm",
                wavelength_nm=float(f"{wavelength_um * 1000:.9g}"),
            )
        )
    return Dataset(
        distributions,
        sample_name="sintered PTFE",
        polarisation="unpolarised",
        provenance={
            "imported": {
                "file": path.name,
                "sha256": hashlib.sha256(content).hexdigest(),
                "format": "NIST BRDF table",
                "source": "T. A. Germer, National Institute of Standards and Technology, Applied Optics (2017)",
                "points": len(table),
                "uncertainty": "none stated in the file; variance is that of rounding to three digits",
                "angles": "negative theta_i folded to azimuth 180; phi_r = 0 is the mirror side",
            }
        },
    )


def fold_deg(theta_deg: FloatArray, phi_deg: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Signed polar angles (n,) folded to theta in [0, 180], phi in [0, 360)."""
    phi = np.where(theta_deg < 0, phi_deg + 180.0, phi_deg) % 360.0
    return np.abs(theta_deg), phi


def _table(content: bytes, name: str) -> tuple[FloatArray, list[str]]:
    try:
        rows = list(csv.reader(io.StringIO(content.decode("utf-8-sig"))))
    except (UnicodeDecodeError, csv.Error) as error:
        raise UsageError(f"{name}: not readable as a CSV table, {error}") from error
    header = [cell.strip() for cell in rows[0]] if rows else []
    missing = [column for column in COLUMNS if column not in header]
    if missing:
        raise UsageError(f"{name}: line 1 has no column {', '.join(missing)}; this is no NIST BRDF table")
    places = [header.index(column) for column in COLUMNS]
    numbers: list[list[float]] = []
    text_f: list[str] = []
    for line, row in enumerate(rows[1:], start=2):
        if not row:
            continue
        try:
            numbers.append([float(row[place]) for place in places])
        except (ValueError, IndexError) as error:
            raise UsageError(f"{name}: line {line} lacks a number; the file is cut off or damaged") from error
        text_f.append(row[places[-1]])
    table = np.array(numbers, dtype=np.float64).reshape(-1, len(COLUMNS))
    if not len(table):
        raise UsageError(f"{name}: the table is empty")
    good = np.isfinite(table).all(axis=1) & (np.abs(table[:, [1, 3]]) <= 180).all(axis=1) & (table[:, 0] > 0)
    if not good.all():
        raise UsageError(f"{name}: line {int(np.argmin(good)) + 2} holds an impossible angle, wavelength or value")
    return table, text_f


def _last_digit(text: str) -> float:
    """Weight of the last written digit: 0.001 for 2.62E-01."""
    mantissa, _, exponent = text.strip().lower().partition("e")
    decimals = len(mantissa.partition(".")[2])
    return float(10.0 ** ((int(exponent) if exponent else 0) - decimals))
