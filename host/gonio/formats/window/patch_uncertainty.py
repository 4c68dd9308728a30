"""patch_uncertainty.py: the uncertainty of a matrix of Klems patches: independent variance, and every effect's part."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.formats.window.patch_average import PatchValues

FloatArray = NDArray[np.float64]

BRIGHT = 0.01  # of a matrix's largest value: patches under it are noise, whose relative uncertainty says nothing


@dataclass(frozen=True)
class PatchUncertainty:
    """Of one matrix, shape (rows = outgoing patches, columns = incident patches), k = 1 [1/sr]. NaN where a patch does
    not come from measured points of its own.

    One effect is one cause: its parts of all patches of all matrices change together, with their signs.
    """

    variance_per_sr2: FloatArray  # independent part
    effects: dict[str, FloatArray]
    total_variance: FloatArray  # (columns,) independent, of the energy sum_o B_o L_o
    total_effects: dict[str, FloatArray]  # (columns,) change of that energy

    @classmethod
    def of_columns(
        cls, columns: Mapping[int, PatchValues], direct: NDArray[np.bool_], projected_sr: FloatArray
    ) -> "PatchUncertainty":
        """From the columns that hold values; `direct` (columns,) are those that were measured, or rotated from what
        was. `projected_sr` is L of each patch."""
        size = len(projected_sr)
        names = dict.fromkeys(name for values in columns.values() for name in values.effects)
        variance = np.full((size, size), np.nan)
        effects = {name: np.full((size, size), np.nan) for name in names}
        total_variance = np.zeros(size)
        total_effects = {name: np.zeros(size) for name in names}
        for column, values in columns.items():
            total_variance[column] = values.total_variance
            for name, change in values.effects.items():
                total_effects[name][column] = projected_sr @ change
            if not direct[column]:
                continue
            variance[:, column] = values.variance_per_sr2
            for name in names:
                change = values.effects.get(name, np.zeros(size))
                effects[name][:, column] = np.where(values.filled, np.nan, change)
        return cls(variance, effects, total_variance, total_effects)

    @property
    def u_per_sr(self) -> FloatArray:
        """Combined standard uncertainty of every patch, shape (rows, columns)."""
        return np.sqrt(sum((part**2 for part in self.effects.values()), self.variance_per_sr2))

    def largest_relative(self, values: FloatArray) -> tuple[float, int, int] | None:
        """Largest u over value among patches brighter than BRIGHT, its row and its column; None where there is none."""
        u = self.u_per_sr
        bright = np.isfinite(u) & (values > BRIGHT * values.max())
        if not bright.any():
            return None
        relative = np.where(bright, u / np.where(bright, values, 1.0), -1.0)
        row, column = np.unravel_index(int(np.argmax(relative)), relative.shape)
        return float(relative[row, column]), int(row), int(column)

    @staticmethod
    def u_of_total(parts: list["PatchUncertainty"], column: int) -> float:
        """Combined standard uncertainty of the energy of one incident patch, added over several matrices."""
        names = dict.fromkeys(name for part in parts for name in part.total_effects)
        changes = [sum(part.total_effects[n][column] for part in parts if n in part.total_effects) for n in names]
        independent = sum(part.total_variance[column] for part in parts)
        return float(np.sqrt(independent + np.sum(np.square(changes))))
