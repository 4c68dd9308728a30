"""fit.py: a dataset to a sample whose channels are analytic families, with the record of how they were found."""

from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

import numpy as np

from gonio.dataset.bsdf import Dataset, Distribution, Symmetry
from gonio.dataset.scattering import Bsdf, FloatArray, MeasuredIntegral, wavelength_bands_nm
from gonio.model.analytic import reporting
from gonio.model.analytic.component import Component
from gonio.model.analytic.component_fit import by_polar_angle, fit_component, theta_deg
from gonio.model.analytic.families import ALL, family_of
from gonio.model.analytic.family import Process
from gonio.model.analytic.held_out import best, held_out, rule
from gonio.model.analytic.scattering import KIND, AnalyticScattering, Sides
from gonio.model.analytic.targets import tie_of
from gonio.model.nodes.points import Component as Side
from gonio.model.nodes.points import Points, points_of
from gonio.model.nodes.symmetry import compared_images, declared, images_of
from gonio.model.sphere_values import Band, SphereRow, SphereValues, threads_from_stacks
from gonio.units.errors import UsageError

AUTO = "auto"
FAMILIES = ("lambertian", "gaussian", "abg", "ggx", "ggx-dielectric", "ward-duer", AUTO)
THROUGH = {"ggx": "ggx-through", "ggx-dielectric": "ggx-through"}  # what a family of surfaces is in transmission
SphereTie = Literal["total", "diffuse"]
_NEAR_IR_NM = (780.0, 2500.0)
_FAR_OFF = 0.1  # of a tie's factor from 1, that is said
_NO_MORE_THAN = 1.001  # rho + tau


@dataclass(frozen=True)
class _Wishes:
    family: str
    sphere: SphereValues | None
    sphere_tie: SphereTie
    band: Band | None


def fit_family(
    dataset: Dataset,
    family: str,
    *,
    sphere: SphereValues | None = None,
    sphere_tie: SphereTie = "total",
    band: Band | None = None,
    symmetry: Symmetry | None = None,
    channels: tuple[str, ...] | None = None,
    back_as_front: bool = False,
) -> Bsdf:
    """Each component of each channel fitted with `family` (FAMILIES; "auto": per component the one with the least
    held-out error), its exact hemispherical integral tied to the measured one at every theta_i.

    `sphere`: integrating-sphere values that the integrals are tied to in place of the points' own, their total or their
    diffuse part; over `band`, else at the channel's wavelength, else visible or near infrared by the channel's name.
    `back_as_front`: components of the back that were not measured are taken equal to the front's.
    Families are isotropic: the symmetry must be declared so. provenance["model"] holds both fits, the held-out table
    and what integrals are tied to. Raises UsageError.
    """
    if family not in FAMILIES:
        raise UsageError(f"no family {family!r}: choose one of {', '.join(FAMILIES)}")
    chosen = declared(symmetry, dataset.symmetry)
    if chosen != "isotropic":
        raise UsageError(
            f"analytic families are isotropic and the sample is declared {chosen}: --symmetry isotropic fits the mean "
            "over its azimuths, gonio fit without a family keeps them apart"
        )
    present = list(dict.fromkeys(d.channel for d in dataset.distributions))
    wanted = present if channels is None else list(channels)
    missing = [name for name in wanted if name not in present]
    if missing:
        raise UsageError(f"no channel {missing[0]!r} in the dataset; it has {', '.join(present)}")
    result = Bsdf(
        channels={},
        sample_name=dataset.sample_name,
        manufacturer=dataset.manufacturer,
        front_faces=dataset.front_faces,
        symmetry="isotropic",
        polarisation=dataset.polarisation,
        thickness_mm=dataset.thickness_mm,
        band_nm={name: band for name, band in wavelength_bands_nm(dataset).items() if name in wanted},
        provenance=dict(dataset.provenance),
    )
    record: dict[str, Any] = {"kind": KIND, "family": family, "symmetry": "isotropic", "channels": {}}
    measured: list[MeasuredIntegral] = []
    sentences: list[str] = []
    for channel in wanted:
        own = [d for d in dataset.distributions if d.channel == channel]
        wishes = _Wishes(family, sphere, sphere_tie, band if sphere is None else band or _band_of(own[0]))
        scattering, entry, found = _fit_channel(dataset, channel, wishes, back_as_front)
        result.channels[channel] = scattering
        record["channels"][channel] = entry
        measured += found + _stated(own)
        low, high = scattering.theta_range_deg
        sentences.append(
            f"{channel}: fitted at incident theta {low:g} to {high:g} degrees from the normal; beyond, parameters and "
            "hemispherical value stay those of the last angle"
        )
    sentences.append("values are those of closed forms: interpolated, never measured ones")
    if back_as_front:
        sentences.append("light on the back: taken equal to the front where it was not measured, as the user declared")
    result.measured, result.validity = tuple(measured), tuple(sentences)
    result.provenance["model"] = record
    return result


def _fit_channel(
    dataset: Dataset, channel: str, wishes: _Wishes, back_as_front: bool
) -> tuple[AnalyticScattering, dict[str, Any], list[MeasuredIntegral]]:
    by_side = points_of(dataset, channel)
    if not by_side:
        raise UsageError(
            f"channel {channel}: no points with solid angles to fit: gonio reduce gives imported ones cells"
        )
    components: dict[Sides, Component] = {}
    entry: dict[str, Any] = {"components": {}}
    measured: list[MeasuredIntegral] = []
    angles: list[float] = []
    dark = [side.name for side, points in by_side.items() if not any(np.any(p.dsf_per_sr > 0.0) for p in points)]
    if len(dark) == len(by_side):
        raise UsageError(f"channel {channel}: no point has any light: check the scan, and what was subtracted")
    for side, points in by_side.items():
        if side.name in dark:
            continue
        angles += [theta_deg(p) for p in points]
        rows = _sphere_rows(side, wishes)
        component, said = _fit_side(side, points, rows, wishes)
        components[side.incident_front, side.outgoing_front] = component
        entry["components"][side.name] = said
        measured += [_from_sphere(channel, side, row) for row in rows if np.isfinite(row.u)]
    if back_as_front:
        for reflection in (True, False):
            front, back = (True, reflection), (False, not reflection)
            if front in components and back not in components:
                components[back] = components[front]
                name = f"back {'reflection' if reflection else 'transmission'}"
                entry["components"][name] = {"equal_to": name.replace("back", "front"), "why": "declared by the user"}
    if wishes.sphere is not None and wishes.band is not None:
        entry["sphere"] = _sphere_record(wishes.sphere, wishes.band, wishes.sphere_tie)
    entry["energy"] = _energy(components, sorted(set(angles)))
    entry["findings"] = [
        f"light on the {line['light_on']} at {line['theta_i_deg']:g} degrees: rho + tau is {line['sum']:.4f}"
        for line in entry["energy"]
        if line["sum"] > _NO_MORE_THAN
    ] + [f"{name}: no point has any light; the model leaves it absent" for name in dark]
    return AnalyticScattering(components, (min(angles), max(angles))), entry, measured


def _fit_side(
    side: Side, directions_measured: list[Points], rows: tuple[SphereRow, ...], wishes: _Wishes
) -> tuple[Component, dict[str, Any]]:
    process: Process = "reflection" if side.reflection else "transmission"
    directions = by_polar_angle(directions_measured)
    if wishes.family == AUTO:
        able = [family for family in ALL.values() if process in family.processes]
        table = [held_out(family, process, directions) for family in able]
        name = best(table)
    else:
        name = wishes.family if side.reflection else THROUGH.get(wishes.family, wishes.family)
        if process not in family_of(name).processes:
            raise UsageError(f"family {name} has no {process} and the dataset has {side.name}: choose another, or auto")
        table = [held_out(family_of(name), process, directions)]
    fitted = fit_component(family_of(name), process, directions)
    tie = tie_of(fitted.component, directions, rows, wishes.sphere.name if wishes.sphere else "")
    component = replace(fitted.component, tie=tie)
    at = np.array([theta_deg(p) for p in directions])
    tests = compared_images(directions_measured, images_of("isotropic", directions_measured))
    said = {
        "family": name,
        "source": family_of(name).source,
        "held_out": {"rule": rule(directions), "table": table},
        "fits": reporting.fit_records(fitted, directions),
        "tie": {
            "source": tie.source,
            "theta_i_deg": tie.theta_deg.tolist(),
            "value": tie.value.tolist(),
            "factor_at_fits": component.factor(at).tolist(),
        },
        "reciprocity_residual": reporting.reciprocity(component),
        "symmetry_test": tests,
        "findings": _findings(tests, component, at),
    }
    return component, said


def _findings(tests: list[dict[str, Any]], component: Component, at_deg: FloatArray) -> list[str]:
    """Sentences on what does not fit together."""
    found = [
        f"symmetry isotropic is contradicted: {entry['image']}, {entry['pairs']} pairs differ by "
        f"{entry['rms_u']:.2f} u (rms), {100.0 * entry['share']:.1f} % of the light"
        for entry in tests
        if entry["contradicted"]
    ]
    factor = component.factor(at_deg)
    worst = int(np.argmax(np.abs(np.log(np.maximum(factor, 1e-9)))))
    if abs(factor[worst] - 1.0) > _FAR_OFF:
        found.append(
            f"the fit's integral had to be multiplied by {factor[worst]:.4g} at {at_deg[worst]:g} degrees to give the "
            "measured one: the family does not describe the points, or the values are of something else"
        )
    return found


def _sphere_rows(side: Side, wishes: _Wishes) -> tuple[SphereRow, ...]:
    """The sphere's values of a component; of a side it did not measure: none."""
    if wishes.sphere is None or wishes.band is None:
        return ()
    name: Any = f"{'rho' if side.reflection else 'tau'}_{wishes.sphere_tie}"
    return wishes.sphere.rows(name, wishes.band, side="front" if side.incident_front else "back")


def _sphere_record(sphere: SphereValues, band: Band, tie: SphereTie) -> dict[str, Any]:
    """What the sphere's values say by themselves: openness and threads, where the file has what they need."""
    found: dict[str, Any] = {"file": sphere.name, "band": band.name, "tie": tie}
    try:
        found["openness"] = sphere.openness(band)
        rho, tau = sphere.by_layers("rho_total", band), sphere.by_layers("tau_total", band)
        if len(rho) > 1:
            found["threads"] = asdict(threads_from_stacks(rho, tau, found["openness"]))
    except UsageError as error:
        found["without"] = str(error)
    return found


def _band_of(distribution: Distribution) -> Band:
    if distribution.wavelength_nm is not None:
        return Band.at(distribution.wavelength_nm)
    word = distribution.channel.lower()
    if word in ("visible", "vis", "photopic"):
        return Band.visible()
    if word in ("nir", "near infrared", "near-infrared"):
        return Band.flat(*_NEAR_IR_NM)
    raise UsageError(
        f"channel {distribution.channel}: at which wavelengths are the sphere's values? give --sphere-band"
    )


def _stated(distributions: list[Distribution]) -> list[MeasuredIntegral]:
    """What the dataset itself states."""
    found = []
    for d in distributions:
        for name in ("rho", "tau"):
            value = d.integrals.get(f"{name}_measured")
            if value is not None:
                u = d.integrals.get(f"{name}_u", 0.0)
                found.append(
                    MeasuredIntegral(d.channel, d.incident_theta_deg, d.incident_phi_deg, name == "rho", value, u)
                )
    return found


def _from_sphere(channel: str, side: Side, row: SphereRow) -> MeasuredIntegral:
    theta = row.theta_i_deg if side.incident_front else 180.0 - row.theta_i_deg
    return MeasuredIntegral(channel, theta, 0.0, side.reflection, row.value, row.u)


def _energy(components: dict[Sides, Component], angles_deg: list[float]) -> list[dict[str, Any]]:
    """Per side of the light and theta_i: rho, tau and their sum, as the tied model has them (None: not measured)."""
    found = []
    for front in (True, False):
        parts = [components.get((front, leaves)) for leaves in (front, not front)]
        if parts == [None, None]:
            continue
        for angle in angles_deg:
            rho, tau = (None if part is None else float(part.integral(np.array([angle]))[0]) for part in parts)
            found.append(
                {
                    "light_on": "front" if front else "back",
                    "theta_i_deg": angle,
                    "rho": rho,
                    "tau": tau,
                    "sum": (rho or 0.0) + (tau or 0.0),
                }
            )
    return found
