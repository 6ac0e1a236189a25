"""Points in the order of an angle: curves, spirals, cycles and pieces of exchanges, as sequences in closed form."""

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.analysis.judgement.ordering import LAST, comes_back, goes_on, ordered

GOLDEN = (np.sqrt(5) - 1) / 2


@pytest.mark.parametrize("pace", [0.0, 4e-10, 1e-7])
@pytest.mark.parametrize("turn", [np.sqrt(2) / 10, np.sqrt(2) / 3])
def test_an_angle_whose_rate_grows_evenly_is_on_no_torus(turn, pace):
    """From 2,048 points to the next the rate of the slowest grows by less than a millionth of a turn.

    Where harmonics are near the line, and whole numbers of turns, that shows in longer parts of the record only.
    """
    k = np.arange(2048.0)
    angle = 2 * np.pi * (turn * k + pace * k**2 / 2)
    assert ordered(np.column_stack([np.cos(angle + np.sin(angle) / 2), np.sin(angle)]))[0] == (pace == 0)


@pytest.mark.parametrize("rate", [1e-8, 1e-6, -1e-7, -1e-5, None])
@pytest.mark.parametrize("turn", [0.7, 2.3])
def test_a_spiral_is_in_no_order(rate, turn):
    """It grows or fades by 1e-5 of its size in 1,024 points, or by a power of time, as at a Neimark-Sacker point."""
    k = np.arange(1024)
    size = np.exp(rate * k) if rate else 1 / np.sqrt(1 + k / 1e5)
    points = size[:, np.newaxis] * np.column_stack([np.cos(turn * k), np.sin(turn * k)])
    points[:, 0] += 0.3 * np.tanh(points[:, 1])
    assert ordered(points)[:2] == (False, True)
    still = points / size[:, np.newaxis]
    assert ordered(still)[:2] == (True, False)


@pytest.mark.parametrize("turns", [1, 2, 3, 5])
def test_a_spiral_whose_turns_nearly_close_is_in_no_order(turns):
    """After 83 points it is back but for 1e-4 of a turn: neighbours by angle then tell times, not places."""
    k = np.arange(1024)
    turn = 2 * np.pi * turns / 83 + 1e-6
    points = np.exp(-1e-7 * k)[:, np.newaxis] * np.column_stack([np.cos(turn * k), np.sin(turn * k)])
    assert ordered(points)[:2] == (False, True)


@pytest.mark.parametrize("count", [1, 2, LAST, LAST + 1, LAST + 2])
def test_few_points_show_no_return_unless_they_repeat(count):
    angle = 2.3 * np.arange(count)
    assert not comes_back(np.column_stack([np.cos(angle), np.sin(angle)]))
    assert comes_back(np.cos(np.pi * np.arange(count))[:, np.newaxis]) == (count >= LAST + 2)


@pytest.mark.parametrize("period", [3, 250, 694, 870, 1000])
def test_points_that_close_before_their_end_are_in_no_order(period):
    """Along a circle, by as many turns as no curve of fewer points repeats; without its end no such return is seen."""
    turns = int(GOLDEN * period) + np.flatnonzero(np.gcd(int(GOLDEN * period) + np.arange(50), period) == 1)[0]
    angle = 2 * np.pi * (np.arange(1024) * turns % period) / period
    points = np.column_stack([np.cos(angle), np.sin(angle)])
    assert not ordered(points)[0]
    assert ordered(points[:period])[0] == (period > 256)


def test_a_curve_that_repeats_earlier_states_is_a_cycle():
    """Of 1,700 points, of which the last 1,024 are known, and every 64th before; another one is on a torus."""
    early, k = 4096, np.arange(-4096, 1024)
    for turn, goes in ((1051 / 1700, False), (GOLDEN, True)):
        angle = 2 * np.pi * (k * turn - np.floor(k * turn))
        path = np.column_stack([np.cos(angle), np.sin(angle)])
        assert ordered(path[early:])[0]
        assert goes_on(path[early:], path[:early:64], k[:early:64]) == goes


@pytest.mark.parametrize("size", [1.0, 1e-2, 1e-4])
def test_small_curves_are_in_order_beside_a_large_cycle(size):
    """Two curves in turn, with points 1e-6 of the way between them apart."""
    k = np.arange(1024)
    points = np.column_stack([np.cos(0.7 * k), np.sin(0.7 * k + 0.2)]) * size + np.array([[0, 1], [3, 0]])[k % 2]
    assert ordered(points / np.ptp(points, axis=0))[:2] == (True, False)


def test_an_angle_that_quickens_is_no_torus_where_its_points_lie_on_four_curves():
    """By 0.03 turns in the record, at nearly a quarter of a turn a step, so that a curve is gone round four times."""
    k = np.arange(2048, 4096)
    angle = 2 * np.pi * (1.3284777713920101e-08 * k * (k - 1) / 2 + 0.24816586490919668 * k)
    assert ordered(np.column_stack([np.cos(angle), np.sin(angle)]))[:2] == (False, True)


@pytest.mark.parametrize(("sigma", "angle"), [(2.32, 0.29), (1.63, 0.56), (2.0, 0.3)])
def test_a_graph_with_dips_of_all_widths_is_no_curve(sigma, angle):
    """Keller's maps again: of 1,024 points either half shows all dips of the first two, but no quarter does."""
    x, points = 1.0, []
    for _ in range(1524):
        x, angle = 2 * sigma * abs(np.cos(np.pi * angle)) * np.tanh(x), (angle + np.sqrt(2) - 1) % 1
        points.append((x, np.cos(2 * np.pi * angle), np.sin(2 * np.pi * angle)))
    assert ordered(np.array(points[500:]))[:2] == (False, False)


@pytest.mark.parametrize(("pieces", "in_order"), [(1, True), (3, True), (8, False)])
def test_a_torus_takes_many_points_a_jump(pieces, in_order):
    """Pieces of a circle in reversed order: so many points of an exchange of intervals are often on as many."""
    angle = (0.3 + GOLDEN * np.arange(1024)) % 1
    place = (pieces - 1 - np.floor(pieces * angle) + pieces * angle % 1) / pieces
    assert ordered(place[:, np.newaxis])[0] == in_order


@pytest.mark.parametrize("turn", [GOLDEN, 7 / 85 + 2e-6])
@pytest.mark.parametrize("slip", [0.0, 0.05])
def test_earlier_states_of_a_torus_are_on_its_curve(turn, slip):
    """Of 16,384 points the last are on a curve; beside a fraction their order does not tell the turn to all digits.

    Where intervals are exchanged the angle slips at times, here once before.
    """
    count = np.arange(16384)
    place = (0.3 + turn * count + slip * (count > 9000)) % 1.0
    path = np.column_stack([place, np.exp(-place) + 0.2 * np.cos(2 * np.pi * place)])
    begin, earlier = 16384 - 2048, np.arange(63, 16384 - 2048, 64)
    assert ordered(path[begin:])[:2] == (True, False)
    assert goes_on(path[begin:], path[earlier], earlier - begin) == (slip == 0.0)


@pytest.mark.parametrize("size", [1e-3, 1e-7])
def test_small_curves_are_in_order_however_many_points_they_have(size):
    """Four curves that are visited in turn, so small beside the ways between them that points seem to come back."""
    k = np.arange(8192)
    angle = 2 * np.pi * (np.sqrt(3) - 1) * (k + 0.3) / 4
    places = np.array([[1.0, 2.0], [-2.5, 0.3], [0.7, -1.4], [2.2, 1.1]])
    points = places[k % 4] + size * np.column_stack([np.cos(angle + k % 4), np.sin(angle)])
    for count in (1024, 2048, 4096):
        assert ordered(points[-count:])[0]
        steps = np.arange(0, len(points) - count, 37) - (len(points) - count)
        assert goes_on(points[-count:], points[: len(points) - count : 37], steps)


def test_a_rotation_with_a_slow_passage_is_in_order():
    """z -> (z - c)/(1 - c z), turned: on most of its way there are few points, however long the record."""
    side, z, path = 0.9, 1j, []
    for _ in range(8192):
        z = np.exp(2j * np.arcsin(side) + 0.0015j) * (z - side) / (1 - side * z)
        path.append((z.real, z.imag))
    for count in (2048, 8192):
        assert ordered(np.array(path[-count:]))[0]


@pytest.mark.parametrize("count", [2, 3])
@pytest.mark.parametrize("rest", [0.0, 1e-15])
def test_a_state_may_rest_on_each_of_several_curves(count, rest):
    """A flag that goes round, but for its rounding, beside an angle that does not come back; and a spiral beside it."""
    k = np.arange(2048)
    angle, flag = np.pi * GOLDEN * k, (k % count) * (1 + rest * np.sin(1e3 * k))
    points = np.column_stack([np.cos(angle), np.sin(angle), flag])
    assert ordered(points)[:2] == (True, False)
    points[:, :2] *= np.exp(-1e-7 * k)[:, np.newaxis]
    assert ordered(points)[:2] == (False, True)


def test_a_flag_leaves_a_torus_one():
    turned = {"x": "cos(w)*x - sin(w)*y", "y": "sin(w)*x + cos(w)*y", "f": "-f"}
    flagged = cd.Map("x y f", {"w": 1.234}, turned, initial={"x": 1.0, "f": 1.0})
    found = cd.bifurcation_diagram(flagged, {"w": [1.234, 1.5]}, transient=0, periods=1024)
    assert (found["outcome"] == cd.Outcome.QUASIPERIODIC).all()
