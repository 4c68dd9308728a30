"""nist.py: reads BRDF tables as NIST published them for sintered PTFE (Germer 2017), and writes such tables."""

import csv
import hashlib
import io
from collections import defaultdict
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Distribution, PointFlag
from gonio.formats import atomic, xml_guard
from gonio.formats.pab.raw_signal import refuse_raw
from gonio.formats.text_numbers import exact_deg, fold_deg, rounding_variance, shortest
from gonio.units.errors import UsageError

FORMAT = "NIST BRDF table"
COLUMNS = ("lambda", "thetai", "phi", "thetar", "phir", "f_r11")
HORIZON_DEG = 0.001  # nearer to grazing a BRDF is singular
LIMITS_DEG = (180.0, 720.0, 180.0, 720.0)  # of the four angles
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
    rounding = rounding_variance(text_f)
    distributions = []
    for (wavelength_um, theta_i, phi_i), rows in groups.items():
        incident_theta, incident_phi = fold_deg(np.array([theta_i]), np.array([phi_i]))
        theta, phi = fold_deg(table[rows, 3], table[rows, 4])
        cosine = np.abs(np.cos(np.radians(theta)))
        n = len(rows)
        distributions.append(
            Distribution(
                incident_theta_deg=float(incident_theta[0]),
                incident_phi_deg=float(incident_phi[0]),
                theta_deg=theta,
                phi_deg=phi,
                dsf_per_sr=table[rows, 5] * cosine,
                variance_per_sr2=rounding[rows] * cosine**2,
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
                "format": FORMAT,
                "source": "T. A. Germer, National Institute of Standards and Technology, Applied Optics (2017)",
                "points": len(table),
                "uncertainty": "none stated in the file; variance is that of rounding to three digits",
                "angles": "negative theta_i folded to azimuth 180; phi_r = 0 is the mirror side",
            }
        },
    )


def write(dataset: Dataset, path: Path, *, channel: str | None = None) -> tuple[int, int]:
    """Writes the points in reflection as such a table, the six columns that `read` takes; returns how many rows were
    written and how many points were left out: masked, in transmission, within HORIZON_DEG of grazing.

    Angles as the published table has them: incidence with a negative theta, phi_r from -180 to 180. What was read from
    such a table is written with the same digits. The file is written whole or not at all. Raises UsageError where a
    wavelength is missing, the points are not normalised, or nothing is left to write.
    """
    chosen = [d for d in dataset.distributions if channel in (None, d.channel)]
    if not chosen:
        present = ", ".join(sorted({d.channel for d in dataset.distributions}))
        raise UsageError(f"no channel {channel!r} in the dataset; it has {present}")
    refuse_raw(chosen)
    lines = [",".join(COLUMNS)]
    for d in chosen:
        if d.wavelength_nm is None:
            raise UsageError(f"channel {d.channel} states no wavelength, which a NIST table needs: export --format csv")
        lines += _rows(d, d.wavelength_nm)
    if len(lines) == 1:
        raise UsageError("no point in reflection holds a value: nothing to write in a NIST table")
    atomic.write_bytes(path, ("\n".join(lines) + "\n").encode("utf-8"))
    return len(lines) - 1, sum(len(d.theta_deg) for d in chosen) - (len(lines) - 1)


def _rows(d: Distribution, wavelength_nm: float) -> list[str]:
    from_front = d.incident_theta_deg < 90.0
    grazing = np.abs(d.theta_deg - 90.0) < HORIZON_DEG
    kept = d.measured & ((d.theta_deg < 90.0) == from_front) & ~grazing & np.isfinite(d.dsf_per_sr)
    theta, phi = d.theta_deg[kept], d.phi_deg[kept]
    f = d.dsf_per_sr[kept] / np.abs(np.cos(np.radians(theta)))
    incident = (-d.incident_theta_deg, float(exact_deg(np.mod(np.array(d.incident_phi_deg) - 180.0, 360.0))))
    start = ",".join((f"{wavelength_nm / 1000.0:.9g}", *_angles(np.array(incident))))
    receiver = zip(_angles(theta), _angles(np.where(phi > 180.0, exact_deg(phi - 360.0), phi)), strict=True)
    return [f"{start},{t},{p},{_scientific(v)}" for (t, p), v in zip(receiver, f.tolist(), strict=True)]


def _angles(angle_deg: FloatArray) -> list[str]:
    """Shortest texts; rounding's leftovers (an azimuth of 5.30E-15) as the values are written."""
    return [_scientific(float(text)) if "e" in text else text for text in shortest(angle_deg)]


def _scientific(value: float) -> str:
    """At most 15 digits, two decimals at least: 2.62E-01."""
    mantissa, _, exponent = f"{value:.14E}".partition("E")
    whole, _, decimals = mantissa.partition(".")
    return f"{whole}.{decimals.rstrip('0'):0<2}E{exponent}"


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
    good = np.isfinite(table).all(axis=1) & (np.abs(table[:, 1:5]) <= LIMITS_DEG).all(axis=1) & (table[:, 0] > 0)
    good &= table[:, 0] < 1e6
    if not good.all():
        raise UsageError(f"{name}: line {int(np.argmin(good)) + 2} holds an impossible angle, wavelength or value")
    return table, text_f
