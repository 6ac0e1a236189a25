"""Hunt-Crossley contacts: exit speed, slope, duration and peak force, from the law and from the contact integrated."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.codegen.special import hunt_crossley_duration, hunt_crossley_exit, hunt_crossley_peak
from chaosdrill.model.special import positive_power

# mass, stiffness, exponent, damping, entry speed; exit speed, slope, duration, peak force
ROWS = [
    (1.0, 1e6, 1.5, 0.3, 1.0, 0.8328697922656, 0.692821438954, 0.01308784404082, 265.837),
    (1.0, 1e6, 1.0, 0.3, 1.0, 0.8328697922656, 0.692821438954, 0.00315145331674, 947.613),
    (2.0, 5e3, 2.0, 1.7, 2.5, 0.5715638630951, 0.023612270164, 0.27125357342685, 119.591),
]
METHODS = [(row, "dop853") for row in ROWS] + [(row, "taylor") for row in ROWS if row[2] == int(row[2])]


@pytest.mark.parametrize("row", ROWS)
def test_exit_speed_and_peak_force(row):
    mass, stiffness, n, lam, v, leave, _, _, force = row
    assert hunt_crossley_exit(v, lam) == pytest.approx(leave, abs=5e-14)
    assert mass * hunt_crossley_peak(v, lam, n, stiffness / mass) == pytest.approx(force, abs=6e-4)


@pytest.mark.parametrize("row", ROWS)
def test_slope(row):
    lam, v, slope = row[3], row[4], row[6]
    h = 1e-5
    difference = (hunt_crossley_exit(v + h, lam) - hunt_crossley_exit(v - h, lam)) / (2 * h)
    s = hunt_crossley_exit(v, lam)
    assert v / (1 + lam * v) * (1 - lam * s) / s == pytest.approx(slope, abs=1e-12)
    assert difference == pytest.approx(slope, abs=1e-9)


@pytest.mark.parametrize("row", ROWS)
def test_duration(row):
    mass, stiffness, n, lam, v, *_, duration, _ = row
    assert hunt_crossley_duration(v, lam, n, stiffness / mass) == pytest.approx(duration, rel=2e-12)


@pytest.mark.parametrize(("row", "method"), METHODS)
def test_the_contact_integrated_leaves_at_that_speed_and_time(row, method):
    mass, stiffness, n, lam, v0, leave, _, duration, force = row
    d, v, k, damping, exponent = sympy.symbols("d v k lam n", real=True)
    acceleration = -k * positive_power(d, exponent) * (1 + damping * v)
    system = cd.HybridSystem(
        name="contact",
        states=(d, v),
        parameters={"k": stiffness / mass, "lam": lam, "n": n},
        modes={"touch": {d: v, v: acceleration}, "apart": {d: v, v: 0}},
        transitions=[cd.Transition("exit", source="touch", target="apart", guard=d, direction=-1)],
        initial={"mode": "touch", d: 0.0, v: v0},
    )
    run = cd.trajectory(system, duration=1.01 * duration, samples=4001, method=method, tolerance=1e-13)
    assert run.sizes["event"] == 1
    assert float(run["event_time"][0]) == pytest.approx(duration, rel=1e-11)
    assert float(run["event_state_before"][0, 1]) == pytest.approx(-leave, rel=1e-11)
    depth, speed = run["state"].values[run["time"].values < duration].T
    largest = np.max(stiffness * depth**n * (1 + lam * speed))
    assert largest == pytest.approx(force, rel=1e-5)
