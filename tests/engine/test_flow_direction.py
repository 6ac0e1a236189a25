"""Xi F- = F+ at every event of every system, by the engine's own saltation, at random states on the guards.

Systems are augmented with time, where the identity is exact; states are drawn by Hypothesis and put on the guard.
"""

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from chaosdrill import systems
from chaosdrill.engine.events import saltate, saltation_jump

EVENTS = [
    pytest.param(name, t.name, source, id=f"{name}: {t.name} from {source}")
    for name in sorted(systems.REGISTRY)
    for t in systems.build(name).transitions
    for source in t.source
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


@pytest.mark.parametrize(("name", "event", "source"), EVENTS)
@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.filter_too_much])
@given(seed=st.integers(0, 2**32 - 1), size=st.sampled_from([1e-3, 0.1, 1.0, 3.0]))
def test_the_flow_goes_over_into_the_flow(augmented, name, event, source, seed, size):
    system = augmented(name)
    kernels = system.kernels
    field, _, guard, choose, reset = kernels.functions[3:]
    names = [t.name for t in system.transitions]
    index, mode = names.index(event), system.mode_names.index(source)
    j = next(k for k, e in enumerate(kernels.events[mode]) if index in e.outcomes)
    n, q = len(system.states), len(system.quadratures)
    c = kernels.constants(system.parameters)
    x = np.random.default_rng(seed).normal(size=n) * size
    gradient = np.empty(n + 1)
    assume(put_on_guard(guard, mode, j, c, x, gradient))
    before, after, image = np.empty(n + q), np.empty(n + q), np.empty(n)
    field(mode, 0.0, c, x, before)
    guard(mode, j, 0.0, c, x, gradient)
    speed = gradient[:n] @ before[:n] + gradient[n]
    assume(abs(speed) > 1e-6)
    jacobian = np.empty((n, n + 1))
    reset(index, 0.0, c, x, image, jacobian)
    assume(np.isfinite(image).all())
    field(system.mode_names.index(system.transitions[index].target), 0.0, c, image, after)
    jump = np.empty(n)
    saltation_jump(jacobian, before, after, jump)
    vectors = before[np.newaxis, :n].copy()
    largest = saltate(vectors, 1, jacobian, gradient, speed, jump, np.empty(n))
    # the jump carries the round-off of everything that was added up for it
    scale = max(np.abs(after[:n]).max(), (np.abs(jacobian[:, :n]) @ np.abs(before[:n])).max(), 1e-3)
    np.testing.assert_allclose(vectors[0], after[:n], rtol=0, atol=1e-10 * scale)
    assert largest == np.abs(vectors[0]).max()
    assert choose(mode, j, 0.0, c, x, 0.0, np.empty(1)) in (*kernels.events[mode][j].outcomes, -1)
