"""fitted.py: from a dataset to a Bsdf of fitted models, with everything that was decided on the way."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Symmetry
from gonio.dataset.scattering import Bsdf, MeasuredIntegral, wavelength_bands_nm
from gonio.geometry.directions import angles_deg_from_unit
from gonio.model import reciprocity
from gonio.model.between.carried import completed
from gonio.model.between.choose import as_json, chosen, held_out, leave_one_out
from gonio.model.between.energy import LARGEST_CORRECTION, Bound, with_node_scales
from gonio.model.between.resolve import Resolver
from gonio.model.between.scheme import SCHEMES, Scheme, named
from gonio.model.channel import Fitted, FittedComponent
from gonio.model.lobe import Lobe
from gonio.model.nodes.node import Ground, Node, build_node, lobes_of
from gonio.model.nodes.points import Component, Points, points_of
from gonio.model.nodes.symmetry import Images, compared_images, declared, images_of, prepared
from gonio.model.validity import sentences
from gonio.units.errors import UsageError
from gonio.units.version import gonio_version

FloatArray = NDArray[np.float64]

__all__ = ["Fitted", "fit_bsdf"]
_LEAST_FOR_REST = 4  # directions; of fewer a median tells little of what rests
_USUAL = SCHEMES[0]  # where nothing can be left out


def fit_bsdf(
    dataset: Dataset,
    *,
    symmetry: Symmetry | None = None,
    method: str = "auto",
    channels: Sequence[str] | None = None,
    enforce_reciprocity: bool = False,
) -> Bsdf:
    """Fit every channel (or those named) of the dataset.

    `symmetry` goes before the dataset's own; one must be declared. `method`: scheme.METHODS. UsageError for undeclared
    symmetry, an unknown method or channel, and a dataset without points. provenance["model"] records per channel and
    component the choice, the leave-one-out table, lobes, scales, tests of symmetry and reciprocity.
    """
    declared_symmetry = declared(symmetry, dataset.symmetry)
    scheme = None if method == "auto" else named(method)
    present = list(dict.fromkeys(d.channel for d in dataset.distributions))
    wanted = present if channels is None else list(channels)
    for name in wanted:
        if name not in present:
            raise UsageError(f"channel {name}: not in the dataset; it has {', '.join(present) or 'none'}")
    fitted: dict[str, Fitted] = {}
    record: dict[str, Any] = {
        "family": "lobes",
        "gonio": gonio_version(),
        "symmetry": declared_symmetry,
        "method": method,
        "reciprocity_enforced": enforce_reciprocity,
        "channels": {},
    }
    measured: list[MeasuredIntegral] = []
    for name in wanted:
        points = points_of(dataset, name)
        if not points:
            raise UsageError(f"channel {name}: no points with values: nothing to fit")
        fitted[name], record["channels"][name] = _fit_channel(points, declared_symmetry, scheme, enforce_reciprocity)
        measured += _measured(name, points)
    return Bsdf(
        channels=dict(fitted),
        sample_name=dataset.sample_name,
        manufacturer=dataset.manufacturer,
        front_faces=dataset.front_faces,
        symmetry=declared_symmetry,
        polarisation=dataset.polarisation,
        thickness_mm=dataset.thickness_mm,
        band_nm={name: band for name, band in wavelength_bands_nm(dataset).items() if name in wanted},
        measured=tuple(measured),
        validity=sentences(fitted, record["channels"]),
        provenance={**dataset.provenance, "model": record},
    )


def _fit_channel(
    points: dict[Component, list[Points]], symmetry: Symmetry, scheme: Scheme | None, enforce: bool
) -> tuple[Fitted, dict[str, Any]]:
    components, record, used = {}, {}, {}
    for component, own in points.items():
        images = images_of(symmetry, own)
        used[component] = prepared(own, images)
        components[component], record[component.name] = _fit_component(used[component], images, scheme, component)
        record[component.name]["symmetry_test"] = compared_images(own, images)
    model = Fitted(components)
    before = reciprocity.residual(model, used)
    if enforce:
        used = reciprocity.averaged(model, used)
        for component, own in used.items():
            chosen_scheme = components[component].resolver.scheme
            images = components[component].resolver.images
            components[component], again = _fit_component(own, images, chosen_scheme, component)
            again["leave_one_out"] = record[component.name]["leave_one_out"]
            record[component.name] |= again
        model = Fitted(components)
        after = reciprocity.residual(model, used)
        for name, found in after.items():
            record[name]["reciprocity_enforced"] = found
    for name, found in before.items():
        record[name]["reciprocity"] = found
    return model, record


def _fit_component(
    points: list[Points], images: Images, scheme: Scheme | None, component: Component
) -> tuple[FittedComponent, dict[str, Any]]:
    ways = SCHEMES if scheme is None else (scheme,)
    if not images.isotropic:
        ways = tuple(way for way in ways if way.curve == "linear" or scheme is not None)
    if len(points) < _LEAST_FOR_REST and scheme is None:
        ways = tuple(way for way in ways if not way.rest)
    start: dict[bool, Resolver] = {}
    ground = [Ground.of(p) for p in points]
    lobes: list[tuple[Lobe, ...]] = [lobes_of(p) if any(way.lobes for way in ways) else () for p in points]
    for with_lobes in dict.fromkeys(way.lobes for way in ways):
        own = lobes if with_lobes else [()] * len(points)
        nodes = [build_node(p, found, g) for p, found, g in zip(points, own, ground, strict=True)]
        start[with_lobes] = Resolver(nodes, images, next(way for way in ways if way.lobes == with_lobes))
    if True in start and False in start and not any(lobes):
        ways = tuple(way for way in ways if not way.lobes)  # no lobes: both are the same
    first = start[ways[0].lobes]
    held = held_out(points, first.nodes, first) if len(points) > 1 else []
    angles = [_angles(p.incident, component) for p in points]
    carried: list[tuple[Lobe, ...]] = [()] * len(points)
    others = {with_lobes: [of.without(h.node) for h in held] for with_lobes, of in start.items()}
    if True in start and any(lobes):
        start[True], carried = completed(start[True], points, lobes, ground)
        if any(carried):  # for leave-one-out: from what is left
            others[True] = [completed(of, points, lobes, ground)[0] for of in others[True]]
    table = {way: leave_one_out([of.with_scheme(way) for of in others[way.lobes]], held) for way in ways}
    best = chosen(table) if held else (scheme or _USUAL if _USUAL in ways else ways[0])
    resolver = start[best.lobes].with_scheme(best)
    carried = carried if best.lobes else [()] * len(points)
    scaled, needed = with_node_scales(resolver, points)
    resolver = resolver.with_nodes(scaled)
    model = FittedComponent(resolver, Bound.of(resolver))
    return model, {
        "chosen": best.name,
        "by": "leave-one-out"
        if held and scheme is None
        else ("the user" if scheme else "default: nothing to leave out"),
        "leave_one_out": as_json(table, held, angles),
        "nodes": [
            _node_record(node, angle, want, integral, len(extra))
            for node, angle, want, integral, extra in zip(
                resolver.nodes, angles, needed, model.bound.node_integral[: len(points)], carried, strict=True
            )
        ],
        "follows": list(resolver.tracks.follows),
        "images": [list(sign) for sign in images.signs],
        "least_bound": float(np.min(model.bound.table)) if model.bound.table is not None else None,
        "findings": [
            f"theta_i {angle[0]:.4g}, phi_i {angle[1]:.4g}: the model's sum over the points is "
            f"{100.0 * (1.0 / want - 1.0):+.2f} % off; corrected by at most {100.0 * LARGEST_CORRECTION:g} %"
            for angle, want in zip(angles, needed, strict=True)
            if abs(want - 1.0) > LARGEST_CORRECTION and want > 0.0
        ],
    }


def _node_record(
    node: Node, angle: tuple[float, float], needed: float, integral: float, carried: int
) -> dict[str, Any]:
    """`carried`: so many of the lobes, the last, are neighbours'."""
    theta, phi = angles_deg_from_unit(node.centre) if len(node.centre) else (np.zeros(0), np.zeros(0))
    sigma = np.degrees(node.sigma_rad)
    lobes = [
        {
            "theta_deg": float(theta[k]),
            "phi_deg": float(phi[k]),
            "peak_per_sr": float(np.exp(node.log_peak[k])),
            "sigma_deg": [float(s) for s in sigma[k]],
            "power": float(node.power[k]),
            "carried_over": bool(k >= len(node.power) - carried),
        }
        for k in np.argsort(-node.power)
    ]
    return {
        "theta_deg": angle[0],
        "phi_deg": angle[1],
        "points": node.points,
        "lobes": lobes,
        "integral_points": node.integral,
        "integral_model": float(integral),
        "scale": node.scale,
        "scale_needed": needed,
    }


def _angles(incident: FloatArray, component: Component) -> tuple[float, float]:
    theta, phi = angles_deg_from_unit(incident)
    return float(theta if component.incident_front else 180.0 - theta), float(phi)


def _measured(channel: str, points: dict[Component, list[Points]]) -> list[MeasuredIntegral]:
    """What the dataset states, else the sum over the points with their independent uncertainty."""
    result = []
    for component, own in points.items():
        for p in own:
            stated = np.isfinite(p.stated)
            noise = float(np.sqrt(p.variance_per_sr2 @ p.solid_angle_sr**2))
            u = p.stated_u if stated and np.isfinite(p.stated_u) else noise
            value = p.stated if stated else p.integral
            theta, phi = _angles(p.incident, component)
            result.append(MeasuredIntegral(channel, theta, phi, component.reflection, float(value), float(u)))
    return result
