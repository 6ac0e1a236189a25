"""Xi F- = F+ at every event of every system, by the engine's own saltation, at random states on the guards.

Systems are augmented with time, where the identity is exact; states are drawn by Hypothesis and put on the guard.
"""

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from numba import float64, int64, void

from chaosdrill import systems
from chaosdrill.codegen import kernels_of
from chaosdrill.codegen.events import mode_events
from chaosdrill.codegen.signatures import event_places, matrix, vector
from chaosdrill.engine import events
from chaosdrill.engine.jit import compiled


@compiled(float64(vector, int64))
def normal_speed(event, n):
    return events.normal_speed(event, n)


@compiled(void(vector, vector))
def saltation_jump(event, out):
    events.saltation_jump(event, out)


@compiled(float64(matrix, int64, vector, float64, vector, vector))
def saltate(vectors, live, event, speed, jump, image):
    return events.saltate(vectors, live, event, speed, jump, image)


GUARDS = [
    pytest.param(name, mode, j, id=f"{name}: {mode}, {event.guard}")
    for name in sorted(systems.REGISTRY)
    for mode in systems.build(name).modes
    for j, event in enumerate(mode_events(systems.build(name), mode))
]

CHANGES = {"bouncing-ball": {"amplitude": 1.3}, "percussive-drill": {"r": 0.5, "a": 0.5}}
"""Parameters at which every event of a system happens."""


@pytest.fixture(scope="module")
def augmented():
    known = {}

    def get(name):
        if name not in known:
            known[name] = systems.build(name, CHANGES.get(name)).augmented(time=True)
        return known[name]

    return get


def put_on_guard(guard, mode, j, c, x, gradient):
    for _ in range(60):
        value = guard(mode, j, 0.0, c, x, gradient)
        square = gradient[:-1] @ gradient[:-1]
        if not np.isfinite(value) or square == 0:
            return False
        if abs(value) <= 1e-15 * (1 + np.abs(x).max()):
            return True
        x -= value * gradient[:-1] / square
    return abs(value) < 1e-13


@pytest.mark.parametrize(("name", "mode", "j"), GUARDS)
@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.filter_too_much])
@given(seed=st.integers(0, 2**32 - 1), size=st.sampled_from([1e-3, 0.1, 1.0, 3.0]))
def test_the_flow_goes_over_into_the_flow(augmented, name, mode, j, seed, size):
    system = augmented(name)
    kernels = kernels_of(system)
    guard, transit = kernels.functions[5], kernels.functions[7]
    mode = system.mode_names.index(mode)
    n = len(system.states)
    places = event_places(n)
    c = kernels.constants(system.parameters)
    x = np.random.default_rng(seed).normal(size=n) * size
    assume(put_on_guard(guard, mode, j, c, x, np.empty(n + 1)))
    event = np.empty(places.size)
    taken = transit(mode, j, 0.0, c, x, 1, np.ones(n), 0.0, event)
    assume(taken >= 0)
    assert taken in kernels.events[mode][j].outcomes
    assume(not system.transitions[taken].marks_only())
    speed = normal_speed(event, n)
    assume(abs(speed) > 1e-6)
    assume(np.isfinite(event).all())
    jump = np.empty(n)
    saltation_jump(event, jump)
    before = event[places.before : places.after]
    after = event[places.after : places.image]
    vectors = before[np.newaxis].copy()
    largest = saltate(vectors, 1, event, speed, jump, np.empty(n))
    slopes = event[places.jacobian :].reshape(n, n + 1)[:, :n]
    # the jump carries the round-off of everything that was added up for it
    scale = max(np.abs(after).max(), (np.abs(slopes) @ np.abs(before)).max(), 1e-3)
    np.testing.assert_allclose(vectors[0], after, rtol=0, atol=1e-10 * scale)
    assert largest == np.abs(vectors[0]).max()
