"""patch_table.py: the uncertainty of every Klems patch as a table, beside the WINDOW file that has no place for it."""

import csv
import io

import numpy as np

from gonio.dataset.effects import effect_of
from gonio.formats.window.matrices import KlemsMatrices

PLACE = (
    "band",
    "process",
    "light_from",
    "incident_patch",
    "outgoing_patch",
    "incident_theta_deg",
    "incident_azimuth_deg",
    "outgoing_theta_deg",
    "outgoing_azimuth_deg",
    "bsdf_per_sr",
)
COLUMNS = (*PLACE, "u_per_sr", "u_independent_per_sr")


def render(built: KlemsMatrices) -> bytes:
    """The table as CSV, UTF-8: a row per patch of the columns that were measured or rotated from what was.

    Patches count from 1, angles are those of the WINDOW file. After COLUMNS follows one column per effect, the signed
    change of the value for one standard deviation [1/sr]: u^2 = u_independent^2 + sum of their squares. One effect is
    one cause, so changes of several patches add up with their signs. Cells of patches that were filled from the
    nearest points are empty.
    """
    names = sorted(
        {name for block in built.bands.values() for own in block.uncertainty.values() for name in own.effects}
    )
    out = io.StringIO(newline="")
    out.write(f"# gonio: uncertainty (k = 1) of the patches of {built.basis.name}\n")
    out.write(
        "# one column per systematic effect: signed change for one standard deviation, the same cause everywhere\n"
    )
    for name in names:
        out.write(f"# {name}: {_words(name)}\n")
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([*COLUMNS, *(f"{name} per_sr" for name in names)])
    centres = [[f"{theta:g}", f"{azimuth:g}"] for theta, azimuth in built.basis.centres_deg.tolist()]
    for band, block in built.bands.items():
        if built.copied is not None and band == built.copied[1]:
            continue
        for (process, side), own in block.uncertainty.items():
            values = block.matrices[process, side]
            empty = np.full(values.shape, np.nan)
            u, independent = own.u_per_sr, np.sqrt(own.variance_per_sr2)
            layers = [
                values,
                u,
                independent,
                *(own.effects.get(name, np.where(np.isnan(u), empty, 0)) for name in names),
            ]
            for column in np.flatnonzero(np.isfinite(u).any(axis=0)).tolist():
                table = np.stack([layer[:, column] for layer in layers], axis=1).tolist()
                for row, numbers in enumerate(table):
                    place = [column + 1, row + 1, *centres[column], *centres[row]]
                    writer.writerow([band, process, side, *place, *(_cell(number) for number in numbers)])
    return out.getvalue().encode("utf-8")


def _words(name: str) -> str:
    try:
        return effect_of(name).words
    except KeyError:
        return "not described"


def _cell(number: float) -> str:
    return f"{number:.7g}" if np.isfinite(number) else ""
