"""The size of a state is that of its motion: in any unit, for every method, whatever a reset writes."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import chaosdrill as cd
from chaosdrill.dataset import Outcome
from chaosdrill.declared import METHODS
from chaosdrill.engine.batch import Batch
from chaosdrill.engine.numerics import Numerics

ADAPTIVE = sorted(name for name, method in METHODS.items() if not method.fixed_step)


def held():
    """States that rest until a clock passes 0.7, are then set, and move: one at once, one with the eighth power of
    time. Their units, that of the clock and that of time are parameters."""
    return cd.HybridSystem(
        name="held",
        states="x y z",
        parameters={"set": 0.0, "a": 1.0, "b": 1.0, "w": 1.0},
        modes={
            "rests": {"x": "a*w", "y": "0", "z": "0"},
            "moves": {"x": "a*w", "y": "b*w*cos(x/a)", "z": "b*w*(1 - cos(x/a - 0.7))**4"},
        },
        transitions=[
            cd.Transition("go", "rests", "moves", guard="x - 0.7*a", direction=+1, reset={"y": "b*set", "z": "b*set"})
        ],
        bounds=dict.fromkeys("xyz", (-1e300, 1e300)),
        initial={"mode": "rests"},
    )


HELD = held()

with mpmath.workdps(30):
    LATE = float(mpmath.quad(lambda t: (1 - mpmath.cos(t)) ** 4, [0, 1.3]))

values = st.one_of(st.just(0.0), st.floats(-280, -6).map(lambda e: 10.0**e))


@given(method=st.sampled_from(ADAPTIVE), value=values, sign=st.sampled_from([-1, 1]), started=st.booleans())
@example(method="dop853", value=1e-30, sign=1, started=False)
@example(method="radau", value=1e-10, sign=1, started=False)
@example(method="dop853", value=1e-30, sign=1, started=True)
@example(method="taylor", value=1e-251, sign=-1, started=False)
def test_a_state_that_is_set_to_next_to_nothing_goes_on(method, value, sign, started):
    value *= sign
    system = HELD.with_parameters(set=value)
    if started:
        system = system.with_initial(mode="moves", x=0.7, y=value, z=value)
    run = cd.trajectory(system, duration=1.3 if started else 2.0, samples=1, method=method)
    assert Outcome(int(run["outcome"])) == Outcome.OK
    x, y, z = run["states"].values[-1]
    assert x == pytest.approx(2.0, abs=1e-13)
    assert y == pytest.approx(math.sin(2.0) - math.sin(0.7) + value, abs=1e-12)
    assert z == pytest.approx(LATE + value, rel=3e-12)


WATCHED = cd.HybridSystem(
    name="watched",
    states="x y",
    parameters={"set": 0.0, "k": 1.0, "w": 1.0},
    modes={"rests": {"x": "w", "y": "0"}, "moves": {"x": "w", "y": "k*w*cos(x)"}},
    transitions=[
        cd.Transition("go", "rests", "moves", guard="x - 0.7", direction=+1, reset={"y": "k*set"}),
        cd.Transition("back", "moves", "rests", guard="y", direction=-1),
    ],
    initial={"mode": "rests"},
)


@pytest.mark.parametrize("method", [*ADAPTIVE, "lanes"])
@pytest.mark.parametrize(("k", "w"), [(1.0, 1.0), (2.0**-40, 1.0), (2.0**30, 2.0**20)])
def test_a_state_that_is_set_to_rounding_beside_a_guard_that_it_leaves(method, k, w):
    """-sin(pi) in doubles is beyond zero by what the time of the event is rounded; -1e-6 is beyond it."""
    for value in (1.3e-16, 1.2e-16, 0.0, -1.2e-16, -1.3e-16):
        system = WATCHED.with_parameters(set=value, k=k, w=w)
        if method == "lanes":
            batch = Batch(system, {}, np.zeros((3, 2)), np.zeros(3, dtype=int), Numerics(), unit=2.0 / w)
            batch.run(0, np.array([0, 1]))
            end = batch.x[1]
        else:
            run = cd.trajectory(system, duration=2.0 / w, samples=1, method=method)
            assert run.sizes["event"] == 1
            end = run["states"].values[-1]
        assert end[1] / k == pytest.approx(math.sin(2.0) - math.sin(0.7), abs=1e-12)
    beyond = cd.trajectory(WATCHED.with_parameters(set=-1e-6, k=k, w=w), duration=2.0 / w, samples=1)
    assert Outcome(int(beyond["outcome"])) == Outcome.STALLED


powers = st.integers(-40, 40).map(lambda k: 2.0**k)


# the short series of lanes begin what is set to 1e-280, and has no rate there, with steps that underflow
@settings(max_examples=60)
@given(
    method=st.sampled_from([*ADAPTIVE, "lanes"]),
    value=st.one_of(st.just(0.0), st.floats(-100, -6).map(lambda e: 10.0**e)),
    a=powers,
    b=powers,
    w=st.integers(-20, 20).map(lambda k: 2.0**k),
)
@example(method="dop853", value=1e-13, a=1.0, b=2.0**-40, w=1.0)
def test_units_change_nothing_but_units(method, value, a, b, w):
    """Those of states that are powers of two, not one bit; of time, and in the pivots of an implicit step, rounding."""

    def end(a, b, w):
        system = HELD.with_parameters(set=value, a=a, b=b, w=w)
        if method == "lanes":
            batch = Batch(system, {}, np.zeros((3, 3)), np.zeros(3, dtype=int), Numerics(), unit=2.0 / w)
            batch.run(0, np.array([0, 1]))
            return batch.x[1] / [a, b, b]
        run = cd.trajectory(system, duration=2.0 / w, samples=1, method=method)
        assert Outcome(int(run["outcome"])) == Outcome.OK
        return [*(run["states"].values[-1] / [a, b, b]), float(run["event_time"][0]) * w]

    off = 0.0 if method != "radau" and w == 1.0 else 1e-13
    np.testing.assert_allclose(end(a, b, w), end(1.0, 1.0, 1.0), rtol=0, atol=off)


FILTER = cd.driven(
    cd.HybridSystem(
        name="filter", states="y", parameters={"u": 0.0, "om": 0.1, "k": 5.0}, modes={"m": {"y": "k*(u - y)"}},
        period="2*pi/om", initial={},
    ),
    "u",
    {0: "1", 0.1: "0"},
)  # fmt: skip


@pytest.mark.parametrize("om", [0.2, 0.1, 0.03])
@pytest.mark.parametrize("method", ADAPTIVE)
def test_a_filter_behind_a_drive_with_pauses_goes_on(method, om):
    system = FILTER.with_parameters(om=om)
    spectrum = cd.lyapunov_spectrum(system, periods=20, method=method)
    assert Outcome(int(spectrum["outcome"])) == Outcome.PERIODIC
    assert spectrum["lyapunov_exponent"].values == pytest.approx([-5.0], abs=1e-9)
    run = cd.trajectory(system, periods=10, samples=20, method=method)
    assert Outcome(int(run["outcome"])) == Outcome.OK
    period = 2 * math.pi / om
    phase = np.arange(run.sizes["time"]) % 20 / 20
    # what the pulses before have left is below all rounding
    rise = -np.expm1(-5.0 * np.minimum(phase, 0.1) * period)
    right = rise * np.exp(-5.0 * np.maximum(phase - 0.1, 0.0) * period)
    np.testing.assert_allclose(run["states"].values[:, 0], np.where(phase > 0, right, 0.0), rtol=0, atol=1e-11)


SLOW = cd.HybridSystem(
    name="slow",
    states="x v",
    parameters={"k": 1.0, "u": 1.0},
    modes={"one": {"x": "-k*(x - u*cos(t))", "v": "0"}, "two": {"x": "v", "v": "-k*v - k*(x - u*sin(t))"}},
    bounds=dict.fromkeys("xv", (-1e300, 1e300)),
)
"""A relaxation to a drive, of one state or of two."""


def relaxed(k, off, t):
    """The state of mode one in units of the drive, exactly, from 1 + off."""
    return (k * k * np.cos(t) + k * np.sin(t)) / (k * k + 1) + (off + 1 / (k * k + 1)) * np.exp(-k * t)


def relaxed_twice(k, t):
    """The same of mode two, from rest at zero."""
    a = k * (k - 1) / ((k - 1) ** 2 + k * k)
    b = -k * k / ((k - 1) ** 2 + k * k)
    fast = -(k + np.emath.sqrt(k * k - 4 * k)) / 2
    slow = k / fast
    c = (b * fast - a) / (slow - fast)
    return (a * np.sin(t) + b * np.cos(t) + c * np.exp(slow * t) - (b + c) * np.exp(fast * t)).real


@pytest.mark.parametrize("method", ["dop853", "radau"])
@pytest.mark.parametrize("off", [0.0, 2.0**-52, -0.5, None])
@given(k=st.floats(0, 7), tolerance=st.floats(-12, -6), unit=st.floats(-9, 9), reach=st.floats(2, 5.5))
@example(k=5.0, tolerance=-8.0, unit=0.0, reach=5.7)
@example(k=6.0, tolerance=-12.0, unit=9.0, reach=5.5)
@settings(max_examples=8)
def test_a_start_at_rest_on_what_is_slow_of_what_is_stiff(method, off, k, tolerance, unit, reach):
    k, tolerance, unit = 10.0**k, 10.0**tolerance, 10.0**unit
    start = {"mode": "two"} if off is None else {"mode": "one", "x": unit * (1 + off)}
    system = SLOW.with_parameters(k=k, u=unit).with_initial(x=0.0, v=0.0).with_initial(**start)
    # where stages have exploded, that decays again soon
    t = np.geomspace(1e-4, 1.0, 50) * (5.0 if method == "radau" else min(5.0, 10.0**reach / k))
    run = cd.trajectory(system, duration=t[-1], times=t, method=method, tolerance=tolerance)
    assert Outcome(int(run["outcome"])) == Outcome.OK
    exact = relaxed_twice(k, t) if off is None else relaxed(k, off, t)
    size = np.abs(exact).max()
    assert np.abs(run["states"].values[:, 0] / unit - exact).max() <= 500 * tolerance * size + 1e-14
