"""voronoi_parts.py: area and first moment between a point and an edge of its spherical Voronoi cell, cut or whole."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class EdgeFrame:
    """The Voronoi edges between points a and b, both (m, 3). An edge lies on the great circle that bisects ab; `arc`
    (2, m) are the angles along that circle from the middle of ab to the edge's two ends, `half` (m,) half the angle
    ab. Seen from a the middle lies towards `outwards` (m, 3) and the arc grows towards `along` (m, 3)."""

    a: FloatArray
    b: FloatArray
    half: FloatArray
    arc: FloatArray
    outwards: FloatArray
    along: FloatArray
    behind: NDArray[np.bool_]  # (m,) the edge passes the far side of its circle, where arc jumps from pi to -pi

    def reversed(self) -> "EdgeFrame":
        """The same edges as b sees them."""
        across = self.a + self.b
        towards = _unit(self.a - self.b * np.einsum("ij,ij->i", self.a, self.b)[:, None], across)
        return EdgeFrame(self.b, self.a, self.half, self.arc, towards, self.along, self.behind)


def edge_frame(
    a: FloatArray, b: FloatArray, centre_f: FloatArray, centre_g: FloatArray, sense: FloatArray
) -> EdgeFrame:
    """Frame of the edges that run from the circumcentres f to g (m, 3); `sense` (m,) is 1 where chord ab x middle
    points from f to g, else -1."""
    chord, middle = b - a, a + b
    across = np.cross(chord, middle) * sense[:, None]
    length = np.linalg.norm(chord, axis=1)
    # |chord x middle| = |chord| |middle|, as both points have unit length: put both components on the same scale.
    arc = np.stack(
        [
            np.arctan2(np.einsum("ij,ij->i", c, across), length * np.einsum("ij,ij->i", c, middle))
            for c in (centre_f, centre_g)
        ]
    )
    half = np.arcsin(np.minimum(0.5 * length, 1.0))
    outwards = _unit(b - a * np.einsum("ij,ij->i", a, b)[:, None], middle)
    return EdgeFrame(a, b, half, arc, outwards, _unit(across, middle), arc[1] - arc[0] < -0.5 * np.pi)


def triangle_excess(half: FloatArray, arc: FloatArray) -> FloatArray:
    """Area of the right triangle with the legs h and beta, signed as beta: tan(E/2) = tan(h/2) tan(beta/2) (spherical
    excess of a right triangle; I. Todhunter, Spherical Trigonometry, 1886, art. 103), continued past beta = 90
    degrees."""
    return np.asarray(2.0 * np.arctan2(np.sin(0.5 * half) * np.sin(0.5 * arc), np.cos(0.5 * half) * np.cos(0.5 * arc)))


def whole(frame: EdgeFrame) -> tuple[FloatArray, FloatArray]:
    """Area (m,) between point a (or b: it is the same) and the edge, and the edge's part (m, 3) of the first moment of
    a's cell (b's has the opposite).

    The first moment of a polygon on the sphere is half the sum of its arcs times the unit normals of their planes,
    inwards (J. H. Lambert, Photometria, 1760).
    """
    once_round = np.where(frame.behind, 2.0 * np.pi, 0.0)
    area = triangle_excess(frame.half, frame.arc[1]) - triangle_excess(frame.half, frame.arc[0]) + once_round
    chord = frame.b - frame.a
    length = np.maximum(np.linalg.norm(chord, axis=1), 1e-300)
    moment = (-0.5 * (frame.arc[1] - frame.arc[0] + once_round) / length)[:, None] * chord
    return area, moment


def within(frame: EdgeFrame, reach: FloatArray) -> tuple[FloatArray, FloatArray]:
    """As `whole`, of the part that is no farther than `reach` (m,) from a; moments (m, 3) include the sides from a.

    Seen from a the border is the edge as far as it is within reach and the circle of radius `reach` beyond: right
    triangles and sectors of a cap.
    """
    pi = np.full(len(reach), np.pi)
    ends = [_from_foot(frame, arc, reach) for arc in (frame.arc[0], frame.arc[1], pi, -pi)]
    turn = frame.behind
    area = ends[1][0] - ends[0][0] + np.where(turn, ends[2][0] - ends[3][0], 0.0)
    moment = ends[1][1] - ends[0][1] + np.where(turn[:, None], ends[2][1] - ends[3][1], 0.0)
    return area, moment


def farthest(frame: EdgeFrame) -> FloatArray:
    """Distance (m,) from a, or b, to the farthest place of the edge."""
    cos_end = np.cos(frame.half) * np.cos(frame.arc).min(axis=0)
    return np.asarray(np.arccos(np.clip(np.where(frame.behind, -np.cos(frame.half), cos_end), -1.0, 1.0)))


def _from_foot(frame: EdgeFrame, arc: FloatArray, reach: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Area (m,) and moment (m, 3) from the foot (the middle of ab) to `arc` (m,), signed as arc."""
    h = frame.half
    inside = np.where(h < reach, np.arccos(np.clip(np.cos(reach) / np.maximum(np.cos(h), 1e-300), -1.0, 1.0)), 0.0)
    arc_in = np.sign(arc) * np.minimum(np.abs(arc), inside)
    angle, angle_in = (np.arctan2(np.sin(beta), np.cos(beta) * np.sin(h)) for beta in (arc, arc_in))
    area = triangle_excess(h, arc_in) + (angle - angle_in) * (1.0 - np.cos(reach))
    hypotenuse = np.arccos(np.clip(np.cos(h) * np.cos(arc_in), -1.0, 1.0))
    inwards = _unit(frame.a - frame.b, frame.a + frame.b)
    slope = 0.5 * (reach - np.sin(reach) * np.cos(reach))
    by_outwards = 0.5 * hypotenuse * np.sin(angle_in) + slope * (np.sin(angle) - np.sin(angle_in))
    by_along = -0.5 * hypotenuse * np.cos(angle_in) - slope * (np.cos(angle) - np.cos(angle_in))
    by_a = 0.5 * np.sin(reach) ** 2 * (angle - angle_in)
    moment = (
        0.5 * arc_in[:, None] * inwards
        + by_outwards[:, None] * frame.outwards
        + by_along[:, None] * frame.along
        + by_a[:, None] * frame.a
    )
    return area, moment


def _unit(v: FloatArray, otherwise: FloatArray) -> FloatArray:
    """Rows of v (m, 3) at unit length; rows of no length are taken from `otherwise`."""
    length = np.linalg.norm(v, axis=1)
    result = v / np.maximum(length, 1e-300)[:, None]
    result[length < 1e-150] = otherwise[length < 1e-150]
    return np.asarray(result)
