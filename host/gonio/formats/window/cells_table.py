"""cells_table.py: every cell of a model's matrices with its value and origin as a table, beside the WINDOW file that
has no place for it."""

import csv
import io

import numpy as np

from gonio.dataset.scattering import Origin
from gonio.formats.window.matrices import KlemsMatrices
from gonio.formats.window.patch_table import PLACE


def render(made: KlemsMatrices) -> bytes:
    """The table as CSV, UTF-8. Patches count from 1, angles are those of the WINDOW file; origin is measured,
    interpolated, extrapolated or absent (a matrix of zeros that nobody measured)."""
    out = io.StringIO(newline="")
    out.write(f"# gonio: origin of the cells of {made.basis.name}\n")
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([*PLACE, "origin"])
    words = [kind.name.lower() for kind in Origin]
    centres = [(f"{theta:g}", f"{azimuth:g}") for theta, azimuth in made.basis.centres_deg.tolist()]
    size = made.basis.size
    for band, block in made.bands.items():
        if made.copied is not None and band == made.copied[1]:
            continue
        for (process, side), values in block.matrices.items():
            origin = block.cells.get((process, side), np.full((size, size), Origin.ABSENT, dtype=np.uint8))
            for column in range(size):
                pairs = zip(values[:, column].tolist(), origin[:, column].tolist(), strict=True)
                writer.writerows(
                    (
                        band,
                        process,
                        side,
                        column + 1,
                        row + 1,
                        *centres[column],
                        *centres[row],
                        f"{value:.7g}",
                        words[kind],
                    )
                    for row, (value, kind) in enumerate(pairs)
                )
    return out.getvalue().encode("utf-8")
