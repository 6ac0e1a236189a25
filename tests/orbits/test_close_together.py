"""A fold and a period doubling between the same two points of a branch are both located."""

import numpy as np

import chaosdrill as cd
from chaosdrill.dataset.branches import Special


def test_multipliers_at_special_points_are_what_their_names_say(drill):
    """At 0.58658 a fold and a doubling of the drill's orbit of period 2 are 1e-6 apart, in steps of 0.02."""
    branch = cd.continue_orbit(drill.with_parameters(eta=0.6), {"eta": (0.4, 0.9)}, period=2, step=0.02)
    points, kinds = branch["special_index"].values, branch["special_kind"].values
    multipliers = branch["multiplier_real"].values + 1j * branch["multiplier_imag"].values
    values = branch["special_value"].values
    for kind, known in ((Special.FOLD, 1.0), (Special.PERIOD_DOUBLING, -1.0)):
        here = points[kinds == kind]
        assert np.abs(multipliers[here] - known).min(axis=1).max() < 1e-10
        near = values[kinds == kind]
        assert np.abs(near - 0.586579).min() < 2e-6
