"""What seems to rest, or to repeat, and moves again: heteroclinic cycles, whose stays grow by a known factor."""

import numpy as np
import pytest

import chaosdrill as cd

RING = (("x", "y", "z"), ("y", "z", "x"), ("z", "x", "y"))
START = {"x": 0.6, "y": 0.3, "z": 0.2}
OPEN = {"transient", "undecided"}


def words(found):
    return {cd.Outcome(code).meaning for code in np.atleast_1d(found["outcome"].values).ravel()}


def ring(power):
    """Three competitors, of May and Leonard (1) or Guckenheimer and Holmes (2); states are in units of u."""
    field = {
        one: f"{one}*(1 - ({one}/u)**{power} - a*({other}/u)**{power} - b*({third}/u)**{power})"
        for one, other, third in RING
    }
    parameters = {"a": 0.8, "b": 1.3, "u": 1.0}
    return cd.HybridSystem(name="ring", states="x y z", parameters=parameters, modes={"on": field}, initial=START)


@pytest.fixture(scope="module", params=[1, 2])
def competitors(request):
    return ring(request.param)


def cases(rng, count):
    """Competition at which the cycle attracts, a + b > 2, units, and lengths of up to hundreds of stays."""
    for _ in range(count):
        a = rng.uniform(0.3, 0.95)
        yield (
            {"a": a, "b": 2 - a + 10 ** rng.uniform(-1.5, 0.3), "u": 10 ** rng.uniform(-9, 9)},
            10 ** rng.uniform(2, 3.3),
        )


def test_stays_grow_by_the_ratio_of_what_attracts_to_what_repels(competitors):
    """Turns of three stays are longer by the cube of (b - 1)/(1 - a), and by a constant (May and Leonard 1975)."""
    a, b = 0.6, 1.5
    found = cd.trajectory(competitors.with_parameters(a=a, b=b, u=1.0), duration=1000, samples=100_000)
    time, x = found["time"].values.ravel(), found["states"].sel(state="x").values.ravel()
    turns = np.diff(time[1:][(x[1:] > 0.5) & (x[:-1] <= 0.5)])
    longer = np.diff(turns)
    assert longer[-1] / longer[-2] == pytest.approx(((b - 1) / (1 - a)) ** 3, rel=1e-3)


def test_a_heteroclinic_cycle_is_no_attractor_of_another_kind(competitors):
    for given, duration in cases(np.random.default_rng(32), 12):
        start = {name: given["u"] * value for name, value in START.items()}
        system = competitors.with_parameters(**given).with_initial(**start)
        found = words(cd.lyapunov_spectrum(system, duration=duration))
        assert found <= OPEN, (given, duration)
