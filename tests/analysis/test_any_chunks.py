"""The numbers of a point do not depend on the chunk that it is in, to the bit, nor on the process that ran it."""

import pickle

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.analysis.grids import sweeps

IMPACTS = cd.build("impact-oscillator")
DRILL = cd.drill(
    friction="stribeck",
    contact="hunt-crossley",
    xi=0.06,
    eta=0.6,
    a=0.25,
    b=0.7,
    r=1,
    mu=0.6,
    g=3,
    lam=0.6,
    phi=np.pi / 2,
)
BRIEF = {"transient": 20, "periods": 40, "max_period": 16, "max_extension": 2}


def diagram(**keywords):
    cd.bifurcation_diagram(IMPACTS, {"omega": np.linspace(2.4, 2.8, 11)}, **BRIEF, **keywords)


def drill_diagram():
    cd.bifurcation_diagram(DRILL, {"eta": np.linspace(0.42, 0.66, 11)}, **BRIEF, tolerance=1e-10)


def noisy_diagram():
    system = IMPACTS.with_noise({"e": cd.Uniform(0.7, 0.9)}, at="impact", seed=1)
    cd.bifurcation_diagram(system, {"omega": np.linspace(2.4, 2.8, 11)}, **BRIEF)


def chart():
    sweep = {"omega": np.linspace(2.5, 2.8, 4), "e": np.linspace(0.5, 0.9, 3)}
    cd.parameter_chart(IMPACTS, sweep, **BRIEF, exponents=1, random={"count": 2, "seed": 3, "x": (-0.5, 0.2)})


def drill_chart():
    sweep = {"eta": np.linspace(0.42, 0.66, 4), "b": np.linspace(0.3, 0.9, 3)}
    cd.parameter_chart(DRILL, sweep, **BRIEF, exponents=2, tolerance=1e-10)


def basins():
    cd.basins(IMPACTS, {"x": np.linspace(-1, 0.25, 4), "v": np.linspace(-1, 1, 3)}, **BRIEF)


CASES = {
    "diagram": diagram,
    "diagram at an event": lambda: diagram(at="impact"),
    "diagram of several seeds": lambda: diagram(seeds=[{"x": 0.0}, {"x": 0.1, "v": -0.2}]),
    "diagram without exponents": lambda: diagram(exponents=0),
    "diagram of the drill": drill_diagram,
    "chart": chart,
    "chart of the drill": drill_chart,
    "diagram under noise": noisy_diagram,
    "basins": basins,
}


class CaughtError(Exception):
    """Carries a task."""


@pytest.fixture
def task_of(monkeypatch):
    """Function that calls an analysis and returns the task that it would have run."""

    def catch(task, **_):
        raise CaughtError(task)

    monkeypatch.setattr(sweeps, "execute", catch)

    def call(analysis):
        with pytest.raises(CaughtError) as caught:
            analysis()
        return caught.value.args[0]

    return call


def in_chunks(task, sizes):
    parts, first = [], 0
    while first < task.units:
        count = min(sizes[len(parts) % len(sizes)], task.units - first)
        parts.append(task.run(first, count))
        first += count
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


@pytest.mark.parametrize("case", CASES)
def test_chunks_do_not_matter(task_of, case):
    task = task_of(CASES[case])
    whole = task.run(0, task.units)
    for sizes, runs in (((1,), task), ((2, 7, 3), pickle.loads(pickle.dumps(task)))):
        parts = in_chunks(runs, sizes)
        different = [name for name in whole if parts[name].tobytes() != whole[name].tobytes()]
        assert different == []


@pytest.mark.parametrize("case", CASES)
def test_arrays_are_those_declared(task_of, case):
    task = task_of(CASES[case])
    found = task.run(3, 2)
    assert {name: (a.dtype, a.shape) for name, a in found.items()} == {
        name: (np.dtype(dtype), (2, *shape)) for name, (dtype, shape) in task.columns().items()
    }
    assert sum(task.counts(found).values()) == 2 * task.points_per_unit
