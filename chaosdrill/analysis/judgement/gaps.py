"""Whether points leave no gaps: those of a torus leave none, those of a cycle or an adding machine do."""

import numpy as np

from chaosdrill.analysis.judgement.recurrence import ROUND_OFF

GAPS, FILLED = 10, 3
"""Parts of the extent of a state, and how many points of a torus each of these holds at least. Where a motion is slow
on a part of its way the others hold few, however long the record is. An adding machine leaves gaps at all scales, and
where bursts interrupt a cycle they hardly fill those between its points."""

CROSSINGS = 8
"""Times that the points on such a curve pass its middle at least: a slow drift leaves no gaps either."""


def full(path: np.ndarray) -> np.ndarray:
    """Which states go round and leave no gaps along a path, shape (W, n); bool, shape (n,)."""
    low, extent = path.min(axis=0), np.maximum(np.ptp(path, axis=0), ROUND_OFF)
    place = np.minimum((path - low) / extent * GAPS, GAPS - 1).astype(int)
    fewest = np.array([np.bincount(one, minlength=GAPS).min() for one in place.T])
    above = place >= GAPS // 2
    turns = (above[1:] != above[:-1]).sum(axis=0) >= CROSSINGS
    return np.asarray(turns & (fewest >= FILLED))
