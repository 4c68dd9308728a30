"""dataset.py: a dataset from files of pab text: hemispheres and scans of one incident direction joined, normalised.

A value that is no DSF or BSDF (a photocurrent, say) stays a raw signal in its unit until P_i is known: from a scan of
the free beam or as declared.
"""

from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Distribution, PointFlag, Polarisation, Side, Symmetry
from gonio.formats.pab.free_beam import FreeBeam, free_beam
from gonio.formats.pab.text import PabFile, read_file
from gonio.formats.text_numbers import cosine, exact_deg, fold_deg, rounding_variance
from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]

FORMAT = "pab text"
XYZ_CHANNELS = ("CIE-X", "CIE-Y", "CIE-Z")
UNSTATED_UNIT = "unstated"


def read(paths: Sequence[Path], *, p_i: float | None = None, beam: Path | None = None) -> Dataset:
    """One dataset of several files; files of one incident direction and channel become one distribution.

    `p_i` [unit of the signal times sr] or a scan of the free `beam` normalises a raw signal; without them its DSF is
    NaN and P_i too. Files without #upphi have "up" at azimuth 0, as pabopto2bsdf takes them, and are turned to ours.
    The files state no uncertainty: the variance is that of rounding to the last written digit. Solid angles are 0 until
    `reduce_dataset`. Raises UsageError for files that cannot be read or do not fit together.
    """
    if p_i is not None and not (np.isfinite(p_i) and p_i > 0.0):
        raise UsageError(f"P_i is {p_i:g}: give a value over 0, in the signal's unit times sr")
    files = [read_file(path) for path in paths]
    _check_together(files)
    front = _one(files, "gonio_front_faces", get_args(Side), "undeclared")
    groups: dict[tuple[float, float, str], list[tuple[PabFile, int]]] = defaultdict(list)
    for file in files:
        theta, phi = _sample_frame(np.array([file.incident_theta_deg]), np.array([file.incident_phi_deg]), front)
        for column, channel in enumerate(_channels(file)):
            groups[float(theta[0]), float(phi[0]), channel].append((file, column))
    scale = _scale(files, p_i, beam)
    distributions = [
        _distribution(key, [file for file, _ in group], group[0][1], front, scale) for key, group in groups.items()
    ]
    names = [file.sample_name for file in files if file.sample_name]
    return Dataset(
        distributions,
        sample_name=names[0] if names else "",
        front_faces=front,
        polarisation=_one(files, "gonio_polarisation", get_args(Polarisation), "unknown"),
        symmetry=_one(files, "gonio_symmetry", get_args(Symmetry), "undeclared"),
        provenance={"imported": _provenance(files, front, p_i, scale)},
        beam=scale.scan if isinstance(scale, FreeBeam) else None,
    )


def remarks(dataset: Dataset) -> list[str]:
    """What the user should know about a dataset just read: one sentence each."""
    lines = []
    if len(dataset.provenance["imported"]["files"]) > 1:
        lines += [
            f"incident {d.incident_theta_deg:g}/{d.incident_phi_deg:g}, {d.channel}: {len(d.theta_deg)} points of "
            f"{', '.join(d.paths)}."
            for d in dataset.distributions
        ]
    for file in dataset.provenance["imported"]["files"]:
        if file["stated_points"] not in (None, file["points"]):
            lines.append(f"{file['file']}: says {file['stated_points']} points and holds {file['points']}.")
        elif not file["ended"]:
            lines.append(f"{file['file']}: the last line has no end: if the file was cut off, its value is wrong.")
        if file["beyond"]:
            lines.append(
                f"{file['file']}: rows with theta over 180: {file['beyond']}, taken as the other half of a full circle."
            )
    if any(np.isnan(d.p_i) for d in dataset.distributions):
        unit = dataset.distributions[0].signal_unit
        lines.append(f"the signal (unit {unit}) is not normalised: give --beam or --p-i to get a DSF.")
        if unit == UNSTATED_UNIT:
            lines.append(
                "are the values a DSF or BSDF already? then say so in a line #format: theta phi DSF (or BSDF)."
            )
    return lines


def _check_together(files: list[PabFile]) -> None:
    if not files:
        raise UsageError("no pab file is named: name one file or several")
    first = files[0]
    for file in files[1:]:
        if bool(file.quantity) != bool(first.quantity) or file.unit != first.unit:
            raise UsageError(
                f"{file.name}: holds {_what(file)}, {first.name} holds {_what(first)}: import them one by one"
            )
        if file.sha256 == first.sha256:
            raise UsageError(f"{file.name}: is the same file as {first.name}: name each once")


def _what(file: PabFile) -> str:
    return file.quantity or f"a signal in {file.unit or UNSTATED_UNIT} unit"


def _channels(file: PabFile) -> tuple[str, ...]:
    return XYZ_CHANNELS if file.colours == 3 else (file.ours.get("gonio_channel") or "visible",)


def _one(files: list[PabFile], key: str, allowed: tuple[str, ...], otherwise: str) -> Any:
    """What all files say under a key of ours."""
    said = {file.ours.get(key, otherwise) for file in files}
    if len(said) > 1:
        raise UsageError(f"the files differ in #{key} ({', '.join(sorted(said))[:80]}): import them one by one")
    value = said.pop()
    if value not in allowed:
        raise UsageError(f"{files[0].name}: #{key} {value[:40]!r} is none of {', '.join(allowed)}")
    return value


def _sample_frame(theta_deg: FloatArray, phi_deg: FloatArray, front: Side) -> tuple[FloatArray, FloatArray]:
    """Our writer turns a front that faces the exterior into Radiance's frame and says so: turned back here."""
    if front != "exterior":
        return theta_deg, phi_deg
    return fold_deg(exact_deg(180.0 - theta_deg), exact_deg(180.0 - phi_deg))


def _scale(files: list[PabFile], p_i: float | None, beam: Path | None) -> FreeBeam | float:
    """P_i: of the beam's scan, as declared, 1 for what is a DSF already, NaN for a raw signal."""
    if files[0].quantity:
        if p_i is not None or beam is not None:
            raise UsageError(f"{files[0].name}: holds {files[0].quantity} and is normalised already: leave P_i away")
        return 1.0
    if beam is None:
        return np.nan if p_i is None else p_i
    scan = read_file(beam)
    if scan.quantity or scan.colours != 1:
        raise UsageError(f"{scan.name}: holds {_what(scan)}: a free beam is a raw signal, in the scans' unit")
    if scan.unit != files[0].unit:
        raise UsageError(
            f"{scan.name}: the beam is in {scan.unit or UNSTATED_UNIT}, {files[0].name} in"
            f" {files[0].unit or UNSTATED_UNIT}: convert one of them"
        )
    return free_beam(scan, scan.unit or UNSTATED_UNIT)


def _distribution(
    key: tuple[float, float, str], files: list[PabFile], column: int, front: Side, scale: FreeBeam | float
) -> Distribution:
    theta_i, phi_i, channel = key
    wavelengths = {file.ours["gonio_wavelength_nm"] for file in files if "gonio_wavelength_nm" in file.ours}
    theta, phi = _sample_frame(
        np.concatenate([file.theta_deg for file in files]), np.concatenate([file.phi_deg for file in files]), front
    )
    values = np.concatenate([file.values[:, column] for file in files])
    is_bsdf = np.concatenate([np.full(len(file.theta_deg), file.quantity not in ("", "DSF")) for file in files])
    factor = np.where(is_bsdf, cosine(theta), 1.0)
    # Rounding is told from the first column's text; the three of a colour are written alike.
    rounding = np.concatenate([rounding_variance(file.value_text) for file in files]) * factor**2
    p_i = scale.p_i if isinstance(scale, FreeBeam) else scale
    signal = values * factor
    n = len(values)
    return Distribution(
        incident_theta_deg=theta_i,
        incident_phi_deg=phi_i,
        theta_deg=theta,
        phi_deg=phi,
        dsf_per_sr=signal / p_i,
        variance_per_sr2=rounding / p_i**2,
        signal=signal,
        normalisation=np.ones(n),
        count=np.ones(n, dtype=np.int32),
        flags=np.full(n, PointFlag.MEASURED, dtype=np.uint16),
        solid_angle_sr=np.zeros(n),
        time_ns=np.zeros(n, dtype=np.int64),
        channel=channel,
        wavelength_nm=_wavelength(wavelengths, files[0].name),
        p_i=p_i,
        p_i_u_rel=scale.p_i_u_rel if isinstance(scale, FreeBeam) else 0.0,
        signal_unit="1/sr" if files[0].quantity else files[0].unit or UNSTATED_UNIT,
        path=np.repeat(np.arange(len(files), dtype=np.int32), [len(file.theta_deg) for file in files]),
        paths=tuple(file.name for file in files),
    )


def _wavelength(said: set[str], name: str) -> float | None:
    if not said:
        return None
    try:
        found = {float(text) for text in said}
    except ValueError:
        found = set()
    if len(found) != 1 or not 0.0 < next(iter(found)) < 1e6:
        raise UsageError(f"{name}: #gonio_wavelength_nm is not one length in nm for this incident direction")
    return found.pop()


def _provenance(files: list[PabFile], front: Side, p_i: float | None, scale: FreeBeam | float) -> dict[str, Any]:
    entries = []
    for file in files:
        incident = _sample_frame(np.array([file.incident_theta_deg]), np.array([file.incident_phi_deg]), front)
        theta = _sample_frame(file.theta_deg, file.phi_deg, front)[0]
        entries.append(
            {
                "file": file.name,
                "sha256": file.sha256,
                "incident_deg": [float(incident[0][0]), float(incident[1][0])],
                "channels": list(_channels(file)),
                "quantity": file.quantity,
                "unit": file.unit,
                "format": file.format_text,
                "sample_name": file.sample_name,
                "up_phi_deg": file.up_phi_deg,
                "points": len(theta),
                "stated_points": file.stated_points,
                "ended": file.ended,
                "beyond": file.beyond,
                "theta_deg": [float(theta.min()), float(theta.max())],
                "header": file.header,
            }
        )
    found: dict[str, Any] = {
        "format": FORMAT,
        "files": entries,
        "points": sum(len(file.theta_deg) for file in files),
        "uncertainty": "none stated in the files; variance is that of rounding to the last digit",
        "angles": "turned so that up is at azimuth 90; theta folded to 0-180",
    }
    if isinstance(scale, FreeBeam):
        found["beam"] = scale.provenance
    elif p_i is not None:
        found["p_i"] = f"declared as {p_i!r}"
    return found
