"""Curves of special points as tests ask for them."""

import numpy as np

from chaosdrill.dataset.branches import BranchEnd, Special
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.curves import curve


def followed(system, limits, follow, step, period=1, transient=300, most=1000, start="attractor"):
    ends = np.array(list(limits.values()))
    return curve(system, tuple(limits), ends, period, start, transient, follow, step, most, Numerics(), None)


def at_both_limits(result, limits):
    """Whether the ends of a curve are where one of the parameters is at a limit."""
    ends = np.array(list(limits.values()))
    at = np.isclose(result.values[[0, -1], :, np.newaxis], ends, rtol=0, atol=1e-12)
    return result.branches[0].end_code == BranchEnd.LIMIT and at.any(axis=(1, 2)).all()


def kinds(branch):
    """The special points of a branch by their kinds."""
    return [Special(int(k)) for k in branch["special_kind"].values]
