"""patches.py: whole BSDF matrices of a scenario's sample, its light filling each incident patch of an angle basis: what
`gonio simulate --format klems-full` does."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Side
from gonio.formats.window import write as window_xml
from gonio.formats.window.klems import KlemsBasis, LightSide, Process, basis_named, direction_of_patch_deg
from gonio.formats.window.matrices import BANDS, MEASURED, PROCESSES, SIDES, Band, KlemsMatrices, empty_set
from gonio.simulate.bundle import read_document
from gonio.simulate.progress import PhotonProgress
from gonio.simulate.readings import BALANCE, FloatArray, Part, PatchJob, added
from gonio.simulate.request import Request
from gonio.simulate.setting import PhotonSetting, open_setting
from gonio.units.errors import CheckFailed, UsageError
from gonio.units.version import gonio_version

# Per incident patch, where nobody says. Through the louver 4600 have the root mean square error of genBSDF's default of
# 2000 samples (host/benchmarks/bench_sim.py).
PHOTONS = 20_000
_MOST_TIMES = 1000  # these, where an error is asked for
_LEAST_LIT = 0.01  # of the mean of a column: a patch with less has no relative error worth telling (as campaign.py)
_MOST_SIGMA = 5.0  # that one of all column sums may be above 1 by chance
_ROUNDING = 1e-9
_SUN = {"solar", "near-infrared"}


@dataclass(frozen=True)
class Shares:
    """Share of each incident patch's light that leaves through each outgoing one, arrays (2, n, 2 n): front lit, back
    lit; incident patch; patches of the lit side, then of the other. Patches of the sample frame."""

    share: FloatArray
    error: FloatArray  # standard error
    total: FloatArray  # (2, n): of all that leaves
    total_error: FloatArray

    @property
    def median_error(self) -> float:
        """Relative, over the patches with light; 0 where there is none."""
        lit = (self.share > 0.0) & (self.share >= _LEAST_LIT * self.share.mean(axis=2, keepdims=True))
        return float(np.median(self.error[lit] / self.share[lit])) if lit.any() else 0.0


@dataclass(frozen=True)
class SimulatedMatrices:
    """Matrices and all that their file says beside them; the photon balance over all columns."""

    matrices: KlemsMatrices
    described: Dataset  # the sample, without distributions
    balance: dict[str, int]
    remarks: list[str]
    blocks: list[dict[str, Any]]  # per simulated block: band, errors, energy; plain JSON

    def render(self) -> bytes:
        """The WINDOW XML."""
        return window_xml.render(self.described, self.matrices, window_xml.ThermalValues())


def simulate_matrices(
    request: Request, basis: str, front_faces: Side, progress: PhotonProgress, *, assume_flat: bool = False
) -> SimulatedMatrices:
    """All columns of all four matrices, for the scenario's band "visible" and for "solar" or "near-infrared".

    `assume_flat`: the block that no band gives is a copy of the other one. Raises UsageError for wrong input,
    CheckFailed where more light leaves than came.
    """
    chosen = basis_named(basis)
    sides = {side: _Places.of(chosen, side, front_faces) for side in SIDES}
    _check(request)
    with open_setting(request, progress) as setting:
        assert isinstance(setting, PhotonSetting)
        wavelengths = dict(setting.bands)
        bands = _bands_of_blocks(list(wavelengths), request)
        depth_mm = max(setting.laboratory.depth_mm(band, basis) for band in bands.values())
        jobs = [PatchJob(band, basis, lit, p) for band in bands.values() for lit in (True, False) for p in _all(chosen)]
        progress.begin("patches")
        parts = _trace(setting, jobs, request)
        seed = setting.provenance["seed"]
        digest = setting.provenance["files_sha256"][request.scenario.name]
    made = KlemsMatrices(chosen, {}, front_faces, channel_of=dict(bands), simulated=True)
    made.notes = [
        f"gonio simulate {gonio_version()} of {request.scenario.name} (SHA-256 {digest}), seed {seed}: unpolarised "
        "light fills each incident patch, in proportion to the cosine, on one period of the sample."
    ]
    blocks = []
    count = 2 * chosen.size
    for number, (block, band) in enumerate(bands.items()):
        of_band = parts[number * count : (number + 1) * count]
        shares = shares_of(of_band)
        made.bands[block] = empty_set(chosen)
        for (process, side), matrix in made.bands[block].matrices.items():
            matrix[:] = sides[side].bsdf_per_sr(process, shares)
            made.bands[block].origin[process, side][:] = MEASURED
        blocks.append(_describe(block, band, shares, of_band))
        made.notes += _notes(blocks[-1], wavelengths[band])
    _complete(made, assume_flat=assume_flat)
    balance = dict.fromkeys(BALANCE, 0)
    for part in parts:
        balance = added(balance, part.balance)
    described = Dataset(
        [], f"simulated: {request.scenario.stem}", polarisation="unpolarised", thickness_mm=depth_mm or None
    )
    remarks = made.remarks() + _shortfalls(request, setting.bands, bands, blocks, balance)
    return SimulatedMatrices(made, described, balance, remarks, blocks)


@dataclass(frozen=True)
class _Places:
    """Which patches of ours are the columns and rows of the matrices of light that arrives from one side."""

    basis: KlemsBasis
    front_lit: bool
    columns: dict[Process, NDArray[np.int64]]
    rows: dict[Process, NDArray[np.int64]]

    @classmethod
    def of(cls, basis: KlemsBasis, side: LightSide, front_faces: Side) -> "_Places":
        """Raises UsageError when it is not declared which way the front faces."""
        columns, rows = {}, {}
        for process in PROCESSES:
            pairs = [
                direction_of_patch_deg(basis, process, side, row=patch, column=patch, front_faces=front_faces)
                for patch in _all(basis)
            ]
            columns[process], rows[process] = (_numbers(basis, [pair[end] for pair in pairs]) for end in (0, 1))
        return cls(basis, (side == "Front") == (front_faces == "exterior"), columns, rows)

    def bsdf_per_sr(self, process: Process, shares: Shares) -> FloatArray:
        """A matrix, shape (rows, columns): B = share / integral of the cosine over the outgoing patch."""
        part = self.rows[process] + (self.basis.size if process == "Transmission" else 0)
        share = shares.share[0 if self.front_lit else 1][np.ix_(self.columns[process], part)]
        return np.asarray(share.T / self.basis.projected_solid_angle_sr[:, None])


def shares_of(parts: Sequence[Part]) -> Shares:
    """Of the columns of one band: all patches with the front lit, then all with the back lit. Raises CheckFailed."""
    photons = np.array([part.balance["photons"] for part in parts], dtype=np.float64)
    unit = parts[0].balance["emitted"] / parts[0].balance["photons"]  # whole weight of one photon

    def estimated(weight: FloatArray, square: FloatArray) -> tuple[FloatArray, FloatArray]:
        number = photons[:, None]
        mean = weight / unit / number
        error = np.sqrt(np.maximum(square / unit / number - mean**2, 0.0) / number)
        return mean.reshape(2, len(parts) // 2, -1), error.reshape(2, len(parts) // 2, -1)

    weight = np.array([part.weight for part in parts]).astype(np.float64)
    square = np.array([part.square for part in parts]).astype(np.float64)
    share, error = estimated(weight, square)
    # A photon leaves once at most, so the squares add up too.
    total, total_error = (
        values[:, :, 0] for values in estimated(weight.sum(axis=1)[:, None], square.sum(axis=1)[:, None])
    )
    over = total - 1.0 - _MOST_SIGMA * total_error
    if over.max() > _ROUNDING:
        lit, patch = np.unravel_index(int(np.argmax(over)), over.shape)
        raise CheckFailed(
            f"light on the {'back' if lit else 'front'} in patch {patch + 1} of the sample frame: "
            f"{total[lit, patch]:.4f} of it leaves, more than comes; check reflectances and tables of the materials"
        )
    # Materials that draw with weights give light on average: what is above 1 by chance is brought back to 1.
    scale = 1.0 / np.maximum(total, 1.0)
    return Shares(share * scale[:, :, None], error * scale[:, :, None], total, total_error)


def _all(basis: KlemsBasis) -> range:
    return range(basis.size)


def _numbers(basis: KlemsBasis, directions_deg: list[tuple[float, float]]) -> NDArray[np.int64]:
    """Patches of directions of ours, each about the normal of its own side."""
    theta, phi = np.array(directions_deg).T
    return basis.patch_of(np.minimum(theta, 180.0 - theta), phi)


def _check(request: Request) -> None:
    document = read_document(request.scenario)
    sample, rig = document.get("sample"), document.get("rig")
    if not isinstance(sample, dict) or "kind" not in sample:
        raise UsageError(
            f"{request.scenario}: a closed form has no light that fills patches: simulate a dataset and export it"
        )
    if isinstance(rig, dict) and "holder" in rig:
        raise UsageError(f"{request.scenario}: rig.holder would shade light from all directions: leave it out")


def _bands_of_blocks(names: list[str], request: Request) -> dict[Band, str]:
    """Which band is written as which block."""
    found: dict[Band, str] = {}
    for name in names:
        if name.lower() == "visible":
            found["Visible"] = name
        if name.lower() in _SUN and found.get("Solar", "").lower() != "solar":
            found["Solar"] = name
    if not found:
        raise UsageError(
            f"{request.scenario}: no band is called visible, solar or near-infrared, but {', '.join(names)}: rename one"
        )
    return {block: found[block] for block in BANDS if block in found}


def _trace(setting: PhotonSetting, jobs: list[PatchJob], request: Request) -> list[Part]:
    from gonio.simulate.campaign import Effort, complete  # noqa: PLC0415 - needs the compiled module

    # The scenario's own numbers are for apertures, a hundred times smaller than patches.
    photons = request.photons or PHOTONS
    effort = Effort(photons, request.relative_error or 0.0, _MOST_TIMES * photons)
    parts = complete(jobs, effort, setting.crew, setting.progress)
    return [part for part in parts if isinstance(part, Part)]


def _describe(block: Band, band: str, shares: Shares, parts: Sequence[Part]) -> dict[str, Any]:
    photons = [part.balance["photons"] for part in parts]
    lit, patch = np.unravel_index(int(np.argmax(shares.total)), shares.total.shape)
    return {
        "block": block,
        "band": band,
        "photons_per_patch": [min(photons), max(photons)],
        "median_relative_error": shares.median_error,
        "largest_column_sum": float(shares.total[lit, patch]),
        "largest_column_sum_error": float(shares.total_error[lit, patch]),
        "largest_error_of_a_column_sum": float(shares.total_error.max()),
        "columns_scaled_to_1": int(np.count_nonzero(shares.total > 1.0 + _ROUNDING)),
    }


def _notes(block: dict[str, Any], wavelength_nm: float | None) -> list[str]:
    name, band = block["block"], block["band"]
    least, most = block["photons_per_patch"]
    photons = f"{least}" if least == most else f"{least} to {most}"
    notes = [
        f"{name}: {photons} photons per incident patch; median relative standard error of a patch with light "
        f"{block['median_relative_error']:.2%}; largest column sum {block['largest_column_sum']:.4f}, standard error "
        f"{block['largest_column_sum_error']:.4f} (of any column sum at most "
        f"{block['largest_error_of_a_column_sum']:.4f})."
    ]
    if block["columns_scaled_to_1"]:
        notes.append(f"{name}: {block['columns_scaled_to_1']} column sums above 1 by chance were scaled to 1.")
    at = "" if wavelength_nm is None else f", optics at {wavelength_nm:g} nm"
    if name == "Solar":
        notes.append(f"Solar: the scenario's band {band}{at}; not an average over the solar spectrum made by gonio.")
    return notes


def _complete(made: KlemsMatrices, *, assume_flat: bool) -> None:
    """Fills the block that no band gave: zeros, or a copy where it is declared."""
    for block in BANDS:
        if block in made.bands:
            continue
        source: Band = "Solar" if block == "Visible" else "Visible"
        if assume_flat:
            made.bands[block] = made.bands[source]
            made.copied = (source, block)
        else:
            made.bands[block] = empty_set(made.basis)
    made.bands = {block: made.bands[block] for block in BANDS}


def _shortfalls(
    request: Request,
    named: Sequence[tuple[str, float | None]],
    bands: dict[Band, str],
    blocks: Sequence[dict[str, Any]],
    balance: dict[str, int],
) -> list[str]:
    """What the user did not get, one sentence each."""
    remarks = [f'band "{band}" has no place in the file and was not simulated' for band, _ in named]
    remarks = [remark for remark, (band, _) in zip(remarks, named, strict=True) if band not in bands.values()]
    goal = request.relative_error or 0.0
    remarks += [
        f"{block['block']}: the error of {goal:.2%} was not reached: raise --photons"
        for block in blocks
        if block["median_relative_error"] > goal > 0.0
    ]
    if balance["lost"]:
        share = balance["lost"] / balance["emitted"]
        remarks.append(f"{share:.2g} of the light was lost after most_interactions: raise it")
    return remarks
