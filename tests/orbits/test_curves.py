"""Curves of special points over two parameters, against closed forms, the exact flow and branches."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import fsolve
from support.following import at_both_limits, followed

import chaosdrill as cd
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.branches import BranchEnd, Special
from chaosdrill.systems import build

# Curves of special points over two parameters lie where closed forms say.


@pytest.fixture(scope="module")
def wall():
    system = build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "omega": 2.64, "e": 0.8}, {})
    return system.with_initial(x=-0.615, v=0.0178)


def test_period_doubling_of_the_impact_oscillator(wall):
    limits = {"omega": (2.5, 2.8), "e": (0.3, 0.95)}
    result = followed(wall, limits, "period_doubling", 0.01)
    omega, e = result.values.T
    # Shaw and Holmes 1983: the trace is -(1 + e^2)
    gap = np.cos(np.pi / omega) ** 2 * (omega**2 - ((1 - e) / (1 + e)) ** 2) - 1
    assert np.abs(gap).max() < 1e-11
    assert at_both_limits(result, limits)
    assert (result.special == Special.PERIOD_DOUBLING).all()
    assert np.abs(result.multipliers[:, 0] + 1).max() < 1e-11
    assert np.abs(result.multipliers[:, 1].real + e**2).max() < 1e-11
    assert result.stable.all()
    assert result.residual.max() < 1e-12
    assert result.message == ""


def test_the_curve_starts_from_the_point_on_the_branch(wall):
    result = followed(wall, {"omega": (2.5, 2.8), "e": (0.75, 0.85)}, "period_doubling", 0.01)
    (start,) = result.events
    assert start.code == Special.PERIOD_DOUBLING
    assert abs(start.values[0] - 2.653347727855322934164893) < 1e-11
    assert start.values[1] == pytest.approx(0.8, abs=1e-14)
    assert start.error < 1e-11
    assert (np.diff(result.arclength) > 0).all()


def test_grazing_of_the_free_vibration():
    system = build("impact-oscillator", {"zeta": 0.2, "wall": 1.2, "omega": 1.8}, {})
    limits = {"omega": (0.5, 2.0), "wall": (0.1, 6.0)}
    result = followed(system, limits, "grazing", 0.12, transient=100)
    w, height = result.values.T
    assert np.abs(height - 1 / np.hypot(1 - w**2, 0.4 * w)).max() < 1e-11
    # over the resonance, where the wall's parameter turns back
    assert at_both_limits(result, limits)
    assert np.allclose(np.sort(result.values[[0, -1], 0]), [0.5, 2.0], rtol=0, atol=1e-12)
    assert result.sequences == ("",)
    assert np.allclose(np.abs(result.multipliers), np.exp(-0.4 * np.pi / w)[:, np.newaxis], rtol=1e-10, atol=0)
    assert result.message == ""


def test_birth_of_the_bouncing_orbit():
    # an orbit with one impact a period of the floor needs A omega^2 cos = pi g (1 - e)/(1 + e), g = omega = 1
    limits = {"amplitude": (0.1, 1.5), "e": (0.5, 0.95)}
    result = followed(build("bouncing-ball", {}, {}), limits, "fold", 0.06)
    amplitude, e = result.values.T
    assert np.abs(amplitude - np.pi * (1 - e) / (1 + e)).max() < 1e-11
    assert at_both_limits(result, limits)
    assert (result.special == Special.FOLD).all()
    assert np.abs(result.multipliers[:, 0] - 1).max() < 1e-6
    assert np.abs(result.multipliers[:, 1].real - e**2).max() < 1e-6


def test_doublings_begin_at_a_resonance_of_the_grazing_vibration():
    zeta = 0.05
    # at 2.2 a transient may end in chatter
    system = build("impact-oscillator", {"zeta": zeta, "wall": 0.3, "omega": 2.09}, {})
    result = followed(system, {"omega": (1.9, 2.4), "wall": (0.2, 0.5)}, "period_doubling", 0.02)
    (end,) = (e for e in result.events if e.code == Special.GRAZING)
    # Nordmark 1991: where the forcing is twice the damped frequency, on the curve of grazing
    omega = 2 * np.sqrt(1 - zeta**2)
    gap = np.abs(end.values - [omega, 1 / np.hypot(1 - omega**2, 2 * zeta * omega)])
    # the multipliers have no bound there, so that it is approached only
    assert gap.max() < 1e-5
    assert gap[0] < 10 * end.error < 1e-4
    assert end.text == "impact vanishes; the curve ends"
    assert result.smallest_speed[end.point] < 1e-5


def test_what_is_not_there_is_said(wall):
    result = followed(wall, {"omega": (2.6, 2.7), "e": (0.75, 0.85)}, "fold", 0.003)
    assert result.outcome == Outcome.NO_SPECIAL_POINT
    assert result.values.shape == (0, 2)
    assert result.message.startswith("no fold on the branch of omega")
    assert "period doubling at 2.65334773" in result.message


def test_no_orbit_is_said():
    # the floor moves too little for a ball to bounce once a period
    system = build("bouncing-ball", {"amplitude": 0.1}, {})
    result = followed(system, {"amplitude": (0.05, 1.0), "e": (0.5, 0.95)}, "fold", 0.02)
    assert result.outcome != Outcome.PERIODIC
    assert result.message
    assert not len(result.values)


# A curve of folds runs through its cusps and closes on itself; cycles of a flow without forcing fold too.


@pytest.fixture(scope="module")
def loop():
    # x rests where p = x^3/3 + (q^2 - 1) x, a surface that folds on x^2 + q^2 = 1; y only keeps it from being at rest
    system = cd.HybridSystem(
        name="folded-surface",
        states="x y",
        parameters={"p": 0.0, "q": 0.3},
        modes={"free": {"x": "p - (x**3/3 + (q**2 - 1)*x)", "y": "-y + cos(t)"}},
        period="2*pi",
        initial={"x": 1.7, "y": 0.5},
    )
    return followed(system, {"p": (-1.0, 1.0), "q": (-1.5, 1.5)}, "fold", 0.04, transient=20)


def test_folds_lie_on_the_closed_form(loop):
    p, q = loop.values.T
    x = loop.section[:, 0, 0]
    assert np.abs(x**2 + q**2 - 1).max() < 1e-11
    assert np.abs(p + 2 / 3 * x**3).max() < 1e-11


def test_the_curve_is_closed_and_passes_both_cusps(loop):
    p, q = loop.values.T
    assert loop.branches[0].end_code == BranchEnd.CLOSED
    assert q.min() < -0.999
    assert q.max() > 0.999
    assert p.min() < -0.66
    assert p.max() > 0.66
    # the whole circle, and no part of it twice
    angles = np.unwrap(np.arctan2(loop.section[:, 0, 0], q))
    steps = np.diff(angles)
    assert (steps > 0).all() or (steps < 0).all()
    assert 2 * np.pi - 0.1 < abs(angles[-1] - angles[0]) < 2 * np.pi


def test_cycles_fold_together():
    square = "(x**2 + y**2)"
    # growth mu + q r^2 - r^4 of the radius: two cycles meet at r^2 = q/2
    growth, turning = f"(mu + q*{square} - {square}**2)", f"(1 + {square}/2)"
    system = cd.HybridSystem(
        name="two-cycles",
        states="x y",
        parameters={"mu": -0.1, "q": 1.0},
        modes={"flow": {"x": f"{growth}*x - {turning}*y", "y": f"{growth}*y + {turning}*x"}},
        initial={"x": 1.0},
    )
    result = followed(system, {"mu": (-1.0, 0.5), "q": (0.2, 1.8)}, "fold", 0.06, transient=100)
    mu, q = result.values.T
    assert np.abs(mu + q**2 / 4).max() < 1e-12
    assert np.abs((result.section[:, 0] ** 2).sum(axis=1) - q / 2).max() < 1e-10
    assert np.allclose([q.min(), q.max()], [0.2, 1.8], rtol=0, atol=1e-12)


# Where an event that moves the state however slow it is vanishes: the curve against the exact flow.


KICK, DAMPING = 0.5, 0.2


@pytest.fixture(scope="module")
def kicked():
    system = cd.HybridSystem(
        name="kicked-oscillator",
        states="x v",
        parameters={"omega": 1.9, "wall": 0.2},
        modes={"free": {"x": "v", "v": "-x - v/5 + cos(omega*t)"}},
        transitions=[cd.Transition("kick", "free", "free", "x - wall", +1, reset={"v": "-v/2 - 1/2"})],
        period="2*pi/omega",
    )
    return followed(system, {"omega": (1.2, 6.0), "wall": (-1.0, 1.0)}, "grazing", 0.05)


def touching_walls(omega, guess):
    """Walls that the flight which leaves them with the kick alone just touches a period later, by the exact flow."""
    flow = expm(np.array([[0, 1], [-1, -DAMPING]]) * 2 * np.pi / omega)

    def gap(unknown):
        phase, wall = unknown
        force = np.exp(1j * phase) / (1 - omega**2 + 1j * DAMPING * omega)
        forced = np.array([force.real, (1j * omega * force).real])
        return flow @ (np.array([wall, -KICK]) - forced) + forced - np.array([wall, 0.0])

    found = [fsolve(gap, (phase, guess), full_output=True, xtol=1e-13) for phase in (0.0, 2.0, 3.0, 4.0)]
    return np.array([one[0][1] for one in found if np.abs(one[1]["fvec"]).max() < 1e-14])


def test_the_kick_vanishes_where_the_exact_flow_says(kicked):
    points = kicked.values[:: len(kicked.values) // 8]
    for omega, wall in points:
        assert np.abs(touching_walls(omega, wall) - wall).min() < 1e-11
    assert np.ptp(points[:, 0]) > 1.0


def test_it_is_met_at_no_speed(kicked):
    assert (kicked.special == Special.GRAZING).all()
    assert kicked.sequences == ("kick",)
    assert kicked.smallest_speed.max() < 1e-11
    # the tangent map has no bound there
    assert np.isnan(kicked.multipliers).all()
    assert not kicked.stable.any()


# Curves of systems without a forcing: what scipy makes of the orbits on them.


def roessler_multipliers(start, a, c):
    """By the variational equation, solved by scipy until the plane across the flow is met at the start again."""

    def rates(t, z, a, c):
        slope = np.array([[0, -1, -1], [1, a, 0], [z[2], 0, z[0] - c]])
        return [-z[1] - z[2], z[0] + a * z[1], 0.2 + z[2] * (z[0] - c), *(slope @ z[3:].reshape(3, 3)).ravel()]

    whole = np.array([*start, *np.eye(3).ravel()])
    normal = np.array(rates(0, whole, a, c)[:3])

    def plane(t, z, a, c):
        return normal @ (z[:3] - start) if t > 1 else 1.0

    plane.direction = 1
    found = solve_ivp(rates, (0, 30), whole, "DOP853", args=(a, c), events=plane, rtol=1e-12, atol=1e-13)
    ends = found.y_events[0]
    end = ends[np.abs(ends[:, :3] - start).max(axis=1) < 1e-8][0]
    return np.linalg.eigvals(end[3:].reshape(3, 3))


@pytest.mark.parametrize(
    ("follow", "c", "period", "critical", "error"),
    [("period_doubling", 2.5, 1, [-1.0, 1.0], 1e-6), ("fold", 5.3, 3, [1.0, 1.0], 1e-3)],
)
def test_curves_of_a_flow_over_any_section(follow, c, period, critical, error):
    system = build("roessler", {"c": c}, {})
    limits = {"c": (2.3, 5.6), "a": (0.15, 0.25)}
    places = []
    for at in ("y < 0", "x > 0"):
        found = cd.continue_orbit(system, limits, follow=follow, at=at, period=period, step=0.2, transient=400)
        assert int(found["outcome"]) == Outcome.PERIODIC, found.attrs["message"]
        places.append(float(found["special_value"][0]))
        one = found.isel(point=found.sizes["point"] // 3)
        values = roessler_multipliers(one["orbit_state"].values, float(one["a"]), float(one["c"]))
        values = values[np.argsort(-np.abs(values))][:2]
        np.testing.assert_allclose(np.sort(values.real), critical, atol=error)
    assert places[0] == pytest.approx(places[1], abs=1e-9)


def test_period_doublings_of_a_spiking_neuron():
    """The slope of the map of u after a spike is -1: by differences of what scipy finds at the spike."""
    system = build("izhikevich", {"a": 0.2, "b": 2.0, "c": -56.0, "d": -16.0, "I": -99.0}, {})
    found = cd.continue_orbit(
        system, {"c": (-60.0, -50.0), "d": (-18.0, -12.0)}, follow="period_doubling", at="spike", step=1.2
    )

    def spike(t, y, u):
        return y[0] - 30

    spike.terminal, spike.direction = True, 1

    def after(u, c, d):
        def rates(t, y, _):
            return [0.04 * y[0] ** 2 + 5 * y[0] + 140 - y[1] - 99, 0.2 * (2 * y[0] - y[1])]

        end = solve_ivp(rates, (0, 200), [c, u], "DOP853", args=(0,), events=spike, rtol=1e-12, atol=1e-11)
        return end.y_events[0][0][1] + d

    for k in (0, -1):
        one = found.isel(point=k)
        c, d, doubled = float(one["c"]), float(one["d"]), False
        u = float(one["orbit_state"][1])
        for _ in range(2):
            u = after(u, c, d)
            doubled = doubled or abs(after(u, c, d) - u) < 1e-7
        assert doubled
        slope = (after(u + 1e-4, c, d) - after(u - 1e-4, c, d)) / 2e-4
        assert slope == pytest.approx(-1, abs=1e-5)
