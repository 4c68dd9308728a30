"""cells_table.py: a CSV of all leaves of a file: where each lies, its value, and where that comes from."""

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.scattering import Origin
from gonio.formats.tensor.build import Built
from gonio.formats.tensor.leaves import origins


def cells_table(built: Built, name: str) -> bytes:
    """CSV, UTF-8. A leaf is [i / 2^level, (i + 1) / 2^level) along each coordinate of the tree (tensor/frame.py)."""
    lines = [f"# leaves of {name}: from i / 2^level to (i + 1) / 2^level along each coordinate of the tensor tree"]
    dimensions = next(iter(built.leaves.values())).chosen.tree.dimensions
    numbers = ["i_incident"] if dimensions == 3 else ["i_incident_x", "i_incident_y"]
    lines.append(
        ",".join(
            ["wavelength", "component", "level", *numbers, "i_outgoing_x", "i_outgoing_y", "bsdf_per_sr", "origin"]
        )
    )
    words = [origin.name.lower() for origin in Origin]
    for (band, component), leaves in built.leaves.items():
        if band.startswith("CIE-"):
            continue
        for (level, rows), found in zip(leaves.rows(), origins(leaves), strict=True):
            index = leaves.chosen.tree.levels[level].index[rows]
            values = leaves.bsdf_per_sr[level][rows]
            for cell, value, origin in zip(index.tolist(), values.tolist(), found.tolist(), strict=True):
                lines.append(f"{band},{component},{level},{','.join(map(str, cell))},{value:.5g},{words[origin]}")
    return ("\n".join(lines) + "\n").encode()


def origin_shares(built: Built) -> dict[str, NDArray[np.float64]]:
    """Per block, the share of projected solid angle (incident times outgoing) of each Origin, (4,)."""
    result = {}
    for (band, component), leaves in built.leaves.items():
        if band.startswith("CIE-"):
            continue
        share = np.zeros(len(Origin))
        tree = leaves.chosen.tree
        for (level, rows), found in zip(leaves.rows(), origins(leaves), strict=True):
            solid = tree.incident_share(tree.levels[level].index[rows], level) * 4.0**-level
            share += np.bincount(found, weights=solid, minlength=len(Origin))
        result[f"{band} {component}"] = share / share.sum()
    return result
