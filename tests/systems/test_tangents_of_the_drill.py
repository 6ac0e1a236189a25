"""Tangents through whatever happens to a drill with two-sided friction, against finite differences of its flow."""

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run

NUMERICS = Numerics(tolerance=1e-15)
STEP = 1e-5
MET = {
    "hunt-crossley": {"hit", "strong-hit", "turning-hit", "hit-back"},
    "hunt-crossley-timed": {"hit", "strong-hit", "hit-back", "rebound", "rebound-back"},
    "compliant": {
        "touch-slip",
        "touch-slip-back",
        "touch-stick",
        "part-slip",
        "release-contact",
        "turn-forward-contact",
    },
}
ROCK = {"release-back", "stick", "stick-from-back", "turn-back"}


def flow(system, mode, x, tangents=None):
    start = system.with_initial(mode=mode, **dict(zip(system.state_names, x, strict=True)))
    run = Run(start, 3.0, NUMERICS, tangents=tangents, orthonormalise=False)
    return run if run.advance(1)[0] == cd.Outcome.OK else None


def difference(system, mode, x, run):
    """Derivatives of the flow by y, u and w, where all neighbours meet the same events."""
    columns = []
    for shift in STEP * np.eye(len(x))[:3]:
        ahead, behind = flow(system, mode, x + shift), flow(system, mode, x - shift)
        if ahead is None or behind is None or np.any(ahead.counts + behind.counts != 2 * run.counts):
            return None
        columns.append((ahead.x - behind.x) / (2 * STEP))
    return np.array(columns)


@pytest.mark.parametrize("contact", MET)
def test_tangents_are_the_derivative_of_the_flow(contact):
    system = cd.drill(friction="stribeck-two-sided", contact=contact, r=0.3, a=1.3, b=0.2, k=1e4, eps=1.5)
    rng = np.random.default_rng(3)
    errors, met = [], set()
    for way in (1, -1) * 75:
        x = np.zeros(len(system.states))
        x[:3] = rng.normal(size=3)
        x[0], x[2] = min(x[0], 0.29), way * abs(x[2])
        mode = "slip" if way > 0 else "slip-back"
        run = flow(system, mode, x, np.eye(len(x)))
        if run is None or run.grazing.min() < 0.1 or (expected := difference(system, mode, x, run)) is None:
            continue
        errors.append(np.abs(expected - run.vectors[:3]).max() / max(1.0, np.abs(run.vectors).max()))
        met |= {t.name for t, count in zip(system.transitions, run.counts, strict=True) if count}
        if len(errors) >= 10 and met >= MET[contact] | ROCK:
            break
    assert met >= MET[contact] | ROCK
    assert np.median(errors) < 1e-9
    # where events come close to grazing the flow is curved, and differences are less
    assert max(errors) < 1e-5
