"""text.py: reads one file of the "mountain" text of pab goniophotometers: a header of # lines, then theta, phi, value.

What the header lines mean is described in the manual page of Radiance's pabopto2bsdf. Lines that are not known are kept
as they are.
"""

import hashlib
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gonio.formats.text_numbers import exact_deg, fold_deg, lines_of
from gonio.formats.xml_guard import read_limited
from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]

OUR_UP_DEG = 90.0  # azimuth of "up" in our angles
DEFAULT_UP_DEG = 0.0  # where a file does not say, as pabopto2bsdf takes it
BSDF_WORDS = ("BSDF", "BRDF", "BTDF")
COLOURS = {"cie-y": 1, "cie-xyz": 3}  # values per row
MAX_BYTES = 2**30
# Lines that our writer derives from the dataset and that are not kept as text.
OURS = (
    "written_by",
    "gonio_front_faces",
    "gonio_polarisation",
    "gonio_symmetry",
    "gonio_channel",
    "gonio_wavelength_nm",
)
_ANGLES = {"incident_angle": 2, "intheta": 1, "inphi": 1, "upphi": 1}
_KNOWN = {*_ANGLES, *OURS, "format", "colorimetry", "sample_name", "datapoints_in_file"}
_OF_NUMBERS = b"0123456789+-.eE \t"
_KEYWORD = re.compile(r"([A-Za-z_]\w*)[ \t]*:?[ \t]*(.*)")


@dataclass(frozen=True)
class PabFile:
    """One file. Angles are in our azimuth (up at 90 degrees) and folded; `values` (n, 1 or 3) as written."""

    name: str
    sha256: str
    incident_theta_deg: float
    incident_phi_deg: float
    theta_deg: FloatArray
    phi_deg: FloatArray
    values: FloatArray
    value_text: list[str]  # (n,), of the first value
    quantity: str  # "DSF", one of BSDF_WORDS, or "" for a raw signal
    unit: str  # of a raw signal, "" where the file does not say
    format_text: str  # the #format line, "" where there is none
    colours: int  # values per row: 1, or 3 for CIE XYZ
    sample_name: str
    up_phi_deg: float  # as written, or DEFAULT_UP_DEG
    ours: dict[str, str]  # what our own writer said
    header: list[str]  # lines that are not known, without line ends
    stated_points: int | None  # as the header counts them
    ended: bool  # the last row has its line end
    beyond: int  # rows with theta over 180, of a scan round the full circle


def looks_like_pab(content: bytes) -> bool:
    """Whether the beginning of a file is a header of this format."""
    for line in lines_of(content[:65536]):
        if not line.startswith("#"):
            return False
        if re.match(r"#(incident_angle|intheta|inphi|format|upphi)\b", line, re.IGNORECASE):
            return True
    return False


def read_file(path: Path) -> PabFile:
    """Reads one file. Raises UsageError, one line, for what is missing, contradictory or no number."""
    content = read_limited(path, MAX_BYTES)
    name = path.name
    _check_text(content, name)
    known: dict[str, str] = {}
    header: list[str] = []
    rows: list[str] = []
    numbers_of_rows: list[int] = []
    for number, line in enumerate(lines_of(content), start=1):
        if not line.startswith("#"):
            if line.strip():
                rows.append(line)
                numbers_of_rows.append(number)
            continue
        found = _KEYWORD.match(line[1:])
        key = found.group(1).lower() if found else ""
        if found is None or key not in _KNOWN:
            header.append(line)
        elif rows and key not in ("sample_name", "datapoints_in_file", *OURS):
            raise UsageError(f"{name}: line {number}: #{key} comes after data: are these two files in one? split them")
        else:
            known[key] = _once(known, key, found.group(2).strip(), name, number)
    up_deg = _angles(known, "upphi", name)
    up_phi_deg = up_deg[0] if up_deg else DEFAULT_UP_DEG
    incident = _incident(known, name)
    quantity, unit = _quantity(known.get("format"), name)
    colours = COLOURS.get(known.get("colorimetry", "").partition(" ")[0].lower(), 1)
    if "colorimetry" in known and known["colorimetry"].partition(" ")[0].lower() not in COLOURS:
        header.append(f"#colorimetry: {known['colorimetry']}")
    table = _table(rows, numbers_of_rows, 2 + colours, name)
    turn_deg = OUR_UP_DEG - up_phi_deg
    theta_deg, phi_deg = _ours(table[:, 0], table[:, 1], turn_deg)
    incident_theta, incident_phi = _ours(np.array(incident[:1]), np.array(incident[1:]), turn_deg)
    return PabFile(
        name=name,
        sha256=hashlib.sha256(content).hexdigest(),
        incident_theta_deg=float(incident_theta[0]),
        incident_phi_deg=float(incident_phi[0]),
        theta_deg=theta_deg,
        phi_deg=phi_deg,
        values=table[:, 2:],
        value_text=[row.split(None, 3)[2] for row in rows],
        quantity=quantity,
        unit=unit,
        format_text=" ".join(known.get("format", "").split()),
        colours=colours,
        sample_name=known.get("sample_name", "").strip().strip('"'),
        up_phi_deg=up_phi_deg,
        ours={key: known[key] for key in OURS if key in known},
        header=header,
        stated_points=_count(known.get("datapoints_in_file"), name),
        ended=content.endswith((b"\n", b"\r")),
        beyond=int(np.count_nonzero(np.abs(table[:, 0]) > 180.0)),
    )


def _check_text(content: bytes, name: str) -> None:
    """UsageError for what is no such file at all, so that nobody goes looking for its header."""
    if not content.strip():
        raise UsageError(f"{name}: is empty: name a file with points")
    if b"\0" in content:
        raise UsageError(f"{name}: is no text file: pab text has # lines, then rows of theta, phi and value")
    first = content.removeprefix(b"\xef\xbb\xbf").lstrip().splitlines()[0]
    if not first.startswith(b"#") and first.translate(None, _OF_NUMBERS):
        raise UsageError(f"{name}: is no pab text: it begins neither with a # line nor with theta, phi and value")


def _once(known: dict[str, str], key: str, text: str, name: str, number: int) -> str:
    if known.get(key, text) != text and key != "colorimetry":  # of two colorimetries the last counts, as in Radiance
        raise UsageError(f"{name}: line {number}: #{key} was something else before ({known[key][:40]!r}): correct it")
    return text


def _angles(known: dict[str, str], key: str, name: str) -> list[float]:
    """Numbers of a header line, none where it is missing."""
    if key not in known:
        return []
    words = known[key].split()[: _ANGLES[key]]
    try:
        angles = [float(word) for word in words]
    except ValueError:
        angles = []
    if len(angles) != _ANGLES[key] or not all(abs(angle) <= 720.0 for angle in angles):
        raise UsageError(f"{name}: #{key} {known[key][:40]!r} is not {_ANGLES[key]} angle(s) in degrees: correct it")
    return angles


def _incident(known: dict[str, str], name: str) -> list[float]:
    both = _angles(known, "incident_angle", name)
    theta, phi = _angles(known, "intheta", name), _angles(known, "inphi", name)
    if both and ((theta and theta[0] != both[0]) or (phi and phi[0] != both[1])):
        raise UsageError(f"{name}: #incident_angle differs from #intheta and #inphi: correct one of them")
    if not both and theta == [0.0] and not phi:
        phi = [0.0]  # no azimuth at normal incidence
    incident = both or theta + phi
    if len(incident) != 2:
        raise UsageError(f"{name}: no #incident_angle theta phi (or #intheta and #inphi) in the header: add it")
    if abs(incident[0]) > 180.0:
        raise UsageError(f"{name}: the incident theta {incident[0]:g} is over 180 degrees: correct it")
    return incident


def _quantity(text: str | None, name: str) -> tuple[str, str]:
    """Quantity and unit of `theta phi WORD [unit]`: a quantity we know, or "" and the unit of a raw signal."""
    if text is None:
        return "", ""
    words = text.split()
    if [word.lower() for word in words[:2]] != ["theta", "phi"]:
        raise UsageError(f"{name}: #format {text[:40]!r} does not begin with theta phi: only that order is read")
    word = words[2].upper() if len(words) > 2 else ""
    if word == "DSF" or word in BSDF_WORDS:
        return word, ""
    return "", words[-1].strip("[](),") if len(words) > 2 else ""


def _count(text: str | None, name: str) -> int | None:
    if text is None:
        return None
    if not re.fullmatch(r"[0-9]{1,12}", text):
        raise UsageError(f"{name}: #datapoints_in_file {text[:40]!r} is no whole number: correct it")
    return int(text)


def _table(rows: list[str], line_numbers: list[int], columns: int, name: str) -> FloatArray:
    if not rows:
        raise UsageError(f"{name}: holds no row of theta, phi and value: is the file cut off?")
    foreign = next((row for row, text in enumerate(rows) if text.encode().translate(None, _OF_NUMBERS)), None)
    if foreign is None and len(rows[0].split()) != columns:
        foreign = 0
    if foreign is not None:
        raise UsageError(f"{name}: line {line_numbers[foreign]} is not {columns} numbers: theta, phi, value(s)")
    try:
        table = np.loadtxt(rows, dtype=np.float64, comments=None, ndmin=2)
    except ValueError as error:
        place = re.search(r"row (\d+)", str(error))
        row = int(place.group(1)) if place else 0
        # numpy counts from 0 where a word is no number, from 1 where their count changes.
        row -= "number of columns changed" in str(error)
        line = line_numbers[min(max(row, 0), len(line_numbers) - 1)]
        raise UsageError(f"{name}: line {line} is not {columns} numbers; the file is cut off or damaged") from error
    good = np.isfinite(table).all(axis=1) & (np.abs(table[:, 0]) <= 360.0) & (np.abs(table[:, 1]) <= 720.0)
    if not good.all():
        line = line_numbers[int(np.argmin(good))]
        raise UsageError(f"{name}: line {line} holds an impossible angle or value: correct or remove it")
    return np.asarray(table, dtype=np.float64)


def _ours(theta_deg: FloatArray, phi_deg: FloatArray, turn_deg: float) -> tuple[FloatArray, FloatArray]:
    return fold_deg(theta_deg, exact_deg(phi_deg + turn_deg) if turn_deg else phi_deg)
