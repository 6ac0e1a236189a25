"""The path of an orbit in its dataset and in its picture, beside an integration by scipy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import chaosdrill as cd
from chaosdrill.plots.orbits import orbit

# Vertices of the path lie on the orbit, straight lines between them near it, and none of them crosses a jump.


@pytest.fixture(scope="module")
def oscillator():
    """An orbit of period 4 with three impacts of the oscillator in the library."""
    found = cd.periodic_orbit(cd.build("impact-oscillator"), period=4, transient=300)
    assert (int(found["period"]), int(found["event_count"])) == (4, 3)
    return found


@pytest.fixture(scope="module")
def flight(oscillator):
    """The same motion by scipy: its impacts, and the states at given times between them."""
    wall, zeta, amplitude, omega, e = (
        float(cd.build("impact-oscillator").parameters[name]) for name in ("wall", "zeta", "amplitude", "omega", "e")
    )

    def field(t, s):
        return [s[1], -2 * zeta * s[1] - s[0] + amplitude * np.cos(omega * t)]

    def hit(t, s):
        return s[0] - wall

    hit.terminal, hit.direction = True, 1
    start, state, end = 0.0, oscillator["orbit_state"].values, float(oscillator["period_time"])
    arcs = []
    while start < end:
        arc = solve_ivp(field, (start, end), state, "DOP853", events=hit, rtol=1e-12, atol=1e-13, dense_output=True)
        arcs.append((start, arc.t[-1], arc.sol))
        start, state = arc.t[-1], arc.y[:, -1] * [1, -e]
    return arcs


def _off(flight, times, states):
    """The distance of states from the orbit at their times, the nearer side of an impact."""
    beside = [
        np.where(
            ((times >= first - 1e-9) & (times <= last + 1e-9))[:, None],
            np.abs(sol(times).T - states),
            np.inf,
        )
        for first, last, sol in flight
    ]
    return np.min([one.max(axis=1) for one in beside], axis=0)


def test_events_are_told_from_the_state_of_the_orbit_on(oscillator, flight):
    hits = [last for _, last, _ in flight[:-1]]
    np.testing.assert_allclose(oscillator["event_time"].values, hits, rtol=0, atol=1e-9)


def test_vertices_lie_on_the_orbit(oscillator, flight):
    time, path = oscillator["path_time"].values, oscillator["path_state"].values
    assert (np.diff(time) >= 0).all()
    assert (time[0], time[-1]) == (0.0, float(oscillator["period_time"]))
    assert _off(flight, time, path).max() < 1e-8


def _drawn(found):
    """Ends of the straight lines of which the drawn path consists, shape (k, 2, 2)."""
    axes = orbit(found).axes[0]
    line = next(line for line in axes.get_lines() if line.get_label() == "path").get_xydata()
    ends = np.stack([line[:-1], line[1:]], axis=1)
    return ends[np.isfinite(ends).all(axis=(1, 2))]


def test_straight_lines_show_the_orbit_and_cross_no_jump(oscillator, flight):
    ends = _drawn(oscillator)
    middles = ends.mean(axis=1)
    on = np.concatenate([sol(np.linspace(first, last, 20001)).T for first, last, sol in flight])
    extent = np.ptp(on, axis=0)
    far = [np.min(np.hypot(*((on - middle) / extent).T)) for middle in middles]
    assert max(far) < 1e-3
    # an impact turns the speed round, by far more than a line is long
    jumps = np.ptp(
        [oscillator["event_state_before"].values[:, 1], oscillator["event_state_after"].values[:, 1]], axis=0
    )
    assert np.abs(np.diff(ends[:, :, 1], axis=1)).max() < 0.5 * jumps.min()


def test_a_clock_that_is_set_back_draws_no_line_across():
    clock = cd.HybridSystem(
        states="phi x",
        modes={"on": {"phi": "1", "x": "cos(2*pi*phi) - x"}},
        transitions=[cd.Transition("turn", "on", "on", guard="phi - 1", direction=1, reset={"phi": "0"})],
    )
    found = cd.periodic_orbit(clock, at="turn")
    assert int(found["period"]) == 1
    ends = _drawn(found)
    assert np.abs(np.diff(ends[:, :, 0], axis=1)).max() < 0.2
    # x + a cos + b sin has returned: x(phi) = (cos 2 pi phi + 2 pi sin 2 pi phi) / (1 + 4 pi^2)
    phi, x = ends[:, 0].T
    exact = (np.cos(2 * np.pi * phi) + 2 * np.pi * np.sin(2 * np.pi * phi)) / (1 + 4 * np.pi**2)
    np.testing.assert_allclose(x, exact, atol=1e-9)


def test_a_spike_is_met_where_it_is_steep():
    # x' = x^2 from -10 on is 1 / (0.1 - t) with the sign turned: it reaches 1000 in the last thousandth of its way
    spike = cd.HybridSystem(
        states="x",
        modes={"up": {"x": "1 + x**2"}},
        transitions=[cd.Transition("fire", "up", "up", guard="x - 1000", direction=1, reset={"x": "-10"})],
        initial={"x": -10.0},
        bounds={"x": (-1e6, 1e6)},
    )
    found = cd.periodic_orbit(spike, at="fire")
    time, x = found["path_time"].values, found["path_state"].values[:, 0]
    assert float(found["period_time"]) == pytest.approx(np.arctan(1000) + np.arctan(10), rel=1e-9)
    begin = np.arctan(-10.0)
    flown = time < time[-1]
    np.testing.assert_allclose(np.arctan(x[flown]) - begin, time[flown], atol=1e-9)
    middle = (time[1:-1] + time[:-2]) / 2
    off = np.abs(np.tan(begin + middle) - (x[1:-1] + x[:-2]) / 2)[np.diff(time)[:-1] > 0]
    assert off.max() < 1e-3 * 1010


def test_a_state_at_rest_needs_no_points():
    # z settles beside a clock, where rounding alone moves it
    beside = cd.HybridSystem(
        states="phi z w",
        modes={"on": {"phi": "1", "z": "w", "w": "1/2 - 21*z - w/5"}},
        transitions=[cd.Transition("turn", "on", "on", guard="phi - 1", direction=1, reset={"phi": "0"})],
        initial={"z": 0.1},
    )
    found = cd.periodic_orbit(beside, at="turn", transient=300)
    assert found["path_state"].sel(state="z").values == pytest.approx(1 / 42, rel=1e-12)
    assert found.sizes["path_point"] < 20
