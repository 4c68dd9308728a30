"""klems_values.py: what the matrices of a WINDOW file hold: blocks, negative values, column sums, reciprocity."""

import itertools

import numpy as np
from numpy.typing import NDArray

from gonio.formats.validate.document import Profile, graver_for_window, note_copied, note_sides
from gonio.formats.window.klems import KlemsBasis
from gonio.formats.window.matrices import BANDS, PROCESSES, SIDES, Band
from gonio.formats.window.read import WindowBsdf

ENERGY_TOLERANCE = 1e-4  # files carry about six digits
FloatArray = NDArray[np.float64]


def check(content: WindowBsdf, profile: Profile) -> None:
    """Adds to the file's findings."""
    _basis_and_sides(content)
    _blocks(content, profile)
    _copies(content)
    _negative(content)
    for band in dict.fromkeys(key[0] for key in content.matrices):
        _column_sums(content, band)
        _reciprocity(content, band)


def _basis_and_sides(content: WindowBsdf) -> None:
    basis, findings = content.basis, content.findings
    counts = " ".join(str(ring.patches) for ring in basis.rings)
    findings.add("note", "basis-used", basis.name[:40], f"{basis.size} patches in rings of {counts}")
    note_sides(findings, content.text.get("Comments", ""))


def _blocks(content: WindowBsdf, profile: Profile) -> None:
    """WINDOW wants all eight; Radiance takes the visible ones that there are."""
    for band, process, side in itertools.product(BANDS, PROCESSES, SIDES):
        matrix, where = content.matrices.get((band, process, side)), f"{band} {process} {side}"
        if matrix is None:
            content.findings.add(graver_for_window(profile), "missing", where, "there is no such matrix")
        elif not matrix.any():
            content.findings.add("note", "zeros", where, "all values are zero: not measured?")
    if profile == "radiance" and not any(key[0] == "Visible" for key in content.matrices):
        content.findings.add("error", "missing", "Visible", "Radiance loads no other block, and there is none")


def _copies(content: WindowBsdf) -> None:
    pairs = [
        (content.matrices.get(("Visible", process, side)), content.matrices.get(("Solar", process, side)))
        for process in PROCESSES
        for side in SIDES
    ]
    both = [(a, b) for a, b in pairs if a is not None and b is not None and (a.any() or b.any())]
    if both and all(np.array_equal(a, b) for a, b in both):
        note_copied(content.findings)
    for band in dict.fromkeys(key[0] for key in content.matrices):
        for process in PROCESSES:
            front, back = (content.matrices.get((band, process, side)) for side in SIDES)
            if front is not None and back is not None and front.any() and np.array_equal(front, back):
                content.findings.add("note", "same-sides", f"{band} {process}", "Front and Back are the same")


def _negative(content: WindowBsdf) -> None:
    for (band, process, side), matrix in content.matrices.items():
        if np.any(matrix < 0):
            row, column = np.unravel_index(int(np.argmin(matrix)), matrix.shape)
            content.findings.add(
                "error",
                "negative",
                f"{band} {process} {side}",
                f"{np.count_nonzero(matrix < 0)} negative values, the lowest {matrix.min():g} "
                f"in row {row + 1}, column {column + 1}",
            )


def _column_sums(content: WindowBsdf, band: Band) -> None:
    """Energy per incident patch: sum over outgoing patches of B L, at most 1. X and Z of a colour are no energies."""
    size = content.basis.projected_solid_angle_sr
    for side in SIDES:
        sums = {
            process: size @ content.matrices[key]
            for process in PROCESSES
            if (key := (band, process, side)) in content.matrices and content.matrices[key].any()
        }
        if not sums:
            continue
        parts = [f"{p.lower()} {v.min():.4f} to {v.max():.4f} ({v[0]:.4f} at normal)" for p, v in sums.items()]
        content.findings.add("note", "column-sums", f"{band} {side}", "; ".join(parts))
        total = np.sum(list(sums.values()), axis=0)
        if not band.startswith("CIE") and total.max() > 1 + ENERGY_TOLERANCE:
            worst = int(np.argmax(total))
            count = np.count_nonzero(total > 1 + ENERGY_TOLERANCE)
            content.findings.add(
                "error",
                "energy",
                f"{band} {side}",
                f"transmission plus reflection exceed 1 in {count} columns, "
                f"the most {total[worst]:.4f} in column {worst + 1}",
            )


def _reciprocity(content: WindowBsdf, band: Band) -> None:
    opposite = opposite_patches(content.basis)
    if opposite is None:
        content.findings.add("note", "reciprocity", content.basis.name[:40], "odd rings: not looked at")
        return
    weight = np.outer(content.basis.projected_solid_angle_sr, content.basis.projected_solid_angle_sr)
    for name, forth, back in (
        ("Reflection Front", ("Reflection", "Front"), ("Reflection", "Front")),
        ("Reflection Back", ("Reflection", "Back"), ("Reflection", "Back")),
        ("Transmission", ("Transmission", "Front"), ("Transmission", "Back")),
    ):
        one, other = content.matrices.get((band, *forth)), content.matrices.get((band, *back))  # type: ignore[arg-type]
        if one is None or other is None or not (one.any() and other.any()):
            continue
        residual = residual_of(one, other[np.ix_(opposite, opposite)].T, weight)
        content.findings.add(
            "note",
            "reciprocity",
            f"{band} {name}",
            f"residual {100.0 * residual:.2f} % (rms difference of pairs of directions over their rms mean)",
        )


def opposite_patches(basis: KlemsBasis) -> NDArray[np.int64] | None:
    """Patch (size,) half a turn away from each; None where rings of an odd number of patches have none.

    Reversing the light makes the outgoing direction the incident one, whose column is that of its azimuth plus 180
    degrees, and the other way round: B'(o, i) = B(opposite(i), opposite(o)).
    """
    found = []
    for start, ring in zip(basis.ring_start[:-1].tolist(), basis.rings, strict=True):
        if ring.patches > 1 and ring.patches % 2:
            return None
        found.append(start + (np.arange(ring.patches) + ring.patches // 2) % ring.patches)
    return np.concatenate(found).astype(np.int64)


def residual_of(one: FloatArray, other: FloatArray, weight: FloatArray) -> float:
    """Root of the weighted mean square of the difference, over that of the mean of both; 0 where both are 0."""
    below = float(np.sum(weight * (0.5 * (one + other)) ** 2))
    return float(np.sqrt(np.sum(weight * (one - other) ** 2) / below)) if below > 0.0 else 0.0
