"""Multipliers stand where they are in the plane, their moduli over the parameter, and crossings on the circle."""

import numpy as np
import pytest

from chaosdrill.dataset import Special
from chaosdrill.plot.multipliers import multipliers


def _marks(axes):
    return {line.get_label(): line.get_xydata() for line in axes.get_lines() if line.get_markerfacecolor() == "white"}


def test_values_are_coloured_by_the_parameter(continuation):
    plane = multipliers(continuation).axes[0]
    dots = plane.collections[0]
    # 2 - r and 4 + 2 r - r^2; the exact zeros are not drawn
    r = continuation["r"].values
    expected = np.where(continuation["period"].values == 1, 2 - r, 4 + 2 * r - r**2)
    np.testing.assert_allclose(dots.get_offsets(), np.stack([expected, 0 * r], axis=1), atol=1e-12)
    np.testing.assert_allclose(dots.get_array(), r)


def test_what_is_far_outside_is_counted(continuation):
    far = continuation.copy(deep=True)
    far["multiplier_real"][5:9, 0] = 1e4
    axes = multipliers(far).axes[0]
    assert axes.get_title() == "4 of 266 lie outside; their moduli are below"
    assert axes.get_xlim()[1] < 2
    assert multipliers(continuation).axes[0].get_title() == ""


def test_the_circle_is_round(continuation):
    axes = multipliers(continuation).axes[0]
    assert axes.get_aspect() == 1
    assert [patch.get_radius() for patch in axes.patches] == [1]


@pytest.mark.parametrize(
    ("kind", "values", "crossing"),
    [
        (Special.FOLD, [1.0 + 1e-9, -1.0], [1.0]),
        (Special.PERIOD_DOUBLING, [1.5, -1.0 + 1e-9], [-1.0]),
        (Special.NEIMARK_SACKER, [0.6 + 0.8j, 0.6 - 0.8j], [0.6 + 0.8j, 0.6 - 0.8j]),
    ],
)
def test_crossings_are_marked_where_they_happen(continuation, kind, values, crossing):
    changed = continuation.copy(deep=True)
    changed["multiplier_real"][20], changed["multiplier_imag"][20] = np.real(values), np.imag(values)
    changed["special_kind"][:] = [kind, Special.GRAZING, Special.GRAZING]
    (points,) = _marks(multipliers(changed).axes[0]).values()
    np.testing.assert_allclose(points[:, 0] + 1j * points[:, 1], crossing, atol=1e-8)


def test_special_points_without_a_crossing_stand_at_the_foot(continuation):
    below = multipliers(continuation).axes[2]
    marks = _marks(below)
    np.testing.assert_allclose(marks["period doubling"], [[3, 1], [1 + np.sqrt(6), 1]])
    np.testing.assert_allclose(marks["grazing"], [[3.5, 0.05]])


def test_lost_multipliers_are_named(continuation):
    side = multipliers(continuation).axes[1]
    names = [text.get_text() for text in side.get_legend().get_texts()]
    assert names == ["period 1", "period 2", "μ₂ = 0", "period doubling", "grazing"]
    some = continuation.copy(deep=True)
    some["multiplier_real"][:33, 1] = 0.125
    names = [text.get_text() for text in multipliers(some).axes[1].get_legend().get_texts()]
    assert "μ₂ = 0 at 100 of 133 points" in names


def test_points_without_multipliers_do_not_count(continuation):
    some = continuation.copy(deep=True)
    some["multiplier_real"][-1] = np.nan
    assert "μ₂ = 0" in [text.get_text() for text in multipliers(some).axes[1].get_legend().get_texts()]


def test_moduli_have_a_logarithmic_axis_around_one(continuation):
    below = multipliers(continuation).axes[2]
    assert below.get_yscale() == "log"
    low, high = below.get_ylim()
    assert 0 < low < 1 < high
