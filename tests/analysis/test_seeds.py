"""Random states are those of their seed, and what is followed along a sweep shows hysteresis."""

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.analysis.seeds import make_seeds

FOLD = 2 / np.sqrt(27)
SHORT = {"transient": 60, "periods": 32, "max_period": 8}


def test_hysteresis_between_the_folds(bistable, equilibria):
    """Forward the lower equilibrium is left at the upper fold, backward the upper one at the lower fold."""
    a = np.array([-0.6, -0.3845, -0.2, 0.0, 0.2, 0.3845, 0.3855, 0.6])
    found = cd.bifurcation_diagram(bistable, {"a": a}, follow="both", **SHORT)
    assert found["seed"].values.tolist() == ["forward", "backward"]
    x = found["section"].values[:, :, -1, 0]
    for k, value in enumerate(a):
        low, high = equilibria(value)
        assert x[k, 0] == pytest.approx(low if value < FOLD else high, abs=1e-6)
        assert x[k, 1] == pytest.approx(high if value > -FOLD else low, abs=1e-6)


def test_a_followed_state_leaves_a_cycle_that_has_doubled(logistic):
    """1e-4 behind a doubling the state of the neighbour stands beside the old cycle and would stay for 1e5 periods."""
    first, second = 3.0, 1 + np.sqrt(6)
    off = np.array([-1e-3, -1e-4, 1e-4, 3e-4, 1e-3])
    r = np.concatenate([first + off, second + off])
    found = cd.bifurcation_diagram(logistic, {"r": r}, transient=200, periods=256, follow="both")
    expected = np.repeat([1, 2, 2, 4], [2, 3, 2, 3])
    np.testing.assert_array_equal(found["period"].values, np.stack([expected, expected], axis=1))
    assert (found["outcome"].values == cd.Outcome.PERIODIC).all()


def test_a_seed_beside_an_unstable_cycle_leaves_it(logistic):
    r = 3.0003
    seeds = [{"x": 1 - 1 / r + off} for off in (1e-7, -1e-6, 1e-4)]
    found = cd.bifurcation_diagram(logistic, {"r": [r]}, transient=100, periods=128, seeds=seeds)
    np.testing.assert_array_equal(found["period"].values, [[2, 2, 2]])


def test_a_single_direction_is_one_seed(bistable):
    forward = cd.bifurcation_diagram(bistable, {"a": [0.5, 0.0]}, follow="forward", **SHORT)
    backward = cd.bifurcation_diagram(bistable, {"a": [0.0, 0.5]}, follow="backward", **SHORT)
    np.testing.assert_array_equal(forward["section"].values[1, 0, -1], backward["section"].values[0, 0, -1])
    assert forward["section"].values[1, 0, -1, 0] == pytest.approx(1.0, abs=1e-9)


def test_all_kinds_of_seeds_stand_side_by_side(bistable):
    found = cd.bifurcation_diagram(
        bistable,
        {"a": [-0.1, 0.1]},
        seeds=[{"x": 1.0}],
        random={"count": 2, "seed": 3, "x": (-2, 2)},
        follow="both",
        **SHORT,
    )
    names = ["fixed 1", "random 1", "random 2", "forward", "backward"]
    assert found["seed"].values.tolist() == names
    start = found["initial_state"].values
    np.testing.assert_array_equal(start[0], [1.0, 0.1])
    np.testing.assert_array_equal(start[3:], [[-1.0, 0.1]] * 2)
    ends = found["section"].values[:, :3, -1, 0]
    np.testing.assert_array_equal(np.sign(ends), np.sign(start[:3, 0]) * np.ones((2, 3)))


def test_progress_runs_over_all_seeds(bistable):
    seen = []
    cd.bifurcation_diagram(
        bistable, {"a": [0.0, 0.1]}, seeds=[{}], follow="both", progress=lambda *call: seen.append(call), **SHORT
    )
    assert {total for _, total, _ in seen} == {6}
    assert [sum(outcomes.values()) for _, _, outcomes in seen] == [done for done, _, _ in seen]
    assert seen[-1][0] == 6


def test_random_states_depend_on_seed_and_place_alone(bistable):
    box = {"x": (-2.0, 1.0), "y": (5.0, 6.0)}
    few = make_seeds(bistable, None, {"count": 3, "seed": 7, **box}).starts
    many = make_seeds(bistable, None, {"count": 500, "seed": 7, **box}).starts
    other = make_seeds(bistable, None, {"count": 3, "seed": 8, **box}).starts
    np.testing.assert_array_equal(few, many[:3])
    assert (few != other).all()
    assert ((many >= [-2.0, 5.0]) & (many < [1.0, 6.0])).all()
    # the mean of 500 states drawn evenly lies within four standard errors of the middle
    np.testing.assert_allclose(many.mean(axis=0), [-0.5, 5.5], atol=4 * 3 / np.sqrt(12 * 500))
    assert abs(np.corrcoef(many.T)[0, 1]) < 4 / np.sqrt(500)


def test_the_box_of_a_state_leaves_the_others_alone(bistable):
    x_alone = make_seeds(bistable, None, {"count": 4, "seed": 7, "x": (0, 1)}).starts
    both = make_seeds(bistable, None, {"count": 4, "seed": 7, "x": (0, 1), "y": (0, 1)}).starts
    np.testing.assert_array_equal(x_alone[:, 0], both[:, 0])
    np.testing.assert_array_equal(x_alone[:, 1], 0.1)


def test_the_order_of_states_does_not_choose_what_is_drawn():
    """The same box in a system whose states were declared in another order, beside others, gave other starts."""
    box = {"count": 3, "seed": 7, "x": (-2.0, 1.0), "y": (5.0, 6.0)}
    drawn = []
    for names in ("x y", "y x", "z y w x"):
        system = cd.Map(names, {}, {name: f"{name}/2" for name in names.split()})
        starts = dict(zip(system.state_names, make_seeds(system, None, box).starts.T, strict=True))
        drawn.append((starts["x"], starts["y"]))
    np.testing.assert_array_equal(drawn[0], drawn[1])
    np.testing.assert_array_equal(drawn[0], drawn[2])


@pytest.mark.parametrize(
    ("random", "words"),
    [
        (3, "random is 3; expected a table"),
        ({"seed": 1, "x": (0, 1)}, "random.count: missing"),
        ({"count": 2, "x": (0, 1)}, "random.seed: missing"),
        ({"count": 0, "seed": 1, "x": (0, 1)}, "random.count is 0; must be at least 1"),
        ({"count": 20_000, "seed": 1, "x": (0, 1)}, "random.count is 20000; must be at most 10000"),
        ({"count": 2, "seed": -1, "x": (0, 1)}, "random.seed is -1; must be at least 0"),
        ({"count": 2, "seed": 1}, "random: names no state"),
        ({"count": 2, "seed": 1, "z": (0, 1)}, "random.z: unknown state; known here: x, y"),
        ({"count": 2, "seed": 1, "x": (1, 0)}, "random.x is [1, 0]; must increase: [low, high]"),
        ({"count": 2, "seed": 1, "x": 3}, "random.x is 3; expected a list"),
        ({"count": 2, "seed": 1, "x": (0, 1), "mode": "none"}, "initial mode 'none'"),
    ],
)
def test_random_seeds_that_cannot_be_drawn(bistable, random, words):
    with pytest.raises(cd.SettingsError) as caught:
        cd.bifurcation_diagram(bistable, {"a": [0.0]}, random=random, **SHORT)
    assert words in str(caught.value)


def test_a_direction_that_is_none(bistable):
    with pytest.raises(cd.SettingsError, match="follow is 'up'; expected one of"):
        cd.bifurcation_diagram(bistable, {"a": [0.0]}, follow="up", **SHORT)
