"""A run that is taken up where another has ended has the events of an undivided one, at an event as well."""

import importlib

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

import chaosdrill as cd

writings = importlib.import_module("writings")

# of the others, a forced one, a system that knows no time is made; a clock in a state forgets that it has ticked
KINDS = [kind for kind, make in writings.KINDS.items() if kind != "flip_flop" and not make().forced]
METHODS = ("taylor", "dop853", "radau")


def events(run, system, begin=0.0):
    kinds, times = run["event_kind"].values, run["event_time"].values
    return [(system.transitions[int(k)].name, begin + float(t)) for k, t in zip(kinds, times, strict=True)]


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=6, phases=[Phase.explicit, Phase.reuse, Phase.generate])
@given(
    which=st.integers(0, 1000),
    ulps=st.sampled_from([0, -1, 1]),
    first=st.sampled_from(METHODS),
    then=st.sampled_from(METHODS),
    tolerance=st.sampled_from([1e-12, 1e-9]),
)
def test_a_run_taken_up_at_an_event(kind, which, ulps, first, then, tolerance):
    written = writings.KINDS[kind]()
    system, length = written.system(), written.duration
    whole = events(cd.trajectory(system, duration=length, samples=1, method=first, tolerance=tolerance), system)
    time = whole[which % len(whole)][1]
    cut = float(np.nextafter(time, time + ulps))
    begun = cd.trajectory(system, duration=cut, samples=1, method=first, tolerance=tolerance)
    end, mode = begun["states"].isel(time=-1), system.mode_names[int(begun["mode"][-1])]
    again = system.with_initial(end, mode=mode)
    rest = cd.trajectory(again, duration=length - cut, samples=1, method=then, tolerance=tolerance)
    assert cd.Outcome(int(rest["outcome"])).meaning == "ok"
    both = events(begun, system) + events(rest, system, cut)
    assert sorted(name for name, _ in both) == sorted(name for name, _ in whole)
    assert sorted(t for _, t in both) == pytest.approx(sorted(t for _, t in whole), abs=1e5 * tolerance)


@pytest.mark.parametrize("method", [*METHODS, "rk4"])
@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
def test_a_start_farther_beyond_a_wall_is_refused(method, unit):
    system = cd.HybridSystem(
        states="x v",
        parameters={"u": unit},
        modes={"free": {"x": "v", "v": "-x"}},
        transitions=[cd.Transition("hit", "free", "free", "x - u/2", 1, {"v": "-0.8*v"})],
        initial={"x": unit / 2 * (1 + 1e-7), "v": unit},
    )
    with pytest.warns(UserWarning, match="has no start"):
        run = cd.trajectory(system, duration=1.0, samples=1, method=method)
    assert cd.Outcome(int(run["outcome"])).meaning == "invalid_start"
