"""What leaves no gaps along a path: a motion that goes round does, wherever it begins and whatever its unit."""

import numpy as np
import pytest

from chaosdrill.analysis.judgement.gaps import full

COUNT = 1000
TURNS = np.arange(COUNT) * (np.sqrt(5) - 1) / 2


def path(*columns):
    return np.column_stack(columns)


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e9])
@pytest.mark.parametrize("offset", [-3.0, 0.0, 5.0])
def test_a_rotation_goes_round_without_gaps(unit, offset):
    angle = 2 * np.pi * TURNS
    assert full(unit * (offset + path(np.cos(angle), np.sin(angle), TURNS % 1))).all()


def test_what_passes_its_middle_seldom_only_drifts():
    """A triangle of seven slopes passes it seven times, one of eight slopes eight times; to and fro below is no way."""
    seven, eight = (np.interp(np.linspace(0, n, COUNT), np.arange(n + 1), np.arange(n + 1) % 2) for n in (7, 8))
    below = np.append(np.tile([0.25, 0.45], 50), np.linspace(0, 1, COUNT - 100))
    assert full(path(seven, eight, below)).tolist() == [False, True, False]


@pytest.mark.parametrize(("rare", "filled"), [(3, True), (2, False)])
def test_the_emptiest_tenth_holds_three_points_however_many_there_are(rare, filled):
    """Places in the fourth tenth are as rare as asked; the others are even, and the points go to and fro."""
    others = np.linspace(0, 0.8999, COUNT - rare)
    others[others >= 0.3] += 0.1
    values = np.append(others, np.full(rare, 0.35))
    assert full(path(np.random.default_rng(1).permutation(values))).tolist() == [filled]


def test_a_cycle_and_what_stands_still_leave_gaps():
    assert not full(path(np.arange(COUNT) % 7, np.ones(COUNT), np.full(COUNT, 1e-9))).any()
