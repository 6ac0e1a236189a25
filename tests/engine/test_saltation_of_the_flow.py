"""Tangents across each kind of event of each system, against finite differences of the flow.

Random starts are kept if, within a short time, exactly one event happens and it is the one asked for; the differences
share the trajectory with the tangents, but nothing of the variational equation or of the saltation.
"""

import numpy as np
import pytest

from chaosdrill import systems
from chaosdrill.codegen import kernels_of
from chaosdrill.dataset import Outcome
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run

PROBED = (
    *("percussive-drill", "percussive-drill-5d", "impact-oscillator", "bouncing-ball", "belt-stick-slip", "den-hartog"),
    *("rimless-wheel", "chua", "tilted-switch", "saddle-reset", "andronov-clock", "izhikevich", "compass-gait"),
)
"""Systems whose events random states of unit size lead to; all others have whole runs among the known answers."""
EVENTS = [
    pytest.param(name, t.name, source, id=f"{name}: {t.name} from {source}")
    for name in PROBED
    for t in systems.build(name).transitions
    for source in t.source
]
NUMERICS = Numerics(tolerance=1e-15)
LENGTH = 0.1
CHANGES = {
    ("bouncing-ball", "rest"): {"e": 0.0},
    ("bouncing-ball", "lift-off"): {"amplitude": 1.3},
    ("percussive-drill", "hold-stick"): {"r": 0.3, "k": 1e-3},
    ("percussive-drill", "hold-slip"): {"r": 0.3, "k": 1e-3},
    ("percussive-drill", "part-stick"): {"r": 0.7},
    ("percussive-drill", "part-slip"): {"r": 0.7},
    ("percussive-drill", "release-held"): {"r": 0.3, "a": 0.5},
    ("percussive-drill", "stick-held"): {"r": 0.3},
}
"""Parameters at which an event happens to states that differ by a finite step."""
SPEED = 0.05
"""Smallest normal speed that finite differences can do with."""


@pytest.fixture(scope="module")
def augmented():
    known = {}

    def get(name, event):
        if name not in known:
            known[name] = systems.build(name).augmented(time=True)
        changes = CHANGES.get((name, event), {})
        # at a stop of 1 friction gives way before every hit, and a stiff contact holds only the slowest
        if name.startswith("percussive") and event.endswith("hit"):
            changes = {"r": 0.5, "k": 4.0}
        return known[name].with_parameters(**changes)

    return get


def moved(system, mode, x, length, tangents=None):
    """State, tangents and the one event of a run, None if it is another number of events."""
    start = system.with_initial(mode=mode, **dict(zip(system.state_names, x, strict=True)))
    run = Run(start, length, NUMERICS, tangents=tangents, orthonormalise=False)
    outcome, _ = run.advance(1)
    if outcome != Outcome.OK or run.counts.sum() != 1:
        return None
    return run.x, run.vectors, int(np.argmax(run.counts)), run.grazing.min()


def held(system, source):
    """States that a mode holds: they have no freedom there, so no tangent."""
    names = ("y", "u", "w") if source.endswith("-held") else ("w", "x4", "v")
    return [i for i, s in enumerate(system.states) if system.modes[source][s] == 0 and s.name in names]


def candidates(system, source, event):
    """Random states near the guard, on the side from which it is reached."""
    rng = np.random.default_rng(5)
    kernels = kernels_of(system)
    mode = system.mode_names.index(source)
    index = [t.name for t in system.transitions].index(event)
    j = next(k for k, e in enumerate(kernels.events[mode]) if index in e.outcomes)
    c, n = kernels.constants(system.parameters), len(system.states)
    gradient, rate = np.empty(n + 1), np.empty(n + len(system.quadratures))
    for _ in range(4000):
        x = rng.normal(size=n) * 10.0 ** rng.uniform(-3.5, 0.3)
        for i in held(system, source):
            x[i] = system.parameters.get("belt", 0.0)
        for _ in range(30):
            value = kernels.functions[5](mode, j, 0.0, c, x, gradient)
            x -= value * gradient[:n] / (gradient[:n] @ gradient[:n])
        kernels.functions[3](mode, 0.0, c, x, rate)
        yield x - 0.05 * rate[:n]


@pytest.mark.parametrize(("name", "event", "source"), EVENTS)
def test_tangents_are_the_derivative_of_the_flow(augmented, name, event, source):
    system = augmented(name, event)
    index = [t.name for t in system.transitions].index(event)
    n = len(system.states)
    checked = 0
    for x in candidates(system, source, event):
        result = moved(system, source, x, LENGTH, np.eye(n))
        if result is None or result[2] != index or result[3] < SPEED or not np.abs(x).max() < 20:
            continue
        columns = []
        free = [j for j in range(n) if j not in held(system, source)]
        for j in free:
            found = [moved(system, source, x + s * h * np.eye(n)[j], LENGTH) for h in (2e-4, 1e-4) for s in (1, -1)]
            if any(f is None or f[2] != index for f in found):
                break
            coarse, fine = (found[0][0] - found[1][0]) / 4e-4, (found[2][0] - found[3][0]) / 2e-4
            columns.append((4 * fine - coarse) / 3)
        if len(columns) < len(free):
            continue
        expected, tangents = np.array(columns), result[1][free]
        scale = max(1.0, np.abs(expected).max())
        np.testing.assert_allclose(tangents, expected, rtol=0, atol=2e-7 * scale)
        assert not np.any(result[1][held(system, source)])
        checked += 1
        if checked == 3:
            return
    assert checked > 0, "no start leads through this event alone"
