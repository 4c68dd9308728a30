"""strobes.py: which samples stand beside a strobe edge that was lost."""

import numpy as np
from numpy.typing import NDArray

from gonio.protocol.generated import records
from gonio.rawlog.reader import RawLog


def beside_lost_strobes(log: RawLog) -> NDArray[np.bool_]:
    """Samples (n,) of blocks in which the firmware lost or rejected a strobe edge: by the block's flag, or because its
    count of lost edges is higher than the block's before. All False where the log has no block headers."""
    blocks = log.sample_blocks
    count = blocks["count"].astype(np.int64)
    if count.sum() != len(log.samples) or not len(log.samples):
        return np.zeros(len(log.samples), dtype=bool)
    lost = blocks["strobes_lost"].astype(np.int64)
    first = np.minimum(np.cumsum(count) - count, len(log.samples) - 1)
    same_segment = np.diff(log.sample_segment[first], prepend=-1) == 0
    beside = (blocks["flags"] & records.SAMPLE_BLOCK_STROBE_REJECTED != 0) | (
        same_segment & (np.diff(lost, prepend=0) > 0)
    )
    return np.repeat(beside, count)
