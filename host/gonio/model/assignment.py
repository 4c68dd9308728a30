"""assignment.py: which row goes with which column, at the least cost in all, for a handful of each."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def assigned(cost: FloatArray) -> NDArray[np.int64]:
    """Column (n,) of each row of a finite cost (n, n), every column once, such that the sum of costs is least.

    The Hungarian method in its form with shortest augmenting paths (Jonker and Volgenant 1987): rows are added one at a
    time; potentials keep every cost minus its row's and column's potential at zero or above, and at zero where
    assigned. O(n^3); scipy has the same, and takes a quarter of a second to load.
    """
    n = len(cost)
    row_potential, column_potential = np.zeros(n), np.zeros(n)
    row_of = np.full(n, -1, dtype=np.int64)
    for row in range(n):
        least = np.full(n, np.inf)  # of a path from the new row to each column
        before = np.full(n, -1, dtype=np.int64)  # column that the path comes from
        done = np.zeros(n, dtype=bool)
        last, at = -1, row
        while True:
            length = (least[last] if last >= 0 else 0.0) + cost[at] - row_potential[at] - column_potential
            better = ~done & (length < least)
            least[better], before[better] = length[better], last
            last = int(np.argmin(np.where(done, np.inf, least)))
            done[last] = True
            if row_of[last] < 0:
                break
            at = int(row_of[last])
        shortest = least[last]
        reached = np.flatnonzero(done & (row_of >= 0))
        row_potential[row] += shortest
        row_potential[row_of[reached]] += shortest - least[reached]
        column_potential[reached] -= shortest - least[reached]
        while last >= 0:
            previous = int(before[last])
            row_of[last] = row if previous < 0 else row_of[previous]
            last = previous
    column = np.empty(n, dtype=np.int64)
    column[row_of] = np.arange(n)
    return column
