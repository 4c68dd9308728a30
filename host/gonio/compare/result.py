"""result.py: what a comparison gives: matched distributions point by point, their metrics, and what was not matched.

A is the reference, B is compared with it; everything stands at the directions of A. Percentages are in percent.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# How B came to A's directions: it has the same points; it was evaluated there; it was interpolated linearly.
Route = Literal["same points", "evaluated", "interpolated"]
# Part of the sphere that a set of metrics is about; "reflection" is the hemisphere of the incident direction.
Region = Literal["whole", "reflection", "transmission"]

COVERAGE_FACTOR = 2.0  # of what is called "beyond the uncertainty"
WITHIN_PERCENT = (5.0, 10.0, 20.0)
WITHIN_U = (1.0, 2.0, 3.0)
GOOD_PERCENT, VERY_GOOD_PERCENT = 98.0, 99.0  # of global accordance; paper [1], section 5


@dataclass(frozen=True)
class Settings:
    """What the user may choose: how far apart incident directions may lie, the least DSF of A that relative deviations
    are taken of, the half angle of the biconical integrals."""

    incident_tolerance_deg: float = 0.5
    floor_per_sr: float = 1e-3
    cone_deg: float = 7.0


@dataclass(frozen=True)
class Metric:
    """One figure of merit in all its forms; None where a form is not defined.

    value: all points alike. by_solid_angle: points weighted by their cells. from_uncertainty: what the form `value`
    would be if A and B differed by their stated uncertainties alone. in_u: the deviation in units of what the
    uncertainties explain (1: explained; more: not). u: standard uncertainty of `value`; u_by_solid_angle: of the other.
    """

    value: float | None = None
    u: float | None = None
    by_solid_angle: float | None = None
    u_by_solid_angle: float | None = None
    from_uncertainty: float | None = None
    in_u: float | None = None


@dataclass(frozen=True)
class Share:
    """Share of points within a limit, in percent: counted, and by solid angle."""

    limit: float
    value: float | None
    by_solid_angle: float | None


@dataclass(frozen=True)
class Metrics:
    """All metrics of one region of one pair of distributions."""

    region: Region
    points: int
    solid_angle_sr: float
    left_out: dict[str, int]  # points of A in the region that do not count: reason, number
    global_accordance_percent: Metric
    global_accordance_by_uncertainty_percent: float | None  # points weighted by 1/u^2
    accordance_class: Literal["very good", "good", "below good", "undefined"]
    local_accordance_percent: Metric  # mean over the points
    local_accordance_beyond_uncertainty_percent: float | None  # mean, of what COVERAGE_FACTOR u leave unexplained
    local_accordance_undefined: int  # points with A + B <= 0
    local_accordance_both_zero: int  # points with A = B = 0: 100 %
    bias_per_sr: Metric  # mean of B - A
    bias_percent: Metric  # of the mean of A
    rmse_per_sr: Metric
    cv: Metric
    within_percent: tuple[Share, ...]  # |B - A| relative to A, points over the floor
    floor_per_sr: float
    under_floor: int
    under_floor_sr: float
    within_u: tuple[Share, ...]  # |B - A| in units of u(A - B)
    without_uncertainty: int  # points whose u(A - B) is 0
    chi_square_per_point: float | None  # mean of ((B - A) / u)^2
    # (B - A) . covariance^-1 . (B - A) / points: sharp where effects are linear; at a steep edge they are not.
    chi_square_with_correlations_per_point: float | None


@dataclass(frozen=True)
class IntegralDelta:
    """delta = 100 |1 - B / A| of one integral; `signed_percent` = 100 (B / A - 1); u: standard uncertainty of that."""

    name: str
    a: float
    b: float
    u_a: float
    u_b: float
    delta_percent: float | None  # None where A is 0
    signed_percent: float | None
    u_percent: float | None
    in_u: float | None  # (B - A) / u(B - A)


@dataclass(frozen=True)
class Profile:
    """The scatter plane on one side of the sample, arrays (m,): -85 to 85 degrees in steps of 0.1.

    `angle_deg` is from that side's own normal, positive on the side of the mirror direction and of straight through;
    theta is |angle| in the hemisphere of the front normal and 180 - |angle| in the other one.
    """

    region: Region
    angle_deg: FloatArray
    theta_deg: FloatArray
    phi_deg: FloatArray
    a_per_sr: FloatArray  # NaN where masked or outside what was measured
    b_per_sr: FloatArray
    u_a_per_sr: FloatArray
    u_b_per_sr: FloatArray
    used: BoolArray
    cv_rmsd: Metric  # RMSE / mean of A
    within_percent: tuple[Share, ...]  # by_solid_angle is None: the steps are equal
    under_floor: int


@dataclass(frozen=True)
class PathTrace:
    """Directions in the order flown, arrays (m,); `path` is an index in `names`, -1: no path, or none is known."""

    theta_deg: FloatArray
    phi_deg: FloatArray
    path: NDArray[np.int32]
    names: tuple[str, ...]


@dataclass(frozen=True)
class Pair:
    """One distribution of A and what B says at its points; arrays (n,) in the order of A."""

    channel: str
    incident_theta_deg: float  # of A
    incident_phi_deg: float
    b_channel: str
    b_incident_theta_deg: float
    b_incident_phi_deg: float
    route: Route
    theta_deg: FloatArray
    phi_deg: FloatArray
    solid_angle_sr: FloatArray
    a_per_sr: FloatArray  # DSF, NaN where masked
    b_per_sr: FloatArray  # DSF, NaN where B has none
    u_a_per_sr: FloatArray  # combined standard uncertainties
    u_b_per_sr: FloatArray
    u_difference_per_sr: FloatArray  # of A - B: what both share has cancelled
    used: BoolArray  # both have a value
    local_accordance_percent: FloatArray  # NaN where undefined or not used
    deviation_in_u: FloatArray  # (B - A) / u(A - B); NaN where not used or without uncertainty
    metrics: dict[Region, Metrics]  # only regions with points
    integrals: tuple[IntegralDelta, ...]
    profiles: tuple[Profile, ...]
    path_a: PathTrace
    path_b: PathTrace | None  # None: a model
    shared_effects: tuple[str, ...]  # that cancel in A - B
    interpolation_per_sr: FloatArray | None  # estimated error of interpolation, signed; None: B was not interpolated


@dataclass(frozen=True)
class Comparison:
    """The whole: A the reference, B compared with it."""

    a_name: str  # file names as given
    b_name: str
    b_kind: Literal["dataset", "scenario", "matrices", "tree", "model", "simulation"]
    pairs: tuple[Pair, ...]
    unmatched_a: tuple[str, ...]  # "visible (30, 0)"
    unmatched_b: tuple[str, ...]
    settings: Settings
    remarks: tuple[str, ...] = ()
