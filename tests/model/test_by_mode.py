"""Integrands and conditions that differ by mode, against motions in closed form, in Python, scenes and archives.

A sawtooth rises from 0 at the rate 1 and falls from its top at the rate -2.
"""

import pytest
import sympy

import chaosdrill as cd
from chaosdrill.codegen import kernels_of
from chaosdrill.model.definition import write_definition
from chaosdrill.workflow import verify

LENGTH = {"duration": 3.0, "samples": 4}


def sawtooth(condition=None, **changes):
    """It turns at 1, and at 2 where a condition holds back at 1."""
    given = {
        "states": "x",
        "parameters": {"k": 3.0},
        "modes": {"up": {"x": 1}, "down": {"x": -2}},
        "transitions": [
            cd.Transition("turn", "up", "down", "x - 1", +1, condition=condition),
            cd.Transition("last", "up", "down", "x - 2", +1),
            cd.Transition("back", "down", "up", "x", -1),
        ],
        "quadratures": {"work": {"up": "k*x", "down": 1}, "path": "x**2"},
    }
    return cd.HybridSystem(**{**given, **changes})


@pytest.mark.parametrize("method", ["taylor", "dop853", "rk4"])
def test_an_integrand_by_mode(method):
    """A round takes 1.5: k/2 + 1/2 on the way up and down, and x**2 gives 1/3 + 1/6."""
    ds = cd.trajectory(sawtooth(), **LENGTH, method=method)
    assert ds["time"].values[-1] == 3.0
    assert ds["work"].values[-1] == pytest.approx(2 * (3.0 / 2 + 1 / 2), rel=1e-9)
    assert ds["path"].values[-1] == pytest.approx(2 * (1 / 3 + 1 / 6), rel=1e-9)
    assert ds["work"].values[1] == pytest.approx(3.0 * 0.75**2 / 2, rel=1e-9)


def test_the_same_integrand_in_all_modes_is_one():
    one, other = sawtooth(quadratures={"work": "x"}), sawtooth(quadratures={"work": {"down": "x", "up": "x"}})
    assert write_definition(one) == write_definition(other)
    assert write_definition(one)["quadratures"] == {"work": "x"}
    assert kernels_of(one) is kernels_of(other)


def ramp(condition):
    """x rises slowly and fast, and is thrown back to 0 from both; at 2 it changes between the two."""
    return cd.HybridSystem(
        states="x",
        parameters={"k": 3.0},
        modes={"slow": {"x": 1}, "fast": {"x": 2}},
        transitions=[
            cd.Transition("throw", ("slow", "fast"), "slow", "x - 1", +1, {"x": 0}, condition),
            cd.Transition("speed", "slow", "fast", "x - 2", +1),
            cd.Transition("brake", "fast", "slow", "x - 3", +1, {"x": 0}),
        ],
    )


@pytest.mark.parametrize(
    ("condition", "throws", "end"),
    [
        (None, 2, 0.75),
        ("k > 4", 0, 0.25),
        ({"slow": "k > 4", "fast": "True"}, 0, 0.25),
        ({"slow": "k > 2", "fast": "k > 4"}, 2, 0.75),
        ({"slow": sympy.false, "fast": "k > 2"}, 0, 0.25),
    ],
)
def test_a_condition_by_mode(condition, throws, end):
    """Until 2.75: thrown at 1 and 2; or fast from 2, and thrown to 0 at 2.5."""
    ds = cd.trajectory(ramp(condition), duration=2.75, samples=2)
    assert (ds.cd.words("event_kind") == "throw").sum() == throws
    assert ds["states"].values[-1, 0] == pytest.approx(end, abs=1e-12)


def test_a_condition_in_the_mode_that_is_fast():
    """From 0.5 in fast: x meets 1 at 0.25, goes on to 3 at 1.25, then slowly to 1 at 2.25, where it is thrown."""
    fast = ramp({"slow": "True", "fast": "k > 4"}).with_initial(mode="fast", x=0.5)
    assert cd.trajectory(fast, duration=2.5, samples=2)["states"].values[-1, 0] == pytest.approx(0.25, abs=1e-12)
    assert cd.trajectory(fast.with_parameters(k=5.0), duration=0.5, samples=2)["states"].values[-1, 0] == pytest.approx(
        0.25, abs=1e-12
    )


def both():
    turn = cd.Transition("turn", ("up", "rush"), "down", "x - 1", +1, {}, {"up": "k > 2", "rush": "x > k and k > 2"})
    modes = {"up": {"x": 1}, "rush": {"x": 3}, "down": {"x": -2}}
    work = {"up": "k*x", "rush": "0", "down": "1"}
    transitions = [turn, cd.Transition("back", "down", "up", "x", -1)]
    return sawtooth(modes=modes, transitions=transitions, quadratures={"work": work, "path": "x**2"})


def test_through_a_scene_and_an_archive(tmp_path):
    system = both()
    path = cd.save_scene(tmp_path / "own.toml", system, {"motion": {"kind": "trajectory", **LENGTH}})
    again = cd.load_scene(path, {"system.initial.mode": "rush"}).system
    assert (again.transitions, again.quadratures, again.modes) == (system.transitions, system.quadratures, system.modes)
    assert write_definition(again) == write_definition(system)
    told = cd.check(cd.load_scene(path, {"system.initial.mode": "rush"}))
    assert told["quadratures"] == {"work": {"up": "k*x", "rush": "0", "down": "1"}, "path": "x**2"}
    assert told["events"]["turn"]["condition"] == {"up": "k > 2", "rush": "(k > 2) & (x > k)"}
    archive = cd.save(cd.trajectory(system, **LENGTH), tmp_path / "own.nc")
    assert verify(archive).equal
    cd.report(archive, tmp_path / "own.html")
    page = (tmp_path / "own.html").read_text()
    assert "Integrals along the way, mode rush" in page
    assert "if, in rush" in page


@pytest.mark.parametrize(
    ("quadratures", "told"),
    [
        ({"work": {"up": "x"}}, "quadratures.work: gives nothing for mode 'down'; write 0 if nothing is added in it"),
        ({"work": {"up": "x", "down": 0, "dwn": 1}}, "quadratures.work.dwn: unknown mode; did you mean 'down'?"),
        ({"work": {"up": "x", "down": "y"}}, "quadratures.work.down: unknown name 'y'"),
        ({"work": {"up": "x", "down": "Abs(x)"}}, "quadratures.work.down: Abs(x) has no Taylor series"),
    ],
)
def test_faults_by_mode(quadratures, told):
    with pytest.raises(cd.ModelError) as caught:
        sawtooth(quadratures=quadratures)
    assert told in str(caught.value)


def test_an_outcome_is_hidden_only_where_the_one_before_has_no_condition_in_any_of_its_modes():
    def two(condition):
        first = cd.Transition("first", ("up", "down"), "up", "x - 1", +1, {"x": 0}, condition)
        return sawtooth(transitions=[first, cd.Transition("second", ("up", "down"), "down", "x - 1", +1)])

    assert len(two({"up": "True", "down": "k > 2"}).transitions) == 2
    with pytest.raises(cd.ModelError, match=r"transitions.second: 'second' is never taken, since 'first'"):
        two(None)


def test_a_drift_in_one_mode_is_no_period():
    with pytest.raises(
        cd.ModelError, match=r"period: t\*x does not repeat after the declared period 2; correct the period"
    ):
        sawtooth(period=2, quadratures={"work": {"up": "x", "down": "t*x"}})
