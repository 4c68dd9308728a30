"""lobe.py: the DSF as a body in space, radius and colour by its logarithm: a mesh that is small enough for the page."""

import base64
import json
from dataclasses import dataclass
from html import escape
from typing import Any

import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from gonio.dataset.bsdf import Distribution
from gonio.geometry.directions import unit_from_angles_deg
from gonio.report.drawing import DSF_MAP
from gonio.report.polar_map import dsf_scale

FloatArray = NDArray[np.float64]

_CELLS_DEG = (3.0, 1.0, 0.33, 0.11)  # points are thinned to one per cell; finer cells where the DSF varies more
_STEEP_DECADES = 0.15  # within a cell and its neighbours' points, from which the next finer cells are taken
_MOST_POINTS = 24_000
_LONGEST_EDGES = 6.0  # a facet with an edge longer than so many usual ones spans a hole
_LEAST_HOLE_DEG = 5.0
_MOST_HOLE_DEG = 25.0


@dataclass(frozen=True)
class Mesh:
    """Radius 0 at `floor_per_sr` and below, 1 at `top_per_sr`, linear in the logarithm."""

    direction: FloatArray  # (n, 3) unit vectors
    radius: FloatArray  # (n,) 0 to 1
    facets: NDArray[np.int64]  # (m, 3)
    floor_per_sr: float
    top_per_sr: float


def build_mesh(d: Distribution) -> Mesh | None:
    """Facets between neighbouring points of both hemispheres, none over masked or unmeasured regions; None where there
    are too few points."""
    scale = dsf_scale(d)
    floor = scale.low / 10.0
    decades = np.log10(scale.top / floor)
    with np.errstate(invalid="ignore", divide="ignore"):
        level = np.log10(np.where(d.dsf_per_sr > floor, d.dsf_per_sr, floor) / floor)
    unit = unit_from_angles_deg(d.theta_deg, d.phi_deg)
    chosen = _thinned(unit, np.where(d.measured, level, np.nan))
    _, first = np.unique(np.round(unit[chosen], 6), axis=0, return_index=True)
    chosen = chosen[first]
    if len(chosen) < 20 or not d.measured[chosen].any():
        return None
    try:
        facets = ConvexHull(unit[chosen]).simplices.astype(np.int64)
    except QhullError:
        return None
    corners = unit[chosen][facets]
    edge = np.degrees(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1))
    usual = float(np.quantile(edge, 0.9))
    reach = min(max(_LONGEST_EDGES / 2 * usual, _LEAST_HOLE_DEG), _MOST_HOLE_DEG)
    above = unit[chosen][:, 2] >= 0.0
    one_side = (above[facets].sum(axis=1) % 3) == 0  # nothing joins reflection and transmission
    kept = (edge <= reach) & d.measured[chosen][facets].all(axis=1) & one_side
    radius = np.nan_to_num(level[chosen] / decades)
    return Mesh(unit[chosen], np.clip(radius, 0.0, 1.0), facets[kept], floor, scale.top)


def canvas(d: Distribution, mesh: Mesh, label: str) -> str:
    """The element that lobe_script.py brings to life; data in its attributes."""
    places = np.round(mesh.direction * mesh.radius[:, None] * 32767).astype("<i2")
    directions = np.round(mesh.direction * 32767).astype("<i2")
    told: dict[str, Any] = {
        "floor": float(np.log10(mesh.floor_per_sr)),
        "top": float(np.log10(mesh.top_per_sr)),
        "incident": [d.incident_theta_deg, d.incident_phi_deg],
        "transmission": bool(np.any(d.theta_deg > 90.0)),
    }
    facets = mesh.facets.astype("<u2")
    return (
        f'<div class="lobe"><canvas tabindex="0" role="img" aria-label="{escape(label, quote=True)}" '
        f'data-told="{escape(json.dumps(told), quote=True)}" data-places="{_packed(places)}" '
        f'data-directions="{_packed(directions)}" data-facets="{_packed(facets)}"></canvas>'
        '<div class="lobe-bar"><button type="button" data-view="-60,22">oblique</button>'
        '<button type="button" data-view="-90,0">from the side</button>'
        '<button type="button" data-view="-90,89">along the normal</button>'
        '<button type="button" data-zoom="1.3">closer</button><button type="button" data-zoom="0.77">farther</button>'
        "<output></output></div></div>"
    )


def colour_table() -> str:
    """The colours of the DSF as 256 times six hexadecimal digits."""
    colours = mpl.colormaps[DSF_MAP](np.linspace(0.0, 1.0, 256), bytes=True)[:, :3]
    return bytes(np.asarray(colours, dtype=np.uint8)).hex()


def _packed(values: NDArray[Any]) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")


def _thinned(unit: FloatArray, level: FloatArray) -> NDArray[np.int64]:
    """Indices of the points to draw: the first of each cell, in finer cells where the DSF is steep. Masked points
    (NaN) are kept like others, so that they hold their place; the very top always."""
    chosen = [np.array([int(np.nanargmax(level))])] if np.isfinite(level).any() else []
    rest = np.arange(len(level))
    count = 0
    for depth, cell_deg in enumerate(_CELLS_DEG):
        _, first, cell = np.unique(_cells(unit[rest], cell_deg), return_index=True, return_inverse=True)
        if count + len(first) > _MOST_POINTS:
            first = first[:: -(-len(first) // max(_MOST_POINTS - count, 1))]
        chosen.append(rest[first])
        count += len(first)
        if count >= _MOST_POINTS or depth + 1 == len(_CELLS_DEG):
            break
        low, high = np.full(int(cell.max()) + 1, np.inf), np.full(int(cell.max()) + 1, -np.inf)
        np.fmin.at(low, cell, level[rest])
        np.fmax.at(high, cell, level[rest])
        rest = rest[(high - low)[cell] > _STEEP_DECADES]
        if not len(rest):
            break
    return np.unique(np.concatenate(chosen))


def _cells(unit: FloatArray, cell_deg: float) -> NDArray[np.int64]:
    """A number per cell of a grid on the six faces of the cube about the sphere, (n,)."""
    axis = np.argmax(np.abs(unit), axis=1)
    rows = np.arange(len(unit))
    main = unit[rows, axis]
    side = np.degrees(np.arctan2(unit[rows, (axis + 1) % 3], np.abs(main))) + 45.0
    height = np.degrees(np.arctan2(unit[rows, (axis + 2) % 3], np.abs(main))) + 45.0
    across = int(np.ceil(90.0 / cell_deg)) + 1
    face = axis * 2 + (main > 0)
    return np.asarray(
        (face * across + np.floor(side / cell_deg).astype(np.int64)) * across + (height / cell_deg).astype(np.int64)
    )
