"""What moves in proportion to itself is as exact in parts of its value, however far it falls, in any unit."""

import numpy as np
import pytest

import chaosdrill as cd

METHODS = ("taylor", "dop853", "radau")
FALL = 60.0


def swing(rate="-a*sin(t)*x", unit=1.0, **more):
    """x falls from one unit by a factor exp(-2 a), and is back after a turn: it is exp(a (cos t - 1)) units."""
    return cd.HybridSystem(
        states="x s", time="t", parameters={"a": FALL, "unit": unit}, modes={"on": {"x": rate, "s": "x/unit - s"}},
        period="2*pi", initial={"x": unit, "s": 0.0}, **more,
    )  # fmt: skip


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("rate", ["-a*sin(t)*x", "a*sin(t)*x**2/unit - a*sin(t)*(x + x**2/unit)"])
@pytest.mark.parametrize("unit", [1.0, 1e-12, 5e7])
def test_it_comes_back_from_what_is_left_of_it(method, rate, unit):
    found = cd.trajectory(swing(rate, unit), periods=2, samples=100, method=method, tolerance=1e-12)
    expected = FALL * (np.cos(found["time"].values) - 1)
    np.testing.assert_allclose(np.log(found["states"].values[:, 0] / unit), expected, atol=3e-9)


@pytest.mark.parametrize("method", METHODS)
def test_an_event_of_its_return_is_in_time(method):
    back = cd.Transition("back", "on", "on", "x - unit*exp(-30)", 1, reset={})
    found = cd.trajectory(swing(transitions=[back]), periods=1, samples=2, method=method, tolerance=1e-12)
    assert found["event_time"].values == pytest.approx([2 * np.pi - np.arccos(0.5)], abs=1e-10)


@pytest.fixture(scope="module")
def seasons():
    """x falls for one unit of time and grows for the next, each at one rate."""
    turns = [cd.Transition(a, a, b, "sin(pi*t)", way) for a, b, way in (("dry", "wet", -1), ("wet", "dry", 1))]
    return cd.HybridSystem(
        states="x", parameters={"a": FALL}, modes={"dry": {"x": "-a*x"}, "wet": {"x": "a*x"}}, transitions=turns,
        period=2, initial={"mode": "dry", "x": 1.0},
    )  # fmt: skip


@pytest.mark.parametrize("method", METHODS)
def test_rates_that_change_with_the_mode(seasons, method):
    """It came back 1e13 times too large."""
    found = cd.trajectory(seasons, periods=3, samples=8, method=method, tolerance=1e-11)
    expected = FALL * (np.abs(found["time"].values % 2 - 1) - 1)
    np.testing.assert_allclose(np.log(found["states"].values[:, 0]), expected, atol=3e-9)


def test_modes_side_by_side(seasons):
    found = cd.bifurcation_diagram(seasons, {"a": np.linspace(20.0, 70.0, 16)}, transient=2, periods=8, tolerance=1e-12)
    np.testing.assert_allclose(found["section"].values[..., 0], 1.0, rtol=1e-8)


def test_runs_side_by_side():
    sizes = np.linspace(20.0, 70.0, 16)
    found = cd.bifurcation_diagram(swing(), {"a": sizes}, transient=2, periods=8, tolerance=1e-12)
    np.testing.assert_allclose(found["section"].values[..., 0], 1.0, rtol=1e-8)


@pytest.mark.parametrize("method", METHODS)
def test_hunters_and_hunted_keep_their_integral(method):
    """Volterra's integral, of a cycle on which both fall below exp(-50)."""
    pair = cd.HybridSystem(
        states="x y", modes={"on": {"x": "x*(1 - y)", "y": "y*(x - 1)"}}, initial={"x": 1.0, "y": 60.0}
    )
    found = cd.trajectory(pair, duration=200.0, samples=401, method=method, tolerance=1e-12)
    x, y = found["states"].values.T
    assert min(x.min(), y.min()) < np.exp(-50)
    np.testing.assert_allclose(x - np.log(x) + y - np.log(y), 61 - np.log(60.0), rtol=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_exponents_are_those_of_its_logarithm(method):
    """A forced epidemic that falls below exp(-25) between its outbreaks (Olsen and Schaffer 1990)."""
    rate = "b*(1 + e*cos(2*pi*t))"
    written = {
        "i": {"s": f"mu*(1 - s) - {rate}*s*i", "i": f"{rate}*s*i - (g + mu)*i"},
        "l": {"s": f"mu*(1 - s) - {rate}*s*exp(l)", "l": f"{rate}*s - g - mu"},
    }
    values = {"b": 1250.0, "e": 0.05, "g": 73.0, "mu": 0.02}
    starts = {"i": {"s": 0.06, "i": 1e-3}, "l": {"s": 0.06, "l": np.log(1e-3)}}
    found = []
    for last, rates in written.items():
        system = cd.HybridSystem(
            states=["s", last], time="t", parameters=values, modes={"on": rates}, period=1.0, initial=starts[last]
        )
        found.append(cd.lyapunov_spectrum(system, transient=200, periods=600, method=method, tolerance=1e-11))
    one, other = (each["lyapunov_exponent"].values for each in found)
    np.testing.assert_allclose(one, other, atol=4e-3)


def test_what_decays_for_ever_leaves_the_rest_alone():
    rates = {"x": "10*(y - x)", "y": "x*(28 - z) - y", "z": "x*y - 8*z/3", "w": "w*(x/40 - 5)"}
    lorenz = cd.HybridSystem(states=[*rates], modes={"on": rates}, initial={"x": 1.0, "y": 2.0, "z": 20.0, "w": 1.0})
    found = cd.lyapunov_spectrum(lorenz, duration=400.0, transient=50.0, tolerance=1e-10)
    off = abs(found["lyapunov_exponent"].values - [0.9056, 0, -5, -14.572])
    np.testing.assert_array_less(off, 4 * found["lyapunov_error"].values + 0.01)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("duration", [90.0, 250.0])
def test_exponents_beside_what_dies_out_are_those_of_the_rest_state(method, duration):
    """Two losers decay for ever beside a winner, from deviations of which squares are below rounding."""
    rates = {"x": "x*(1 - x - y - 2*z)", "y": "y*(1 - 1.7*x - z)", "z": "z*(2 - 4.3*x - y)"}
    three = cd.HybridSystem(states=[*rates], modes={"on": rates}, initial={"x": 1.0, "y": 1e-9, "z": 1e-9})
    found = cd.lyapunov_spectrum(three, duration=duration, transient=200, method=method, tolerance=1e-12)
    expected = [-0.7, -1.0, -2.3]
    np.testing.assert_allclose(found["lyapunov_exponent"], expected, atol=1e-6)
    assert found["lyapunov_exponent"].sum() == pytest.approx(-4.0, abs=1e-8)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("unit", [1.0, 1e-9])
def test_what_dies_out_leaves_tangents_their_accuracy(method, unit):
    """Both exponents of the winner's rest are -1, and their mean on the way there is that of the divergence."""
    rates = {"x": "x*(1 - x - 2*y/unit)", "y": "y*(1 - 2*x - y/unit)"}
    rivals = cd.HybridSystem(
        states="x y", parameters={"unit": unit}, modes={"on": rates}, initial={"x": 0.6, "y": 0.3 * unit}
    )
    found = cd.lyapunov_spectrum(rivals, duration=200, transient=20, method=method, tolerance=1e-12)
    assert float(found["lyapunov_exponent"].sum()) == pytest.approx(-2, abs=1e-6)
    assert abs(found["lyapunov_exponent"] + 1).max() < 0.2


def test_exponents_beside_what_dies_out_in_runs_side_by_side():
    growth = np.linspace(0.1, 0.8, 8)
    rates = {"x": "x*(b - x - y - 2*z)", "y": "y*(a - 1.9*x - z)", "z": "z*(2 - 4.3*x - y)"}
    three = cd.HybridSystem(
        states=[*rates], parameters={"a": 0.5, "b": 1.0}, modes={"on": rates}, initial={"x": 1.0, "y": 1e-9, "z": 1e-9}
    )
    found = cd.parameter_chart(
        three, {"a": growth, "b": [1.0]}, duration=90, transient=400, tolerance=1e-12, exponents=3
    )
    expected = np.sort([growth - 1.9, np.full(8, -1.0), np.full(8, -2.3)], axis=0)[::-1]
    np.testing.assert_allclose(
        found["lyapunov_exponent"].squeeze(("b", "seed")).transpose("exponent", "a"), expected, atol=1e-6
    )
