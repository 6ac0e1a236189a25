"""Two guards in one instant: the derivative of each order, its cone and its multipliers."""

import numpy as np
import pytest
from support import closed_derivatives as closed

import chaosdrill as cd


@pytest.fixture(scope="module")
def corner():
    """Four fields of the plane, one in each quadrant; the first and the last are the same."""
    rates = {"00": (1, 1), "10": (1, 2), "01": (2, 1), "11": (1, 1)}
    ways = [("x first", "00", "10", "x"), ("y first", "00", "01", "y"), ("y then", "10", "11", "y"),
            ("x then", "01", "11", "x")]  # fmt: skip
    return cd.HybridSystem(
        name="corner", states="x y", modes={m: dict(zip("xy", v, strict=True)) for m, v in rates.items()},
        transitions=[cd.Transition(name, a, b, guard, direction=1) for name, a, b, guard in ways],
        initial={"x": -1.0, "y": -1.0},
    )  # fmt: skip


def test_two_orders_have_the_matrices_of_the_closed_form(corner):
    ds = cd.event_orders(corner, {"x": 0.0, "y": 0.0})
    assert ds.attrs["continuous"] == 1
    assert ds["event"].values.tolist() == [["x first", "y then"], ["y first", "x then"]]
    np.testing.assert_array_equal(ds["declared"], [True, False])
    np.testing.assert_allclose(ds["matrix"], [[[1, 0], [0.5, 0.5]], [[0.5, 0.5], [0, 1]]], atol=1e-15)
    # x comes first where it is ahead
    np.testing.assert_allclose(ds["cone"], [[[1, -1]], [[-1, 1]]], atol=1e-15)


@pytest.mark.parametrize("deviation", [(0.1, -0.2), (-0.15, 0.05), (0.3, 0.1)])
def test_a_run_beside_goes_as_its_order_says(corner, deviation):
    """Fields are constant, so that the piecewise linear map is the motion itself."""
    ds = cd.event_orders(corner, [0.0, 0.0])
    holds = [i for i in range(2) if (ds["cone"][i].values @ deviation >= 0).all()]
    end = [
        cd.trajectory(corner.with_initial(x=-1 + dx, y=-1 + dy), duration=3.0)["states"][-1].values
        for dx, dy in ((0, 0), deviation)
    ]
    (one,) = holds
    np.testing.assert_allclose(end[1] - end[0], ds["matrix"][one].values @ deviation, atol=1e-13)


def bar(ratio, **values):
    """A bar on two pegs that move up and down, by height y and s = angle times half the distance of the pegs.

    A hit changes y' + s' (or y' - s') by the law of restitution, by an impulse there; ``ratio`` is m d^2/I.
    """
    drive, speed = "amplitude*sin(omega*t)", "amplitude*omega*cos(omega*t)"

    def hit(sign):
        jump = f"(1 + e)*(v {sign} w - {speed})/(1 + {ratio})"
        return {"v": f"v - {jump}", "w": f"w - ({sign}1)*{ratio}*{jump}"}

    return cd.HybridSystem(
        name="bar on two pegs", states="y s v w", parameters=values, period="2*pi/omega",
        modes={"flight": {"y": "v", "s": "w", "v": "-gravity", "w": "0"}},
        transitions=[
            cd.Transition(name, "flight", "flight", f"y {sign} s - {drive}", direction=-1, reset=hit(sign))
            for name, sign in (("right", "+"), ("left", "-"))
        ],
        initial={"y": 3.0},
    )  # fmt: skip


VALUES = {"amplitude": 0.9, "omega": 1.0, "e": 0.8, "gravity": 1.0}


def landing():
    form = closed.bounce(**VALUES)
    time, period = float(form["time"]), 2 * np.pi
    return form, time, period, [0.9 * np.sin(time), 0.0, 0.9 * np.cos(time), 0.0]


def test_multipliers_of_a_bar_are_those_of_two_balls():
    """With all mass above the pegs either end bounces as a ball would."""
    form, time, period, (y, s, _, w) = landing()
    before = [y, s, -period / 2, w]
    ds = cd.event_orders(bar(1, **VALUES), before, time=time, duration=period)
    assert ds.attrs["continuous"] == 1
    assert sorted(map(tuple, ds["event"].values)) == [("left", "right"), ("right", "left")]
    trace, determinant = float(form["trace"]), float(form["determinant"])
    ball = np.roots([1, -trace, determinant])
    for one in (ds.isel(order=i) for i in range(2)):
        same(one["multiplier_real"], one["multiplier_imag"], np.repeat(ball, 2), 1e-7)
    np.testing.assert_allclose(ds["matrix"][0], ds["matrix"][1], atol=1e-12)


def same(real, imaginary, expected, within):
    """Whether these are the same numbers, in any order."""
    for found, exact in ((real, expected.real), (imaginary, expected.imag)):
        np.testing.assert_allclose(np.sort(found), np.sort(exact), rtol=0, atol=within)


@pytest.fixture(scope="module")
def balanced():
    """A bar that lands on both pegs at once, with all mass above them."""
    _, time, period, (y, _, _, _) = landing()
    left = period - time
    return bar(1, **VALUES).with_initial(y=y + period / 2 * left - left**2 / 2, s=0.0, v=period / 2 - left, w=0.0)


def test_the_orbit_of_a_bar_through_both_hits_is_found(balanced):
    form, time, period, _ = landing()
    orbit = cd.periodic_orbit(balanced)
    assert orbit.cd.outcome == "periodic"
    assert orbit["consistent"] == 1
    np.testing.assert_allclose(orbit["event_time"], [time, time], rtol=0, atol=1e-14 * period)
    ball = np.roots([1, -float(form["trace"]), float(form["determinant"])])
    same(orbit["multiplier_real"], orbit["multiplier_imag"], np.repeat(ball, 2), 1e-12)
    assert "'right' and 'left' happen in one instant" in orbit.attrs["message"]
    ds = cd.event_orders(balanced, orbit)
    assert sorted(map(tuple, ds["event"].values)) == [("left", "right"), ("right", "left")]
    for one in (ds.isel(order=i) for i in range(2)):
        same(one["multiplier_real"], one["multiplier_imag"], np.repeat(ball, 2), 1e-7)


def test_derivatives_of_an_orbit_through_both_hits(balanced):
    """Both hits move with the amplitude as that of the ball does."""
    orbit = cd.periodic_orbit(balanced, derivatives=["amplitude"])
    beside = [float(closed.bounce(**(VALUES | {"amplitude": 0.9 + step}))["time"]) for step in (-1e-5, 1e-5)]
    exact = (beside[1] - beside[0]) / 2e-5
    np.testing.assert_allclose(np.ravel(orbit["event_time_derivative"]), [exact, exact], rtol=1e-8)


def test_a_branch_keeps_the_tie(balanced):
    branch = cd.continue_orbit(balanced, {"amplitude": (0.8, 1.0)})
    ends = branch["amplitude"].values[[0, -1]]
    np.testing.assert_allclose(ends, [0.8, 1.0])
    for point in (0, -1):
        values = VALUES | {"amplitude": float(branch["amplitude"][point])}
        form = closed.bounce(**values)
        ball = np.roots([1, -float(form["trace"]), float(form["determinant"])])
        same(branch["multiplier_real"][point], branch["multiplier_imag"][point], np.repeat(ball, 2), 1e-10)


@pytest.mark.parametrize("unit", [1e-6, 1.0])
@pytest.mark.parametrize("rate", [1.0, 4.0])
def test_multipliers_differ_with_the_order(unit, rate):
    """Two clocks x and y are met at once, and go on at other rates until both were: d = x - y becomes d/2 or d/rate.

    On the way back both begin at -p, and a of d is left.
    """
    rates = {"00": (1, 1), "10": (1, 2), "01": (rate, 1), "11": (1, 1), "back": (1, 1)}
    ways = [("x first", "00", "10", "x"), ("y first", "00", "01", "y"), ("y then", "10", "11", "y"),
            ("x then", "01", "11", "x")]  # fmt: skip
    again = cd.Transition(
        "again", "11", "back", f"x + y - {2 * unit}", 1, {"x": "-p + a*(x - y)/2", "y": "-p - a*(x - y)/2"}
    )
    clocks = cd.HybridSystem(
        name="clocks", states="x y", parameters={"p": unit, "a": 0.5},
        modes={m: {s: f"{v}" for s, v in zip("xy", of, strict=True)} for m, of in rates.items()},
        transitions=[*(cd.Transition(name, a, b, guard, direction=1) for name, a, b, guard in ways), again,
                     cd.Transition("off", "back", "00", "x + y + p", 1)],
        initial={"x": -unit, "y": -unit, "mode": "back"},
    )  # fmt: skip
    orbit = cd.periodic_orbit(clocks, start="guess")
    assert orbit.cd.outcome == "periodic", orbit.attrs["message"]
    assert float(orbit["period_time"]) == pytest.approx(2 * unit, rel=1e-12)
    ds = cd.event_orders(clocks, orbit)
    of = {one["event"].values[0]: one for one in (ds.isel(order=i) for i in range(2))}
    for first, left in (("x first", 0.5 / 2), ("y first", 0.5 / rate)):
        np.testing.assert_allclose(of[first]["multiplier_real"], [1, left], atol=1e-7)
        assert (of[first]["multiplier_in_cone"] == 1).all()


def test_a_bar_whose_hits_depend_on_their_order_jumps():
    _, time, period, (y, s, _, w) = landing()
    before = [y, s, -period / 2, w]
    ds = cd.event_orders(bar(3, **VALUES), before, time=time)
    assert ds.attrs["continuous"] == 0
    first, second = (ds["state_after"].sel(state=["v", "w"]).values[i] for i in range(2))
    # mirror images: what the right end does first, the left end does in the other order
    np.testing.assert_allclose(first, second * [1, -1], atol=1e-13)
    # speeds of the ends relative to the pegs: a hit turns one, and hurries the other on
    table = 0.9 * np.cos(time)
    ends = np.full(2, before[2] - table)
    for turn in range(len([one for one in ds["event"].values[0] if one])):
        near = ends[turn % 2]
        ends[turn % 2], ends[1 - turn % 2] = -0.8 * near, ends[1 - turn % 2] - 1.8 * near * (1 - 3) / (1 + 3)
    assert (ends > 0).all()
    np.testing.assert_allclose(sorted([first[0] + first[1], first[0] - first[1]]), sorted(ends + table), atol=1e-13)
    with pytest.raises(cd.SettingsError, match="do not lead to one state"):
        cd.event_orders(bar(3, **VALUES), before, time=time, duration=period)


@pytest.mark.parametrize(
    ("state", "given", "words"),
    [
        ([-1.0, -1.0], {}, "no guard of mode '00' is met"),
        ([0.0], {}, "expected 2 finite numbers"),
        ({"x": 0.0}, {}, "leaves out 'y'"),
        ({"x": 0.0, "y": 0.0, "z": 0.0}, {}, "has no state 'z'; expected numbers for"),
        ([0.0, 0.0], {"mode": "flight"}, "expected one of"),
        ([0.0, 0.0], {"duration": 1e308}, "the motion does not last"),
    ],
)
def test_refused(corner, state, given, words):
    with pytest.raises(cd.SettingsError, match=words):
        cd.event_orders(corner, state, **given)
