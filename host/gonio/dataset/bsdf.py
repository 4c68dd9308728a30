"""bsdf.py: a BSDF dataset in memory: point lists of the DSF per incident direction, with all that explains them."""

from dataclasses import dataclass, field
from enum import IntFlag
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Side = Literal["exterior", "interior", "undeclared"]
Polarisation = Literal["unpolarised", "s", "p", "unknown"]
Symmetry = Literal["none", "isotropic", "bilateral", "quadrilateral", "up", "undeclared"]


class PointFlag(IntFlag):
    """Why a point is what it is; 0 is a plain measured point. Bits are stored in HDF5, append only."""

    MEASURED = 0
    SHADOWED = 1  # masked: the detector's head shades the source
    UNREACHABLE = 2  # masked: limits or collision zones; no sample was taken
    HOLDER = 4  # masked: behind the sample holder; reserved, nothing sets it yet
    SATURATED = 8  # masked: both gains saturated
    POSE_LOST = 16  # masked: no valid pose around the sample
    CLOCK_UNSETTLED = 32  # masked: no sample clock yet
    INTERPOLATED_POSE = 64  # used: a SYNC or TPDO next to it was lost
    LOW_SIGNAL = 128  # used: under three standard deviations of the noise
    SIMULATED = 256  # used: not measured but computed
    NOT_MEASURED = 512  # masked: the plan had it, the scan ended before; reserved, nothing sets it yet
    STROBE_LOST = 1024  # used: a strobe edge beside it was lost or rejected; its time rests on the fit of the others


MASKED = (
    PointFlag.SHADOWED
    | PointFlag.UNREACHABLE
    | PointFlag.HOLDER
    | PointFlag.SATURATED
    | PointFlag.POSE_LOST
    | PointFlag.CLOCK_UNSETTLED
    | PointFlag.NOT_MEASURED
)


@dataclass
class Distribution:
    """Scattered distribution for one incident direction and one channel.

    Angles follow CONVENTIONS.md: theta 0-180 from the front normal, phi 0-360, both away from the sample.
    All arrays have shape (n,). Masked points (flags & MASKED) have NaN in `dsf_per_sr`.
    """

    incident_theta_deg: float
    incident_phi_deg: float
    theta_deg: NDArray[np.float64]
    phi_deg: NDArray[np.float64]
    dsf_per_sr: NDArray[np.float64]  # signal / (normalisation * P_i) [1/sr]
    variance_per_sr2: NDArray[np.float64]  # of dsf_per_sr, independent part
    signal: NDArray[np.float64]  # dark-subtracted, in counts of the low gain
    normalisation: NDArray[np.float64]  # lamp monitor relative to the reference scan
    count: NDArray[np.int32]  # samples in the point
    flags: NDArray[np.uint16]  # PointFlag
    solid_angle_sr: NDArray[np.float64]  # spherical cell; 0 for points that only repeat another
    time_ns: NDArray[np.int64]  # controller clock; 0 where there is none
    channel: str = "visible"
    wavelength_nm: float | None = None
    p_i: float = 1.0  # reference beam, signal * sr; NaN: not normalised, dsf_per_sr is NaN and signal has the values
    p_i_u_rel: float = 0.0
    signal_unit: str = "counts"  # what signal and P_i are in: "A" of a photocurrent that was imported
    integrals: dict[str, float] = field(default_factory=dict)  # see reduce.integrals
    # Contributions [as the integral] to the standard uncertainty of integrals: name of the integral, then effect.
    budgets: dict[str, dict[str, float]] = field(default_factory=dict)
    # Change of the DSF (n,) [1/sr] for one standard deviation of a systematic effect, signed; keys: dataset/effects.py.
    # One key is one cause: it moves all points of all distributions of this dataset together. NaN where masked.
    effects: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    # Weights (n,) of the integral of linear interpolation over the Delaunay triangles; beside the cells they tell what
    # the finite number of points costs (reduce/integrals). Empty: not known.
    linear_solid_angle_sr: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    # Path of each point (n,), an index in `paths`; -1: none. Empty: not known.
    path: NDArray[np.int32] = field(default_factory=lambda: np.zeros(0, dtype=np.int32))
    paths: tuple[str, ...] = ()  # "coarse 30/0", "mirror 30/0", ... in the order flown

    @property
    def measured(self) -> NDArray[np.bool_]:
        """Points that hold a value, shape (n,)."""
        return np.asarray((self.flags & MASKED) == 0)


@dataclass
class Dataset:
    """A whole BSDF file. `provenance` holds configuration, calibration, versions, the raw logs' hashes, corrections in
    order and counters of lost samples, edges and frames: plain JSON values."""

    distributions: list[Distribution]
    sample_name: str = ""
    front_faces: Side = "undeclared"
    polarisation: Polarisation = "unknown"
    symmetry: Symmetry = "undeclared"  # declared by the user, never guessed
    thickness_mm: float | None = None
    manufacturer: str = ""
    provenance: dict[str, Any] = field(default_factory=dict)
    # The free beam: unit vectors' polar angle from its axis and azimuth about it, signal, cell; empty when imported.
    beam: Distribution | None = None
