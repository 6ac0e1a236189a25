"""Many runs at a time are those runs one by one, whoever their neighbours are."""

import pickle
import threading

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill import systems
from chaosdrill.codegen import kernels_of
from chaosdrill.dataset import Outcome
from chaosdrill.engine.batch import Batch, alike
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.engine.structure import examine

ENDS = np.array([0, 5, 12, 20])
REGULAR = np.array([0.6, 0.63, 0.8, 0.48, 0.7])
"""Frequency ratios at which the drill is periodic, or escapes from rest (0.48)."""


@pytest.fixture(scope="module")
def drill():
    return cd.drill()


def batch(system, etas, method="taylor", window=8, starts=None, **more):
    structure = examine(system)
    frame, symmetries = structure.tangents(2)
    points = len(etas)
    starts = np.zeros((points, len(system.states))) if starts is None else starts
    modes = np.full(points, system.mode_names.index(system.initial["mode"]))
    numerics = Numerics(method, 1e-12)
    tangents = {"tangents": frame, "symmetries": symmetries, "deficient": structure.deficient}
    return Batch(system, {"eta": np.array(etas)}, starts, modes, numerics, window=window, **tangents, **more)


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau", "rk4"])
def test_points_are_runs_of_their_own(drill, method):
    together = batch(drill, REGULAR, method)
    together.run(40, ENDS)
    structure = examine(drill)
    frame, symmetries = structure.tangents(2)
    for p, eta in enumerate(REGULAR):
        system = drill.with_parameters(eta=float(eta))
        run = Run(
            system,
            system.forcing_period(),
            Numerics(method, 1e-12),
            tangents=frame,
            symmetries=symmetries,
            deficient=structure.deficient,
        )
        outcome, _ = run.advance(40)
        run.forget()
        if outcome == Outcome.OK:
            outcome, _ = run.advance(20)
        assert together.outcome[p] == outcome
        if outcome != Outcome.OK:
            continue
        np.testing.assert_allclose(together.x[p], run.x, rtol=0, atol=1e-8)
        np.testing.assert_allclose(together.integrals[p, -1], run.integrals(), rtol=1e-8)
        np.testing.assert_array_equal(together.counts[p], run.counts)
        expected = np.where(run.lost[:2] == 1, -np.inf, run.logs[:2])
        np.testing.assert_allclose(together.sums[p, -1], expected, rtol=1e-6, atol=1e-6)
        assert together.length[p] == pytest.approx(20 * run.period, rel=1e-15)


def results(b, p):
    return [a[p].tobytes() for a in (b.x, b.sums, b.window, b.counts, b.grazing, b.integrals, b.length, b.outcome)]


def test_neighbours_change_no_bit(drill):
    etas = np.linspace(0.42, 0.82, 11)
    whole = batch(drill, etas)
    whole.run(30, ENDS)
    for first in range(0, 11, 3):
        part = batch(drill, etas[first : first + 3])
        part.run(30, ENDS)
        for p in range(len(part.x)):
            assert results(part, p) == results(whole, first + p)
    backward = batch(drill, etas[::-1])
    backward.run(30, ENDS)
    assert results(backward, 3) == results(whole, 7)


def test_some_points_go_on_and_the_others_stay(drill):
    first, second = batch(drill, REGULAR[:3]), batch(drill, REGULAR[:3])
    first.run(30, ENDS)
    second.run(30, ENDS)
    second.proceed(np.array([1]), 7, np.array([0, 4, 9, 16]))
    assert results(first, 0) == results(second, 0)
    assert results(first, 2) == results(second, 2)
    long = batch(drill, REGULAR[:3])
    long.run(30 + 20 + 7, np.array([0, 4, 9, 16]))
    np.testing.assert_allclose(second.x[1], long.x[1], rtol=0, atol=1e-8)
    np.testing.assert_allclose(second.window[1], long.window[1], rtol=0, atol=1e-8)
    np.testing.assert_allclose(second.sums[1, -1], long.sums[1, -1], rtol=1e-5)


def test_the_window_ends_with_the_last_strobe(drill):
    b = batch(drill, REGULAR, window=30)
    b.run(30, ENDS)
    running = b.outcome == Outcome.OK
    np.testing.assert_array_equal(b.window[running, 19, :3], b.x[running])
    np.testing.assert_array_equal(b.window[running, 19, 3], b.mode[running])
    assert np.isnan(b.window[:, 20:]).all(), "there were twenty strobes"
    short = batch(drill, REGULAR, window=3)
    short.run(30, ENDS)
    np.testing.assert_array_equal(short.window, b.window[:, 17:20])


def test_a_window_before_events_holds_points_on_the_guard(drill):
    hits = {i for i, t in enumerate(drill.transitions) if t.kind == "impact"}
    b = batch(drill, [0.6, 0.8], window=200, section=hits)
    b.run(30, ENDS)
    for p in range(2):
        count = b.counts[p, sorted(hits)].sum()
        assert 10 < count < 200
        np.testing.assert_allclose(b.window[p, :count, 0], 1.0, rtol=0, atol=1e-12)
        assert np.isnan(b.window[p, count:]).all()


def test_a_run_that_ended_has_no_numbers(drill):
    b = batch(drill, REGULAR, starts=np.tile([-1.0, 2.0, 0.0], (5, 1)))
    b.run(100, ENDS)
    assert (b.outcome == Outcome.ESCAPED).all()
    for values in (b.sums, b.window, b.length):
        assert np.isnan(values).all()


def test_a_period_that_is_no_number_fails_alone(drill):
    b = batch(drill, [0.6, 0.0, -0.6, 0.8])
    b.run(3, ENDS)
    assert b.outcome.tolist() == [Outcome.OK, Outcome.FAILED, Outcome.FAILED, Outcome.OK]
    assert np.isnan(b.period[1:3]).all()


def test_a_period_that_does_not_follow_the_parameters_fails_alone():
    x, t, omega = sympy.symbols("x t omega", real=True)
    system = cd.HybridSystem(
        name="wrong",
        states=(x,),
        time=t,
        parameters={"omega": 2.0},
        modes={"only": {x: -x + sympy.cos(omega * t)}},
        period=sympy.pi,
    )
    b = Batch(system, {"omega": np.array([2.0, 2.5, 4.0])}, np.zeros((3, 1)), np.zeros(3, dtype=int), Numerics())
    b.run(1, np.array([0, 1]))
    assert b.outcome.tolist() == [Outcome.OK, Outcome.FAILED, Outcome.OK]


@pytest.mark.parametrize("method", ["taylor", "dop853"])
def test_a_clock_without_a_period_goes_on_from_part_to_part(method):
    """x' = a t - x from 0 is at a (t - 1 + exp(-t)), however time is divided, and taken up again."""
    system = cd.HybridSystem(name="ramp", states="x", time="t", parameters={"a": 1.0}, modes={"on": {"x": "a*t - x"}})
    a, begin = np.array([1.0, -3.0, 0.5]), (np.zeros((3, 1)), np.zeros(3, dtype=int), Numerics(method, 1e-12))
    exact = a * (12 - 1 + np.exp(-12.0))
    for parts in (1, 5, 48):
        runs = Batch(system, {"a": a}, *begin, unit=12.0 / parts, window=4)
        runs.run(parts // 2, np.array([0]))
        runs.proceed(np.arange(3), 0, np.array([0, parts - parts // 2]))
        np.testing.assert_allclose(runs.x[:, 0], exact, rtol=1e-10)
        np.testing.assert_array_equal(runs.window[:, min(parts - parts // 2, 4) - 1, 0], runs.x[:, 0])


def test_an_attractor_is_followed_along_a_parameter(drill):
    """At eta = 0.63 two cycles of period 4 coexist; the state that is taken over stays on its own."""
    there = batch(drill, [0.63, 0.48])
    there.run(600, ENDS)
    here = batch(drill, [0.63005, 0.8])
    here.continue_from(there)
    np.testing.assert_array_equal(here.x[0], there.x[0])
    assert here.mode[0] == there.mode[0]
    np.testing.assert_array_equal(here.x[1], 0.0, err_msg="a run that escaped leads nowhere")
    here.run(600, ENDS)
    np.testing.assert_allclose(here.window[0, -4:, :3], there.window[0, -4:, :3], rtol=0, atol=2e-3)


def test_a_held_contact_is_followed_to_where_it_is_held():
    """A ball that rests on a moving floor is at 0 with the floor's speed, amplitude * omega, at the strobe."""
    ball = systems.build("bouncing-ball")
    start, modes = np.array([[0.0, 0.3]]), np.array([ball.mode_names.index("contact")])
    there = Batch(ball, {"amplitude": np.array([0.3])}, start, modes, Numerics())
    there.run(2, ENDS)
    here = Batch(ball, {"amplitude": np.array([0.7])}, start, modes, Numerics(), window=2)
    here.continue_from(there)
    here.run(2, ENDS)
    np.testing.assert_allclose(here.window[0, :, :2], [[0.0, 0.7]] * 2, rtol=0, atol=1e-11)


def test_points_whose_exponents_are_whole_have_code_of_their_own():
    system = cd.drill(contact="compliant")
    groups = list(alike(system, {"n": np.array([1.0, 1.5, 2.0, 1.25, 1.0]), "eta": np.arange(5.0)}, 5))
    assert [g.tolist() for g in groups] == [[0, 4], [1, 3], [2]]
    assert [g.tolist() for g in alike(system, {"eta": np.arange(3.0)}, 3)] == [[0, 1, 2]]


def test_a_system_travels_without_its_code(drill):
    assert kernels_of(drill) is kernels_of(drill.with_parameters(eta=0.5))
    sent = pickle.loads(pickle.dumps(drill))
    a, b = batch(drill, [0.7]), batch(sent, [0.7])
    a.run(5, ENDS)
    b.run(5, ENDS)
    assert results(a, 0) == results(b, 0)


def test_a_gap_in_the_series_shortens_no_step_of_an_integral(drill):
    # sliding ever faster, the drill is nearly linear: late coefficients promise steps that the defect is asked about
    system = drill.with_parameters(eta=0.448).with_initial(y=-1.0, u=2.0)
    numerics = Numerics("taylor", 1e-12)
    run = Run(system, system.forcing_period(), numerics)
    run.advance(18)
    start = np.array([[system.initial[s] for s in system.state_names]])
    together = Batch(system, {}, start, np.array([system.mode_names.index("stick")]), numerics)
    # steps of 1e-10 would take for ever
    thread = threading.Thread(target=lambda: together.run(0, np.array([0, 18])), daemon=True)
    thread.start()
    thread.join(60)
    assert not thread.is_alive()
    assert together.integrals[0, -1, 0] == pytest.approx(run.integrals()[0], rel=1e-11)
    np.testing.assert_allclose(together.x[0], run.x, rtol=0, atol=1e-11)
