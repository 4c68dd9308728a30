"""polar_rule.py: exact hemispherical integrals of distributions with one peak at the mirror or through direction."""

from collections.abc import Callable

import numpy as np

from gonio.dataset.scattering import FloatArray, IndexArray

_NODE, _WEIGHT = np.polynomial.legendre.leggauss(16)
_GRADES = 40  # panels that halve towards the peak: the finest is 2^-40 of the coarsest
_FINE = 4  # panels per halving where a power law may roll off steeply


def graded(panels: int = _GRADES, per_halving: int = 1) -> tuple[FloatArray, FloatArray]:
    """Nodes and weights on (0, 1), in panels that shrink by 2^(1/per_halving) towards 0; 16 Gauss points each."""
    edges = np.concatenate(([0.0], 2.0 ** (-np.arange(panels * per_halving, -1, -1) / per_halving)))
    half, middle = np.diff(edges) / 2.0, (edges[1:] + edges[:-1]) / 2.0
    return (middle[:, None] + half[:, None] * _NODE).ravel(), (half[:, None] * _WEIGHT).ravel()


def radial_integral(of_distance: Callable[[FloatArray], FloatArray], sin_theta: FloatArray) -> FloatArray:
    """Integral (k,) over the projected hemisphere, the unit disc of direction cosines, of a function of the distance
    from a point `sin_theta` (k,) off its centre. `of_distance` takes (k, n) distances and gives (k, n) values.

    Circles about that point lie wholly inside up to 1 - c, c = sin_theta; beyond, the share of their arc that lies
    inside is acos((c - cos psi) / r) / pi, where r^2 = 1 + c^2 - 2 c cos psi meets the rim at azimuth psi, so
    r dr = c sin psi dpsi: both parts are smooth, and panels graded towards the centre and the nearest rim follow
    any scale of the function.
    """
    c = np.asarray(sin_theta, dtype=np.float64)[:, None]
    node, weight = graded(per_halving=_FINE)
    inner = 1.0 - c
    r = inner * node
    full = 2.0 * np.pi * np.sum(of_distance(r) * r * inner * weight, axis=1)
    psi = np.pi * node
    r = np.sqrt((1.0 - c) ** 2 + 4.0 * c * np.sin(psi / 2.0) ** 2)
    r = np.maximum(r, 1e-300)
    # c - cos psi loses digits near psi = 0: c - 1 + 2 sin^2(psi / 2)
    arc = 2.0 * np.arccos(np.clip((c - 1.0 + 2.0 * np.sin(psi / 2.0) ** 2) / r, -1.0, 1.0))
    part = np.sum(of_distance(r) * arc * c * np.sin(psi) * np.pi * weight, axis=1)
    return np.asarray(full + part)


_AZIMUTHS = 80  # over half a turn; the distribution is symmetric about the plane of incidence


def peak_rule(centre: float, rim: float) -> tuple[FloatArray, FloatArray]:
    """Outgoing unit vectors (n, 3) and weights (n,) for integrals of a BSDF over projected solid angle, incidence in
    the plane y = 0: polar coordinates in direction cosines about (centre, 0), graded towards it, within `rim` of the
    normal; y > 0, counted twice.

    Midpoints in azimuth: the radial integral is an analytic, periodic function of it, so the rule converges
    geometrically, at a rate set by the lobe's aspect ratio, about 1 / cos theta_i.
    """
    turn = np.pi * (np.arange(_AZIMUTHS) + 0.5) / _AZIMUTHS
    reach = -centre * np.cos(turn) + np.sqrt(rim**2 - (centre * np.sin(turn)) ** 2)
    node, weight = graded(panels=10)
    r = reach[:, None] * node
    x, y = centre + r * np.cos(turn)[:, None], r * np.sin(turn)[:, None]
    z = np.sqrt(np.maximum(1.0 - x**2 - y**2, 0.0))
    unit = np.stack((x, y, z), axis=-1).reshape(-1, 3)
    return unit, (2.0 * np.pi / _AZIMUTHS * r * reach[:, None] * weight).ravel()


def integral_about(
    bsdf: Callable[[FloatArray, FloatArray, FloatArray, IndexArray], FloatArray],
    values: FloatArray,
    incident: FloatArray,
    centre: FloatArray,
    rim: FloatArray | float = 1.0,
) -> FloatArray:
    """Hemispherical integrals (k,) of a family's `bsdf_per_sr` whose only peak lies at the direction cosines
    (centre (k,), 0) where light comes from azimuth 0, and which is 0 beyond the distance `rim` (k,) from the normal.
    Equal rows are worked out once."""
    beyond = np.broadcast_to(rim, centre.shape)
    rows = np.column_stack((values, np.hypot(incident[:, 0], incident[:, 1]), centre, beyond))
    different, back = np.unique(rows, axis=0, return_inverse=True)
    total = np.zeros(len(different))
    for at, own in enumerate(different):
        unit, weight = peak_rule(float(own[-2]), float(own[-1]))
        sine = float(own[-3])
        light = np.array([[sine, 0.0, np.sqrt(1.0 - sine**2)]])
        total[at] = weight @ bsdf(own[None, :-3], light, unit, np.zeros(len(unit), dtype=np.int64))
    return np.asarray(total[back.reshape(-1)])
