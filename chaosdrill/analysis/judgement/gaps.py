"""Whether points leave no gaps: those of a torus leave none, those of a cycle or an adding machine do."""

import numpy as np

from chaosdrill.analysis.judgement.recurrence import ROUND_OFF

GAPS, SHARE = 10, 0.01
"""Parts of the extent of a state each of which holds such a share of the points of a torus at least: a harmonic motion
is in the middle tenth for 6 % of its time. An adding machine leaves gaps at all scales, and where bursts interrupt a
cycle they hardly fill those between its points."""

CROSSINGS = 8
"""Times that the points on such a curve pass its middle at least: a slow drift leaves no gaps either."""


def full(path: np.ndarray) -> np.ndarray:
    """Which states go round and leave no gaps along a path, shape (W, n); bool, shape (n,)."""
    low, extent = path.min(axis=0), np.maximum(np.ptp(path, axis=0), ROUND_OFF)
    place = np.minimum((path - low) / extent * GAPS, GAPS - 1).astype(int)
    shares = np.array([np.bincount(one, minlength=GAPS).min() for one in place.T]) / len(path)
    above = place >= GAPS // 2
    turns = (above[1:] != above[:-1]).sum(axis=0) >= CROSSINGS
    return np.asarray(turns & (shares >= SHARE))
