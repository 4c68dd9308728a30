"""matrices.py: the matrices of a WINDOW file from a dataset, and which were measured, rotated, filled or zero."""

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Distribution, Side
from gonio.dataset.scattering import Origin
from gonio.formats.findings import Findings
from gonio.formats.pab.raw_signal import refuse_raw
from gonio.formats.window.klems import (
    KlemsBasis,
    LightSide,
    Process,
    basis_named,
    incident_place,
    process_of,
    to_radiance_deg,
)
from gonio.formats.window.patch_average import HemisphereProfile, PatchValues, hemisphere_profile, mean_profile
from gonio.formats.window.patch_uncertainty import BRIGHT, PatchUncertainty
from gonio.units.errors import CheckFailed, UsageError

FloatArray = NDArray[np.float64]
Band = Literal["Visible", "Solar", "CIE-X", "CIE-Z"]  # with the last two Visible is CIE-Y, as Radiance has it
Fill = Literal["none", "nearest"]
BANDS: tuple[Band, ...] = ("Visible", "Solar")  # that every file has
SIDES: tuple[LightSide, ...] = get_args(LightSide)
PROCESSES: tuple[Process, ...] = get_args(Process)

HORIZON_DEG = 85.0  # points that end before this are said to
ZERO, MEASURED, ROTATED, FILLED, MODELLED = 0, 1, 2, 3, 4  # where a column comes from


@dataclass
class MatrixSet:
    """Matrices of one band. Values are BSDF [1/sr], shape (rows = outgoing patches, columns = incident patches)."""

    matrices: dict[tuple[Process, LightSide], FloatArray]
    origin: dict[tuple[Process, LightSide], NDArray[np.uint8]]  # ZERO .. MODELLED per column, shape (columns,)
    outermost_deg: dict[tuple[Process, LightSide], float] = field(default_factory=dict)  # of measured points, the least
    filled_patches: int = 0  # outgoing patches without a point, taken from the nearest points (own columns only)
    negative_added: float = 0.0  # largest energy per column added by writing negative averages as 0
    negative_patches: int = 0
    # Of measured and rotated columns; none for what was simulated.
    uncertainty: dict[tuple[Process, LightSide], PatchUncertainty] = field(default_factory=dict)
    # Of what comes from a model: Origin of every cell (rows, columns), where it has one.
    cells: dict[tuple[Process, LightSide], NDArray[np.uint8]] = field(default_factory=dict)

    def unmeasured(self) -> list[str]:
        """Names of matrices of which no column was measured."""
        return [f"{process} {side}" for (process, side), origin in self.origin.items() if not origin.any()]


@dataclass
class KlemsMatrices:
    """All matrices of a file."""

    basis: KlemsBasis
    bands: dict[Band, MatrixSet]
    front_faces: Side
    copied: tuple[Band, Band] | None = None  # (from, to) when one block was declared flat and copied
    channel_of: dict[Band, str] = field(default_factory=dict)
    findings: Findings = field(default_factory=lambda: Findings("export"))
    simulated: bool = False  # patch by patch, not measured point by point; MEASURED columns are then simulated ones
    source: str = ""  # what the values come from, where it is neither points nor a simulation
    notes: list[str] = field(default_factory=list)  # of whoever made them, one sentence each

    def column_counts(self, band: Band, process: Process, side: LightSide) -> tuple[int, int, int, int]:
        """Incident columns that were measured, rotated, filled, left at zero."""
        origin = self.bands[band].origin[process, side]
        measured, rotated, filled, zero = (int(np.sum(origin == kind)) for kind in (MEASURED, ROTATED, FILLED, ZERO))
        return measured, rotated, filled, zero

    def remarks(self) -> list[str]:
        """What a reader of the file must know: one sentence each, for <Comments> and the report."""
        lines = []
        done = "simulated" if self.simulated else "measured"
        for band, block in self.bands.items():
            if self.copied is not None and band == self.copied[1]:
                lines.append(f"{band}: copied from {self.copied[0]} (declared spectrally flat).")
                continue
            if band not in self.channel_of:
                lines.append(f"{band}: not {done}, all matrices are zeros.")
                continue
            if self.simulated:
                lines.append(f"{band}: all matrices and incident columns simulated.")
                continue
            missing = block.unmeasured()
            if missing:
                lines.append(f"{band}: not measured, zeros: {', '.join(missing)}.")
            for (process, side), cells in block.cells.items():
                lines.append(f"{band} {process} {side}: {counted(cells)}")
            for (process, side), origin in block.origin.items():
                if not origin.any() or (process, side) in block.cells:
                    continue
                measured, rotated, filled, zero = self.column_counts(band, process, side)
                lines.append(
                    f"{band} {process} {side}: incident columns {measured} measured, {rotated} rotated from a "
                    f"measured theta_i (declared isotropic), {filled} filled from the nearest theta_i, {zero} zero."
                )
                outermost = block.outermost_deg[process, side]
                if outermost < HORIZON_DEG:
                    lines.append(
                        f"{band} {process} {side}: measured up to {outermost:.1f} degrees from the normal, the nearest "
                        "point's value beyond."
                    )
            if block.filled_patches:
                lines.append(f"{band}: {block.filled_patches} patches without a point, filled from the nearest.")
            if block.negative_patches:
                lines.append(
                    f"{band}: {block.negative_patches} negative averages written as 0, "
                    f"adding at most {block.negative_added:.2e} to a column's sum."
                )
            lines += self._uncertainty_remarks(band)
        lines += [finding.message for finding in self.findings.of("warning")]
        return lines + self.notes

    def _uncertainty_remarks(self, band: Band) -> list[str]:
        block = self.bands[band]
        found = [
            (*largest, process, side)
            for (process, side), own in block.uncertainty.items()
            if (largest := own.largest_relative(block.matrices[process, side])) is not None
        ]
        if not found:
            return []
        u_rel, row, column, process, side = max(found)
        return [
            f"{band}: largest relative standard uncertainty (k = 1) of a patch over {BRIGHT:.0%} of its matrix's "
            f"largest: {u_rel:.2%}, {process} {side}, outgoing patch {row + 1}, incident patch {column + 1}."
        ]


@dataclass(frozen=True)
class _Incident:
    """One measured incident direction in Radiance's frame; an isotropic sample's profiles count from its azimuth."""

    side: LightSide
    polar_deg: float
    azimuth_deg: float  # of the column
    profiles: dict[Process, HemisphereProfile]


def build(
    dataset: Dataset,
    *,
    basis: str = "klems-full",
    front: Side | None = None,
    fill: Fill = "none",
    assume_flat: bool = False,
    channel: str | None = None,
) -> KlemsMatrices:
    """Matrices of a dataset.

    `front` overrides dataset.front_faces; `fill='nearest'` gives incident rings without a measurement the nearest
    measured theta_i, rotated; `assume_flat` copies the only measured block to the other one; `channel` names the
    channel to write when none is called visible or solar. Raises UsageError for what is undeclared, CheckFailed where
    energy exceeds 1.
    """
    chosen = basis_named(basis)
    faces = front or dataset.front_faces
    channels = _channels(dataset, channel)
    result = KlemsMatrices(chosen, {}, faces, channel_of=channels)
    for band in BANDS:
        if band not in channels:
            result.bands[band] = empty_set(chosen)
            continue
        mine = [d for d in dataset.distributions if d.channel == channels[band]]
        refuse_raw(mine)
        incidents = [_incident(chosen, d, faces, dataset.symmetry == "isotropic") for d in mine]
        block = _fill_block(chosen, incidents, dataset.symmetry == "isotropic", fill)
        clip(block, chosen)
        _check_energy(block, chosen, band, result.findings)
        result.bands[band] = block
    if assume_flat and len(channels) == 1:
        source = next(iter(channels))
        target: Band = "Solar" if source == "Visible" else "Visible"
        result.bands[target] = result.bands[source]
        result.copied = (source, target)
    return result


def _channels(dataset: Dataset, channel: str | None) -> dict[Band, str]:
    present = sorted({d.channel for d in dataset.distributions})
    if not present:
        raise UsageError("the dataset has no distribution; reduce or import one first")
    if channel is not None:
        if channel not in present:
            raise UsageError(f"no channel {channel!r} in the dataset; it has {', '.join(present)}")
        return {"Solar" if channel.lower() == "solar" else "Visible": channel}
    found: dict[Band, str] = {}
    for name in present:
        for band in BANDS:
            if name.lower() == band.lower():
                found[band] = name
    if not found:
        raise UsageError(f"no channel is called visible or solar; name one with --channel: {', '.join(present)}")
    return found


def _incident(basis: KlemsBasis, points: Distribution, faces: Side, isotropic: bool) -> _Incident:
    theta_r, phi_r = to_radiance_deg(points.theta_deg, points.phi_deg, faces)
    theta_i, phi_i = to_radiance_deg(points.incident_theta_deg, points.incident_phi_deg, faces)
    side, polar, azimuth = incident_place(float(theta_i), float(phi_i))
    # Bins are 0.25 degrees: an isotropic sample's profile counts from its column azimuth, so that shifts are exact.
    zero = azimuth if isotropic else 0.0
    if not np.any(points.solid_angle_sr > 0):
        where = f"{points.incident_theta_deg:g}/{points.incident_phi_deg:g}"
        raise UsageError(
            f"incident {where}: the points cover no solid angle: not reduced yet, or the scan ended there; reduce the"
            " dataset, or finish the scan (gonio scan --resume)"
        )
    profiles = {}
    for interior in (True, False):
        profile = hemisphere_profile(basis, points, theta_r if interior else 180.0 - theta_r, phi_r - zero)
        if profile is not None:
            profiles[process_of(side, interior)] = profile
    return _Incident(side, polar, azimuth, profiles)


def _fill_block(basis: KlemsBasis, incidents: list[_Incident], isotropic: bool, fill: Fill) -> MatrixSet:
    block = empty_set(basis)
    for (process, side), matrix in block.matrices.items():
        mine = [i for i in incidents if i.side == side and process in i.profiles]
        if not mine:
            continue
        origin = block.origin[process, side]
        columns: dict[int, PatchValues] = {}
        block.outermost_deg[process, side] = min(i.profiles[process].outermost_deg for i in mine)
        for column in range(basis.size):
            kind, profile = _column_profile(basis, mine, process, column, isotropic=isotropic, fill=fill)
            if profile is None:
                continue
            columns[column] = values = profile.patches()
            matrix[:, column] = values.bsdf_per_sr
            origin[column] = kind
            if kind == MEASURED:
                block.filled_patches += int(np.count_nonzero(values.filled))
        direct = (origin == MEASURED) | (origin == ROTATED)
        block.uncertainty[process, side] = PatchUncertainty.of_columns(columns, direct, basis.projected_solid_angle_sr)
    return block


def _column_profile(
    basis: KlemsBasis, mine: list[_Incident], process: Process, column: int, *, isotropic: bool, fill: Fill
) -> tuple[int, HemisphereProfile | None]:
    """Origin and profile of one column, azimuths counted from the frame's x."""
    ring = int(np.searchsorted(basis.ring_start, column, side="right")) - 1
    centre = float(basis.centres_deg[column, 1])
    in_ring = [i for i in mine if int(basis.ring_of(i.polar_deg)) == ring]
    in_patch = [i for i in in_ring if int(basis.patch_of(i.polar_deg, i.azimuth_deg)) == column]
    if isotropic and in_ring:
        width = 360.0 / basis.rings[ring].patches
        profile = mean_profile([i.profiles[process] for i in in_ring]).smeared(width).shifted(centre)
        return MEASURED if in_patch else ROTATED, profile
    if in_patch:
        return MEASURED, mean_profile([i.profiles[process] for i in in_patch])
    if fill == "none":
        return ZERO, None
    nominal = float(basis.centres_deg[column, 0])
    nearest = min(mine, key=lambda i: (abs(i.polar_deg - nominal), abs((i.azimuth_deg - centre + 180) % 360 - 180)))
    turn = centre - (0.0 if isotropic else nearest.azimuth_deg)
    return FILLED, nearest.profiles[process].shifted(turn)


def clip(block: MatrixSet, basis: KlemsBasis) -> None:
    """Negative averages become 0, which is counted."""
    for matrix in block.matrices.values():
        added = basis.projected_solid_angle_sr @ np.maximum(-matrix, 0.0)
        block.negative_patches += int(np.count_nonzero(matrix < 0))
        block.negative_added = max(block.negative_added, float(added.max()))
        np.maximum(matrix, 0.0, out=matrix)


def _check_energy(block: MatrixSet, basis: KlemsBasis, band: Band, findings: Findings) -> None:
    """Transmission and reflection of one incident patch share their systematic errors: they add up with their signs."""
    for side in SIDES:
        total = sum((basis.projected_solid_angle_sr @ block.matrices[p, side] for p in PROCESSES), np.zeros(basis.size))
        parts = [block.uncertainty[p, side] for p in PROCESSES if (p, side) in block.uncertainty]
        column = int(np.argmax(total))
        if total[column] <= 1.0 or not parts:
            continue
        u = PatchUncertainty.u_of_total(parts, column)
        polar, azimuth = basis.centres_deg[column]
        what = (
            f"{band} {side}, incident patch {column + 1} (theta {polar:g}, column azimuth {azimuth:g}): "
            f"transmission plus reflection sum to {total[column]:.4f}"
        )
        if total[column] > 1.0 + 2.0 * u:
            raise CheckFailed(f"{what}, over 1 by more than twice its uncertainty {u:.4f}; check the reference scan")
        findings.add("warning", "energy", f"{band} {side}", f"{what}, within 2 u = {2 * u:.4f} of 1.")


def counted(cells: NDArray[np.uint8]) -> str:
    """How many cells of each incident patch are of which origin; patches that follow each other and are alike, once."""
    counts = np.stack([np.count_nonzero(cells == kind, axis=0) for kind in Origin], axis=1)
    starts = np.concatenate(([0], np.flatnonzero(np.any(counts[1:] != counts[:-1], axis=1)) + 1, [len(counts)]))
    runs = []
    for first, end in pairwise(starts.tolist()):
        patches = f"{first + 1}" if end == first + 1 else f"{first + 1}-{end}"
        runs.append(f"{patches}: {'/'.join(str(n) for n in counts[first])}")
    return f"outgoing cells measured/interpolated/extrapolated/absent, by incident patch: {'; '.join(runs)}."


def empty_set(basis: KlemsBasis) -> MatrixSet:
    """Zeros that nobody measured."""
    keys = [(process, side) for process in PROCESSES for side in SIDES]
    return MatrixSet(
        {key: np.zeros((basis.size, basis.size)) for key in keys},
        {key: np.zeros(basis.size, dtype=np.uint8) for key in keys},
    )
