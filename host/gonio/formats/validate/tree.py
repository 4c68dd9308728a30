"""tree.py: what a tensor tree holds: blocks, negative values, sums per incident direction, reciprocity."""

import itertools
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gonio.formats.findings import Findings
from gonio.formats.tensor.flat import FlatTree
from gonio.formats.tensor.frame import COMPONENTS, Component, place_of
from gonio.formats.tensor.read import TensorFile, read_file
from gonio.formats.tensor.tree import slices
from gonio.formats.validate.document import Profile, note_copied, note_sides
from gonio.formats.validate.klems_values import residual_of

FloatArray = NDArray[np.float64]
ENERGY_TOLERANCE = 5e-3  # values have three digits: sums of cells that are rounded alike
_THETA_DEG = np.arange(0.0, 86.0, 5.0)
_AZIMUTHS_DEG = np.arange(0.0, 360.0, 15.0)
_PAIRS = 20000  # of directions, for reciprocity
_ENERGY_BANDS = ("Visible", "Solar")


def validate(path: Path, profile: Profile) -> Findings:
    """Findings about a tensor tree. The public schema admits none, and WINDOW reads none."""
    file = read_file(path)
    findings = file.findings
    if profile == "window":
        findings.add("error", "tree", f"TensorTree{file.dimensions}", "WINDOW reads Klems matrices, no tensor tree")
    _basis_and_sides(file)
    _blocks(file, profile)
    _copies(file)
    for band, trees in file.trees.items():
        if band not in _ENERGY_BANDS:
            continue
        _sums(file, band, trees)
        _reciprocity(file, band, trees)
    return findings


def _basis_and_sides(file: TensorFile) -> None:
    finest = max(tree.resolution for trees in file.trees.values() for tree in trees.values())
    cells = sum(len(tree.values) for trees in file.trees.values() for tree in trees.values())
    what = f"{file.dimensions} dimensions, finest cells 1/{1 << finest} of an axis (k = {finest}), {cells} cells"
    file.findings.add("note", "basis-used", "LBNL/Shirley-Chiu", what)
    note_sides(file.findings, file.comments)


def _blocks(file: TensorFile, profile: Profile) -> None:
    if "Visible" not in file.trees:
        severity = "error" if profile == "radiance" else "note"
        file.findings.add(severity, "missing", "Visible", "Radiance needs this block, and there is none")  # type: ignore[arg-type]
    for band, component in itertools.product([b for b in _ENERGY_BANDS if b in file.trees], COMPONENTS):
        tree, where = file.trees[band].get(component), f"{band} {component}"
        if tree is None:
            file.findings.add("note", "missing", where, "there is no such tree")
        elif not tree.values.any():
            file.findings.add("note", "zeros", where, "all values are zero: not measured?")
    levels = {tree.resolution for tree in file.trees.get("Visible", {}).values()}
    if levels and max(levels) > 9:
        file.findings.add(
            "warning", "depth", "Visible", f"cells of level {max(levels)} are finer than Radiance's samples reach"
        )


def _copies(file: TensorFile) -> None:
    visible, solar = file.trees.get("Visible"), file.trees.get("Solar")
    if visible is None or solar is None or visible.keys() != solar.keys():
        return
    if all(np.array_equal(tree.values, solar[component].values) for component, tree in visible.items()):
        note_copied(file.findings)


def _sums(file: TensorFile, band: str, trees: dict[Component, FlatTree]) -> None:
    """Exact sums of B L over the outgoing cells of directions on a grid."""
    theta, azimuth = np.meshgrid(_THETA_DEG, _AZIMUTHS_DEG if file.dimensions == 4 else [0.0], indexing="ij")
    theta, azimuth = theta.ravel(), azimuth.ravel()
    for side in ("Front", "Back"):
        own = {c: hemispherical(tree, _source(theta, azimuth, c)) for c, tree in trees.items() if c.side == side}
        if not own:
            continue
        parts = [f"{c.process.lower()} {v.min():.4f} to {v.max():.4f} ({v[0]:.4f} at normal)" for c, v in own.items()]
        file.findings.add("note", "column-sums", f"{band} {side}", "; ".join(parts))
        total = np.sum(list(own.values()), axis=0)
        worst = int(np.argmax(total))
        if total[worst] > 1.0 + ENERGY_TOLERANCE:
            file.findings.add(
                "error",
                "energy",
                f"{band} {side}",
                f"transmission plus reflection exceed 1, the most {total[worst]:.4f} for light from theta "
                f"{theta[worst]:g}, phi {azimuth[worst]:g} from that side's normal (Radiance's x and y)",
            )


def hemispherical(tree: FlatTree, source: FloatArray) -> FloatArray:
    """Sums of B L (k,) for directions towards the source (k, 3), in Radiance's frame."""
    places = place_of(source, source, tree.dimensions)[:, : tree.dimensions - 2]
    row, _, level, value = slices(tree, places)
    return np.asarray(np.pi * np.bincount(row, value * 0.25**level, minlength=len(source)))


def _source(theta_deg: FloatArray, azimuth_deg: FloatArray, component: Component) -> FloatArray:
    theta, azimuth = np.radians(theta_deg), np.radians(azimuth_deg)
    across = np.sin(theta)
    return np.stack((across * np.cos(azimuth), across * np.sin(azimuth), component.incident_z * np.cos(theta)), axis=-1)


def _reciprocity(file: TensorFile, band: str, trees: dict[Component, FlatTree]) -> None:
    """B of pairs of directions, drawn evenly by projected solid angle, and of the reversed pairs."""
    generator = np.random.default_rng(1)
    for name, forth, back in (
        ("Reflection Front", Component("Reflection", "Front"), Component("Reflection", "Front")),
        ("Reflection Back", Component("Reflection", "Back"), Component("Reflection", "Back")),
        ("Transmission", Component("Transmission", "Front"), Component("Transmission", "Back")),
    ):
        if forth not in trees or back not in trees:
            continue
        source, leaving = (_drawn(generator, z) for z in (forth.incident_z, forth.outgoing_z))
        one = trees[forth].at(place_of(source, leaving, file.dimensions))
        other = trees[back].at(place_of(leaving, source, file.dimensions))
        residual = residual_of(one, other, np.ones(_PAIRS))
        file.findings.add(
            "note",
            "reciprocity",
            f"{band} {name}",
            f"residual {100.0 * residual:.2f} % (rms difference of pairs of directions over their rms mean, "
            f"{_PAIRS} pairs drawn)",
        )


def _drawn(generator: np.random.Generator, z: float) -> FloatArray:
    """Directions (n, 3), evenly by projected solid angle, on the side of sign `z`."""
    across, azimuth = np.sqrt(generator.uniform(0.0, 1.0, _PAIRS)), generator.uniform(0.0, 2.0 * np.pi, _PAIRS)
    return np.stack((across * np.cos(azimuth), across * np.sin(azimuth), z * np.sqrt(1.0 - across**2)), axis=-1)
