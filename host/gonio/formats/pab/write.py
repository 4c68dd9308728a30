"""write.py: writes a dataset as pab text, a file per incident direction and pair of hemispheres, for pabopto2bsdf.

Angles are in Radiance's frame (+z into the room, +y up: #upphi 90); a sample whose front faces the exterior is turned
about y and the file says so. Leave pabopto2bsdf's -t away: it would turn once more, and with #upphi 90 upside down.
"""

import re
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Distribution, Side
from gonio.formats import atomic
from gonio.formats.pab.dataset import FORMAT, UNSTATED_UNIT, XYZ_CHANNELS
from gonio.formats.pab.text import BSDF_WORDS, OUR_UP_DEG
from gonio.formats.text_numbers import cosine, exact_deg, fifteen_digits, fold_deg, shortest
from gonio.units.errors import UsageError
from gonio.units.version import gonio_version

FloatArray = NDArray[np.float64]

HORIZON_DEG = 0.001  # nearer to it a BSDF is singular
SUFFIXES = (".txt", ".dat", ".pab")
_LONGEST_LINE = 2000  # bytes: pabopto2bsdf reads 2047 and takes the rest for data
_LONGEST_NAME = 200


@dataclass
class PabWritten:
    """What was written: files in order, and what a user must know, one sentence each."""

    paths: list[Path] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)


def write(
    dataset: Dataset,
    output: Path,
    *,
    front: Side | None = None,
    channel: str | None = None,
    quantity: str | None = None,
) -> PabWritten:
    """Writes all files or none. `output` is a folder, made where it is missing, or a file name ending in one of
    SUFFIXES: the name itself for a single file, else what all names begin with.

    `front` goes before dataset.front_faces. `quantity` is DSF or one of BSDF_WORDS; without it a dataset that came from
    pab text keeps the one it had. A raw signal is written in its unit. Raises UsageError for an undeclared front, an
    unknown channel, and where no point holds a value.
    """
    faces = front or dataset.front_faces
    if faces == "undeclared":
        raise UsageError(
            "it is not declared which way the sample's front faces: give --front exterior or --front interior"
        )
    if quantity is not None and quantity not in ("DSF", *BSDF_WORDS):
        raise UsageError(f"{quantity!r} cannot be written as pab text: choose DSF or BSDF")
    chosen = _chosen(dataset, channel)
    named = len({_label(group) for group in chosen}) > 1
    contents: dict[str, bytes] = {}
    singular = masked = 0
    grazing: list[str] = []
    for group in chosen:
        table = _Table(dataset, group, faces, quantity)
        singular += table.singular
        masked += table.masked
        for kind, rows in table.sets():
            label = re.sub(r"[^\w.-]+", "_", _label(group)) + "_" if named else ""
            stem = f"{label}{kind}_t{table.incident[0]:g}_p{table.incident[1]:g}"
            while stem in contents:  # two incident directions that six digits do not tell apart, two channels
                stem += "_2"
            contents[stem] = table.text(rows).encode("utf-8")
            if np.all(table.theta_deg[rows] == 90.0):
                grazing.append(stem)
    if not contents:
        raise UsageError("no point of the dataset holds a value: nothing to write; reduce or import one first")
    written = PabWritten(remarks=_remarks(singular, masked, contents, grazing))
    written.paths = _place(contents, output)
    return written


class _Table:
    """The rows of one incident direction in the file's frame; several channels are the values of a colour."""

    def __init__(self, dataset: Dataset, group: list[Distribution], faces: Side, quantity: str | None) -> None:
        first = group[0]
        self.dataset, self.group, self.faces = dataset, group, faces
        self.theta_deg, self.phi_deg = _turned(first.theta_deg, first.phi_deg, faces)
        theta_i, phi_i = _turned(np.array([first.incident_theta_deg]), np.array([first.incident_phi_deg]), faces)
        self.incident = float(theta_i[0]), float(phi_i[0])
        self.raw = bool(np.isnan(first.p_i))
        self.entries = _entries(dataset, first)
        before = {str(entry["quantity"]) for entry in self.entries}
        kept = before.pop() if len(before) == 1 else ""
        self.quantity = "" if self.raw else quantity or (kept if kept in BSDF_WORDS else "DSF")
        values = [d.signal if self.raw else d.dsf_per_sr for d in group]
        usable = np.all([np.isfinite(v) & d.measured for v, d in zip(values, group, strict=True)], axis=0)
        self.masked = int(np.count_nonzero(~usable))
        self.singular = 0
        if self.quantity in BSDF_WORDS:
            slant = cosine(self.theta_deg)
            near = usable & (slant < np.sin(np.radians(HORIZON_DEG)))
            self.singular = int(np.count_nonzero(near))
            usable &= ~near
            values = [v / np.where(near, 1.0, slant) for v in values]
        self.values, self.usable = values, usable

    def sets(self) -> list[tuple[str, NDArray[np.bool_]]]:
        """Name of each pair of hemispheres that has rows, and its rows. At 90 degrees the back begins (as Radiance has
        it)."""
        from_front = self.incident[0] < 90.0
        found = []
        for to_front in (True, False):
            rows = self.usable & ((self.theta_deg < 90.0) == to_front)
            if rows.any():
                side = "front" if from_front else "back"
                found.append((f"{side}_{'reflection' if from_front == to_front else 'transmission'}", rows))
        return found

    def text(self, rows: NDArray[np.bool_]) -> str:
        lines = [*self._header(rows), *self._kept(rows)]
        digits = fifteen_digits if self.quantity in BSDF_WORDS else shortest
        columns = [
            shortest(self.theta_deg[rows]),
            shortest(self.phi_deg[rows]),
            *(digits(v[rows]) for v in self.values),
        ]
        lines += ["\t".join(row) for row in zip(*columns, strict=True)]
        return "\n".join(lines) + "\n"

    def _header(self, rows: NDArray[np.bool_]) -> list[str]:
        first, dataset = self.group[0], self.dataset
        theta, phi = shortest(np.array(self.incident))
        name = _plain(dataset.sample_name).replace('"', "'")[:_LONGEST_NAME]
        lines = [f"#written_by gonio {gonio_version()}"]
        lines += [f'#sample_name "{name}"'] if name else []
        lines += [f"#incident_angle {theta} {phi}", f"#intheta {theta}", f"#inphi {phi}", f"#upphi {OUR_UP_DEG:g}"]
        if len(self.group) == len(XYZ_CHANNELS):
            lines.append("#colorimetry: CIE-XYZ")
        elif first.channel.lower() == "visible" and not self.raw and not any(map(_is_colorimetry, self._kept(rows))):
            lines.append("#colorimetry: CIE-Y")
        lines += [f"#gonio_front_faces {self.faces}", f"#gonio_polarisation {dataset.polarisation}"]
        lines.append(f"#gonio_symmetry {dataset.symmetry}")
        if len(self.group) == 1:
            lines.append(f"#gonio_channel {_plain(first.channel)}")
        if first.wavelength_nm is not None:
            lines.append(f"#gonio_wavelength_nm {first.wavelength_nm!r}")
        lines.append(f"#datapoints_in_file: {int(np.count_nonzero(rows))}")
        lines.append(f"#format: {self._format()}".rstrip())
        return lines

    def _format(self) -> str:
        if not self.raw:
            return f"theta phi {self.quantity}"
        said = {str(entry["format"]) for entry in self.entries}
        if len(said) == 1 and (only := said.pop()):
            return only
        unit = self.group[0].signal_unit
        return f"theta phi {'' if unit == UNSTATED_UNIT else _plain(unit)}"

    def _kept(self, rows: NDArray[np.bool_]) -> list[str]:
        """Header lines that were not known when these rows were read, each once."""
        theta = self.group[0].theta_deg[rows]
        lines: dict[str, None] = {}
        for entry in self.entries:
            low, high = entry["theta_deg"]
            if theta.min() <= high and theta.max() >= low:
                lines |= dict.fromkeys(entry["header"])
        return [_cut(line) for line in lines]


def _chosen(dataset: Dataset, channel: str | None) -> list[list[Distribution]]:
    """Distributions to write; the three channels of a colour at one incident direction go together."""
    present = sorted({d.channel for d in dataset.distributions})
    if channel is not None and channel not in present:
        raise UsageError(f"no channel {channel!r} in the dataset; it has {', '.join(present)}")
    groups: list[list[Distribution]] = []
    colours: dict[tuple[float, float], list[Distribution]] = defaultdict(list)
    for d in dataset.distributions:
        if channel is None and d.channel in XYZ_CHANNELS:
            colours[d.incident_theta_deg, d.incident_phi_deg].append(d)
        elif channel in (None, d.channel):
            groups.append([d])
    for parts in colours.values():
        ordered = sorted(parts, key=lambda d: XYZ_CHANNELS.index(d.channel))
        same = all(
            np.array_equal(d.theta_deg, ordered[0].theta_deg) and np.array_equal(d.phi_deg, ordered[0].phi_deg)
            for d in ordered
        )
        together = same and tuple(d.channel for d in ordered) == XYZ_CHANNELS
        groups += [ordered] if together else [[d] for d in ordered]
    return groups


def _label(group: list[Distribution]) -> str:
    return group[0].channel if len(group) == 1 else "CIE-XYZ"


def _entries(dataset: Dataset, d: Distribution) -> list[dict[str, Any]]:
    """What the provenance says of the pab files that a distribution came from."""
    imported = dataset.provenance.get("imported", {})
    if not isinstance(imported, dict) or imported.get("format") != FORMAT:
        return []
    incident = [d.incident_theta_deg, d.incident_phi_deg]
    return [e for e in imported["files"] if e["incident_deg"] == incident and d.channel in e["channels"]]


def _turned(theta_deg: FloatArray, phi_deg: FloatArray, faces: Side) -> tuple[FloatArray, FloatArray]:
    """Our directions in Radiance's frame, decimals kept exact."""
    if faces == "exterior":
        theta_deg, phi_deg = exact_deg(180.0 - theta_deg), exact_deg(180.0 - phi_deg)
    return fold_deg(theta_deg, phi_deg)


def _remarks(singular: int, masked: int, contents: dict[str, bytes], grazing: list[str]) -> list[str]:
    lines = []
    if masked:
        lines.append(f"{masked} points without a value are left out: pab text cannot hold them.")
    if singular:
        lines.append(
            f"{singular} points within {HORIZON_DEG:g} degrees of grazing are left out: a BSDF is singular there."
        )
    if grazing:
        lines.append(
            f"{', '.join(grazing)}: holds nothing but points at theta = 90, which Radiance counts as behind: not for "
            "pabopto2bsdf."
        )
    kinds: dict[str, int] = defaultdict(int)
    for stem in contents:
        kinds[stem.rpartition("_t")[0]] += 1
    alone = [kind for kind, count in kinds.items() if count < 2]
    if alone:
        lines.append(
            f"a single incident direction in {', '.join(alone)}: pabopto2bsdf wants two files or more of a set."
        )
    return lines


def _place(contents: dict[str, bytes], output: Path) -> list[Path]:
    if output.suffix.lower() in SUFFIXES and not output.is_dir():
        single = len(contents) == 1
        paths = {
            output if single else output.with_name(f"{output.stem}_{stem}{output.suffix}"): content
            for stem, content in contents.items()
        }
        atomic.write_set(paths)
        return list(paths)
    new = not output.exists()
    try:
        output.mkdir(exist_ok=True)
    except OSError as error:
        raise UsageError(f"{output}: cannot be made a folder, {error.strerror}: choose another place") from error
    paths = {output / f"{stem}.txt": content for stem, content in contents.items()}
    if any(path not in paths for path in output.glob("*.txt")):
        raise UsageError(f"{output}: holds other text files, which would be taken for the same set: name a new folder")
    try:
        atomic.write_set(paths)
    except UsageError:
        if new:
            output.rmdir()
        raise
    return list(paths)


def _is_colorimetry(line: str) -> bool:
    return line.lower().startswith("#colorimetry")


def _plain(text: str) -> str:
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def _cut(line: str) -> str:
    return line.encode("utf-8")[:_LONGEST_LINE].decode("utf-8", "ignore")
