"""Tori of flows have their word, and cycles on them that go round hundreds of times do not take it."""

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.analysis.judgement.frequencies import incommensurate
from chaosdrill.analysis.judgement.predicting import predicted

ONE = {"x": "x - y - x*(x**2 + y**2)", "y": "x + y - y*(x**2 + y**2)"}
OTHER = {"u": "u - w*v - u*(u**2 + v**2)", "v": "w*u + v - v*(u**2 + v**2)"}
ROTATORS = cd.HybridSystem(name="rotators", states="x y u v", parameters={"w": 1.0}, modes={"on": ONE | OTHER})


def word(ratio, duration):
    system = ROTATORS.with_parameters(w=ratio).with_initial(x=0.6, y=0.8, u=1.0)
    return cd.lyapunov_spectrum(system, duration=duration, transient=60).cd.outcome


@pytest.mark.parametrize("ratio", [(np.sqrt(5) - 1) / 2, np.sqrt(7) - 1])
def test_two_rotators_without_a_common_period_are_on_a_torus(ratio):
    """Samples are a lattice on the torus, in which the nearest lie along the flow, or nearly."""
    assert word(ratio, 6_144.0) == "quasiperiodic"


@pytest.mark.parametrize("points", [512, 1024])
def test_a_torus_is_one_over_any_number_of_turns(points):
    """Instants that are so many parts of a turn would be at two or four phases of it only."""
    third = {"a": "a - 2*b - a*(a**2 + b**2)", "b": "2*a + b - b*(a**2 + b**2)"}
    three = cd.HybridSystem(
        name="three", states="x y u v a b", parameters={"w": 2**0.5}, modes={"on": ONE | OTHER | third},
        initial={"x": 0.5, "u": 0.5, "a": 0.5},
    )  # fmt: skip
    assert cd.lyapunov_spectrum(three, at="y > 0", periods=points, transient=50).cd.outcome == "quasiperiodic"


def test_a_cycle_of_phases_comes_back_to_the_rounding_of_what_it_was():
    """At the strobe half of its states are zero but for rounding."""
    strobed = cd.HybridSystem(
        name="strobed", states="x y u v", parameters={"w": 2.0}, modes={"on": ONE | OTHER}, period="2*pi",
        initial={"x": 1.0, "u": 0.5},
    )  # fmt: skip
    assert cd.lyapunov_spectrum(strobed, periods=256, transient=50).cd.outcome == "periodic"


@pytest.mark.parametrize("ratio", [30 / 43, 309 / 500])
def test_no_cycle_of_many_turns_is_a_torus(ratio):
    """Its period is up to 3,142, an eighth of the record."""
    assert word(ratio, 24_576.0) in ("periodic", "undecided")


def coupled(ratio, coupling, duration):
    """Two oscillators of van der Pol, one of which runs in its own time."""
    system = cd.HybridSystem(
        name="coupled", states="x y u v", parameters={"r": ratio, "k": coupling},
        modes={"on": {
            "x": "y", "y": "(1 - x**2)*y/2 - x + k*(u - x)", "u": "r*v", "v": "r*((1 - u**2)*v/2 - u) + k*(x - u)"
        }},
        initial={"x": 1.0, "u": 0.7},
    )  # fmt: skip
    return cd.lyapunov_spectrum(system, duration=duration, transient=300).cd.outcome


@pytest.mark.parametrize("duration", [2_000.0, 8_000.0])
def test_oscillators_that_are_coupled_weakly_are_on_a_torus(duration):
    """It has so many harmonics that smooth averages do not agree, nor are single lines known well."""
    assert coupled(1.37, 0.05, duration) == "quasiperiodic"


@pytest.mark.parametrize("ratio", [5 / 4, 13 / 12, 1.414])
def test_oscillators_of_a_common_period_are_on_none(ratio):
    """Nothing attracts along it where they are not coupled; that of 1.414 is as long as 500 turns."""
    assert coupled(ratio, 0.0, 2_000.0) in ("periodic", "undecided")


def rotators(ratio, samples=1024, interval=7.77):
    t = np.arange(samples) * interval
    return np.stack([np.cos(t), np.sin(t), np.cos(ratio * t + 1), np.sin(ratio * t + 1)], axis=1)


def test_frequencies_have_a_common_measure_on_cycles_only():
    for ratio in (30 / 43, 171 / 233, 309 / 500, 617 / 1000):
        assert not incommensurate(rotators(ratio))
        assert not predicted(rotators(ratio), strobed=False)
    for ratio in (np.sqrt(2), np.sqrt(3), (np.sqrt(5) - 1) / 2):
        assert incommensurate(rotators(ratio))


def test_lines_of_weak_chaos_are_no_frequencies():
    """Phases that move about by a thousandth of a turn a sample have no lines."""
    rng = np.random.default_rng(2)
    angles = 7.77 * np.arange(2048)[:, np.newaxis] * [1, np.sqrt(2)]
    angles += 2e-3 * np.pi * np.cumsum(rng.normal(size=angles.shape), axis=0)
    points = np.concatenate([np.cos(angles), np.sin(angles)], axis=1)
    assert not incommensurate(points)
    assert not predicted(points, strobed=False)


def test_harmonics_of_one_cycle_are_related_however_many_there_are():
    t = np.arange(1500) * 0.377
    points = np.stack([np.exp(np.cos(t)), np.tanh(3 * np.sin(t)), np.cos(7 * t)], axis=1)
    assert not incommensurate(points)
    assert not predicted(points, strobed=False)
