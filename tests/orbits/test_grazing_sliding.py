"""The four sliding bifurcations, where exact motions say they are, and beyond; their curves over two parameters."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq, fsolve

import chaosdrill as cd
from chaosdrill.dataset.branches import Onset, Special


def coulomb(**parameters):
    """x'' + 2 z x' + x = cos(omega t) - f sign(x')."""
    free = "-x-2*z*v+cos(omega*t)"
    return cd.filippov(
        name="coulomb", states="x v", time="t", parameters={"omega": 0.35, "f": 0.1, "z": 0.0, **parameters},
        surface="v", above={"x": "v", "v": f"{free}-f"}, below={"x": "v", "v": f"{free}+f"}, period="2*pi/omega",
    )  # fmt: skip


def rising(x, start, end, omega, f, z):
    """Displacement and velocity of a motion upward that begins at x with no speed."""
    response = 1 / (1 - omega**2 + 2j * z * omega)
    turn = -z + 1j * np.sqrt(1 - z**2)

    def forced(t):
        turning = response * np.exp(1j * omega * t)
        return -f + turning.real, (1j * omega * turning).real

    (x0, v0), (x1, v1) = forced(start), forced(end)
    # c exp(turn s) with the real part x - x0, and the velocity -v0
    real, lasting = x - x0, np.exp(turn * (end - start))
    whole = real + 1j * (turn.real * real + v0) / turn.imag
    return x1 + (whole * lasting).real, v1 + (whole * turn * lasting).real


def special(branch, kind):
    places = np.flatnonzero(branch["special_kind"].values == kind)
    assert len(places) == 1, branch["special_text"].values
    return branch.isel(special=places[0])


def follow(system, sweep, steps=40, **given):
    branch = cd.continue_orbit(system, sweep, transient=400, step=float(np.ptp(list(sweep.values()))) / steps, **given)
    assert not branch.attrs["message"]
    return branch


def test_crossing_sliding_ends_motion_without_stops():
    """Den Hartog 1931: the motion stops where friction can hold it at its turning point."""
    found = special(follow(coulomb(omega=1.25, f=0.55), {"f": (0.5, 0.8)}), Special.CROSSING_SLIDING)

    def at(unknown):
        x, start, f = unknown
        end, speed = rising(x, start, start + np.pi / 1.25, 1.25, f, 0.0)
        # the other friction holds the mass from there on
        return end + x, speed, x - np.cos(1.25 * start) - f

    f = fsolve(at, (-1.8, 2.6, 0.7), xtol=1e-13)[2]
    assert f == pytest.approx(float(found["special_value"]), abs=1e-11)
    assert str(found["special_text"].values).endswith("the branch continues")


CASES = [("f", 0.35, 0.1, (0.05, 0.3)), ("f", 0.35, 0.2, (0.05, 0.3)), ("f", 0.45, 0.3, (0.1, 0.4))]
CASES += [("omega", 0.6, 0.3, (0.4, 0.9))]


@pytest.mark.parametrize(("name", "omega", "f", "limits"), CASES)
def test_switching_sliding_where_a_multiplier_is_one(name, omega, f, limits):
    """Without damping the multiplier is cos(s)^2 after a motion that takes the time s between two stops.

    At the switch x(t) - cos(omega t)/(1 - omega^2) + f, which turns at the frequency 1, comes back to its start: s is
    2 pi, and f = omega^2 sin(pi omega) / (1 - omega^2).
    """
    branch = follow(coulomb(omega=omega, f=f), {name: limits})
    assert (branch[name].values.min(), branch[name].values.max()) == limits
    found = special(branch, Special.SWITCHING_SLIDING)

    def at(w):
        return w**2 * np.sin(np.pi * w) / (1 - w**2)

    exact = at(omega) if name == "f" else brentq(lambda w: at(w) - f, 0.3, 0.6, xtol=1e-15)
    error = float(found["special_error"])
    assert abs(float(found["special_value"]) - exact) <= error < 1e-4


@pytest.mark.parametrize("steps", [20, 33])
def test_a_switch_at_which_orbits_are_hardly_known_stands_once(steps):
    """Which of the two stays begins there is a matter of rounding: they begin together, as the orbit is symmetric."""
    found = special(follow(coulomb(omega=0.35, f=0.2), {"f": (0.05, 0.3)}, steps), Special.SWITCHING_SLIDING)
    assert str(found["special_text"].values) == "cross-down and cross-up appear; the branch continues"


@pytest.mark.parametrize("f", [0.04, 0.07])
def test_switching_sliding_from_either_side(f):
    """A symmetric orbit of two stops: one begins where friction cannot hold the mass on the other side yet."""
    branch = follow(coulomb(f=f, z=0.1), {"f": (0.03, 0.08)})
    found = special(branch, Special.SWITCHING_SLIDING)
    assert special(branch, Special.GRAZING_SLIDING)["special_value"] < found["special_value"]

    def at(unknown):
        x, start, lasting, f = unknown
        end, speed = rising(x, start, start + lasting, 0.35, f, 0.1)
        held = np.cos(0.35 * start) - x - f, np.cos(0.35 * (start + lasting)) - end + f
        return end + x, speed, *held

    for guess in np.linspace(-1.2, 1.2, 25):
        begun = 2 * np.pi - np.arccos(np.clip(guess + 0.047, -1, 1))
        solved, _, code, _ = fsolve(at, (guess, begun / 0.35, 8.845, 0.047), full_output=True, xtol=1e-13)
        if code == 1 and abs(solved[3] - 0.047) < 1e-3 and abs(solved[2] - 8.845) < 0.1:
            break
    assert solved[3] == pytest.approx(float(found["special_value"]), abs=1e-11)


def test_adding_sliding_where_the_force_is_greatest_in_a_stop():
    """A stop at x = f - 1: there the force just reaches the friction when it is greatest."""
    found = special(follow(coulomb(omega=0.2, f=0.5), {"f": (0.38, 0.6)}), Special.ADDING_SLIDING)
    f = float(found["special_value"])
    assert int(found["special_onset"]) == Onset.CONTINUOUS
    assert float(found["special_power"]) == 2
    at_stop = cd.periodic_orbit(coulomb(omega=0.2, f=f + 1e-9), transient=400)
    assert np.abs(np.abs(at_stop["event_state_before"].values[:, 0]) - (1 - f)).max() < 1e-7


@pytest.mark.parametrize("mu", [0.9, 1.1])
def test_grazing_sliding_of_a_circle(mu):
    """The circle of radius sqrt(mu) touches y = 1; deviations across it shrink by exp(-4 pi) in a turn."""
    turning = {"x": "mu*x - y - x*(x**2 + y**2)", "y": "x + mu*y - y*(x**2 + y**2)"}
    system = cd.filippov(
        name="circle", states="x y", parameters={"mu": mu}, surface="y - 1", below=turning,
        above={"x": "0.3", "y": "-1"}, initial={"x": 0.9, "y": 0.0},
    )  # fmt: skip
    found = special(follow(system, {"mu": (0.8, 1.2)}), Special.GRAZING_SLIDING)
    assert float(found["special_value"]) == pytest.approx(1, abs=1e-12)
    assert (int(found["special_onset"]), float(found["special_power"])) == (Onset.CONTINUOUS, 1.0)
    assert float(found["grazing_coefficient"]) == pytest.approx(-np.exp(-4 * np.pi), rel=1e-7)


def friction():
    field = "-x {} 1.5 - 1.5*(1 - v) + 0.45*(1 - v)**3 + F*cos(omega*t)"
    return cd.filippov(
        name="belt", states="x v", time="t", parameters={"omega": 1.72, "F": 0.1}, surface="v - 1",
        below={"x": "v", "v": field.format("+")}, above={"x": "v", "v": field.format("-")}, period="2*pi/omega",
        initial={"x": 1.0, "v": 0.5},
    )  # fmt: skip


def test_the_forced_belt_grazes_where_scipy_finds_it():
    """An orbit of period 4 that nowhere stops touches v = 1 there; the figure is ours, by DOP853.

    The friction is that of di Bernardo, Kowalczyk and Nordmark 2003, doi:10.1142/S021812740300834X.
    """
    branch = cd.continue_orbit(friction(), {"omega": (1.70, 1.73)}, transient=800, period=2, step=1e-3, doublings=1)
    found = special(branch, Special.GRAZING_SLIDING)
    assert int(found["period"][int(found["special_index"])]) == 4

    def rates(t, state, omega):
        x, v = state
        return v, -x + 1.5 - 1.5 * (1 - v) + 0.45 * (1 - v) ** 3 + 0.1 * np.cos(omega * t)

    def at(unknown):
        phase, omega = unknown
        touching, span = (1.5 + 0.1 * np.cos(phase), 1.0), np.array([phase, phase + 8 * np.pi]) / omega
        path = solve_ivp(rates, span, touching, args=(omega,), method="DOP853", rtol=1e-12, atol=1e-13)
        return path.y[:, -1] - touching

    assert fsolve(at, (3.78, 1.708), xtol=1e-12)[1] == pytest.approx(float(found["special_value"]), abs=1e-10)


def test_the_flip_curve_of_slidecont():
    """F, frequency and largest v of the flip curve of the dry-friction oscillator, and its fold.

    Printed in F. Dercole, Yu. A. Kuznetsov, "User Guide to SlideCont 2.0", 2005, for the motion of period 2 below
    v = 1, which goes on above as if there were no surface. The largest v is that on a mesh.
    """
    printed = np.array(
        [
            [1.52127, 2.60775, 1.08642],
            [1.77224, 2.66918, 1.20247],
            [2.03041, 2.71408, 1.33688],
            [2.28608, 2.73420, 1.49759],
        ]
    )
    system = cd.HybridSystem(
        name="below", states="x v", time="t", parameters={"omega": 2.6, "F": 1.52127}, period="2*pi/omega",
        modes={"on": {"x": "v", "v": "-x + 1.5 - 1.5*(1 - v) + 0.45*(1 - v)**3 + F*cos(omega*t)"}},
        initial={"x": 0.24, "v": 0.06},
    )  # fmt: skip
    curve = cd.continue_orbit(
        system, {"omega": (2.59, 2.8), "F": (1.5, 2.6)}, follow="period_doubling", period=2, start="guess", step=0.04,
        functions={"top": {"of": "v", "take": "maximum"}, "force": {"of": "F"}}, optima=["force"],
    )  # fmt: skip
    assert not curve.attrs["message"]
    folds = curve["special_value_2"].values[curve["special_kind"].values == Special.OPTIMUM]
    assert folds == pytest.approx([2.56957], abs=5e-6)
    fold, highest = curve["F"].values.argmax(), curve["omega"].values.argmax()
    side = slice(fold, None) if highest > fold else slice(fold, None, -1)
    force, omega = (curve[name].values[side][::-1] for name in ("F", "omega"))
    top = curve["function_value"].sel(function="top").values[side][::-1]
    assert np.abs(CubicSpline(force, omega)(printed[:, 0]) - printed[:, 1]).max() < 5e-6
    missed = CubicSpline(force, top)(printed[:, 0]) - printed[:, 2]
    assert ((missed > 0) & (missed < 1e-3)).all()


def test_a_curve_of_grazing_sliding_over_two_parameters():
    """A stop at f - 1 whatever the frequency: along a curve of adding-sliding the force just reaches the friction."""
    curve = cd.continue_orbit(
        coulomb(omega=0.2, f=0.5), {"f": (0.38, 0.6), "omega": (0.18, 0.22)}, follow="grazing", transient=400,
        step=0.01,
    )  # fmt: skip
    assert curve.sizes["point"] > 5
    for k in (0, curve.sizes["point"] // 2, curve.sizes["point"] - 1):
        omega, f = float(curve["omega"][k]), float(curve["f"][k])
        at_stop = cd.periodic_orbit(coulomb(omega=omega, f=f + 1e-9), transient=400)
        assert np.abs(np.abs(at_stop["event_state_before"].values[:, 0]) - (1 - f)).max() < 1e-7


def test_a_curve_of_crossing_sliding_is_den_hartogs():
    """Without damping an orbit that stops nowhere takes half a period for each way: Den Hartog 1931."""
    curve = cd.continue_orbit(
        coulomb(omega=1.25, f=0.55), {"f": (0.3, 0.9), "omega": (1.05, 1.6)}, follow="crossing_sliding", transient=400,
        step=0.05,
    )  # fmt: skip
    assert (curve["omega"].values.min(), curve["omega"].values.max()) == (1.05, 1.6)
    for omega, f, x in zip(curve["omega"].values, curve["f"].values, curve["orbit_state"].values[:, 0], strict=True):

        def at(unknown, omega=omega):
            x, start, f = unknown
            end, speed = rising(x, start, start + np.pi / omega, omega, f, 0.0)
            return end + x, speed, x - np.cos(omega * start) - f

        guesses = ((x, start / omega, f) for start in np.linspace(0, 2 * np.pi, 9))
        solved = (fsolve(at, guess, xtol=1e-13, full_output=True) for guess in guesses)
        assert min(abs(one[0][2] - f) for one in solved if one[2] == 1) < 1e-12


@pytest.fixture(scope="module")
def landing():
    """Above, h' = A cos t - 1: from a stay the motion rises at cos t = 1/A, and lands at a time that A decides.

    There the field below, sin(t - s) + r, is tangent to h = 0 where r = -sin(time - s). y and z turn by 0.6 pi in a
    period and grow by exp(2 pi (p - 1)).
    """
    turning = {"y": "(p-1)*y + 0.3*z", "z": "-0.3*y + (p-1)*z"}
    system = cd.filippov(
        name="landing", states="h y z", time="t", parameters={"A": 4.0, "s": 0.0, "r": 0.0, "p": 0.7}, surface="h",
        above={"h": "A*cos(t) - 1", **turning}, below={"h": "sin(t - s) + r", **turning}, period="2*pi",
        initial={"mode": "above", "h": 0.1},
    )  # fmt: skip
    rise = np.arccos(1 / 4)
    return system, brentq(lambda t: 4 * (np.sin(t) + np.sin(rise)) - t - rise, rise, 2 * np.pi - rise, xtol=1e-15)


def kinds(found, *names):
    return {
        kind: [float(found[name][int(k)]) for name in names]
        for kind, k in zip(found.cd.words("special_kind").values, found["special_index"].values, strict=True)
    }


def test_switching_sliding_ends_where_the_tangency_is_of_third_order(landing):
    """At the landing sin(t - s) + r and its rate are zero: it only touches zero, and crossing-sliding begins there."""
    system, lands = landing
    start = system.with_parameters(s=lands + 0.8, r=np.sin(0.8) + 0.05)
    given = {"follow": "switching_sliding", "transient": 50, "step": 0.1}
    curve = cd.continue_orbit(start, {"r": (0.5, 1.3), "s": (lands + 0.5, lands + 2)}, **given)
    assert np.abs(curve["r"].values + np.sin(lands - curve["s"].values)).max() < 1e-12
    marks = kinds(curve, "r", "s")
    assert set(marks) == {"switching_sliding", "degenerate_sliding"}
    assert np.abs(np.array(marks["degenerate_sliding"]) - [1, lands + np.pi / 2]).max() < 1e-10
    assert "third order" in curve["branch_end_text"].item()
    curve = cd.continue_orbit(start, {"r": (0.0, 1.3), "p": (0.4, 1.3)}, **given)
    assert np.abs(curve["r"].values - np.sin(0.8)).max() < 1e-12
    assert abs(kinds(curve, "p")["sliding_neimark_sacker"][0] - 1) < 1e-12


def test_crossing_sliding_with_and_without_a_stay_in_the_period(landing):
    """Where the way below ends after the field above turns upward the orbit crosses back, and lands at another time."""
    system, lands = landing
    start = system.with_parameters(s=lands + 2, r=np.sin(2) + 0.05)
    over = {"r": (0.0, 1.3), "s": (lands - 0.5, lands + 2.5)}
    curve = cd.continue_orbit(start, over, follow="crossing_sliding", transient=50, step=0.1)
    marks = kinds(curve, "r", "s")
    assert np.abs(np.array(marks["degenerate_sliding"]) - [1, lands + np.pi / 2]).max() < 1e-6
    # it ends where the flight above does: it begins at the time of its landing, a period later
    assert np.abs(np.array(marks["grazing"]) - [0, np.arccos(1 / 4) + np.pi]).max() < 1e-6
    r, s = curve["r"].values, curve["s"].values
    change = int(np.flatnonzero(r == marks["border_collision"][0])[0])
    stays = slice(change, None) if abs(s[-1] - lands - np.pi / 2) < 1e-6 else slice(0, change + 1)
    assert np.abs(r + np.sin(lands - s))[stays].max() < 1e-12
    beyond = np.setdiff1d(np.arange(len(r)), np.arange(len(r))[stays])[1:-1]
    assert len(beyond) > 5

    for k in beyond:
        # from above the orbit lands where sin(t - s) + r falls through zero, and it came from where it crossed upward
        down = (s[k] + np.pi + np.arcsin(r[k])) % (2 * np.pi)
        ups = np.linspace(-1.318, 1.318, 40)
        flights = 4 * (np.sin(down) - np.sin(ups)) - down + ups
        left = []
        for i in np.flatnonzero(flights[1:] * flights[:-1] < 0):
            up = brentq(lambda u, down=down: 4 * (np.sin(down) - np.sin(u)) - down + u, *ups[i : i + 2], xtol=1e-15)
            left.append(np.cos(down - s[k]) - np.cos(up - s[k]) + r[k] * (up + 2 * np.pi - down))
        assert np.abs(left).min() < 1e-11


@pytest.mark.parametrize(("s", "r"), [(2.0, 0.93), (1.8, 0.93), (2.4, 0.93), (1.8, 1.1)])
def test_the_bar_of_adding_sliding_covers_a_stay_that_is_lost_before_it_is_none(landing, s, r):
    """A stay parts where sin(t - s) + r touches zero, at r = 1; the way between its parts is as short as the root."""
    system, lands = landing
    start = system.with_parameters(s=lands + s, r=r)
    found = special(cd.continue_orbit(start, {"r": (0.9, 1.15)}, transient=50, step=0.01), Special.ADDING_SLIDING)
    assert abs(float(found["special_value"]) - 1) <= float(found["special_error"]) < 1e-6
