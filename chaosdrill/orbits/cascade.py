"""Period doublings in a row: Feigenbaum's ratios and where they accumulate.

Feigenbaum 1978, doi:10.1007/BF01020332; the limit by Aitken's delta-squared process.
"""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.orbits.results import Cascade

if TYPE_CHECKING:
    from collections.abc import Sequence


def cascade_from(values: "Sequence[float]", periods: "Sequence[int]") -> Cascade:
    """Ratios and limit of doublings in a row.

    Parameters
    ----------
    values : sequence of float
        The parameter at each.
    periods : sequence of int
        Period of the orbit that doubles there.

    Returns
    -------
    Cascade
        The limit is that of a geometric sequence through the last three doublings; its error is how far the limit of
        the three before lies from it, NaN with fewer than four.
    """
    v = np.asarray(values, dtype=float)
    gaps = np.diff(v)
    ratios = np.full(len(v), np.nan)
    ratios[2:] = gaps[:-1] / gaps[1:]
    limits = [_limit(*v[k - 2 : k + 1]) for k in range(2, len(v))]
    limit = limits[-1] if limits else np.nan
    error = abs(limits[-1] - limits[-2]) if len(limits) > 1 else np.nan
    return Cascade(v, np.asarray(periods, dtype=np.int64), ratios, float(limit), float(error))


def _limit(a: float, b: float, c: float) -> float:
    bend = (c - b) - (b - a)
    return c - (c - b) ** 2 / bend if bend != 0 else np.nan
