"""Closed branches are walked once, and branches that cross are followed on either side."""

import numpy as np
import pytest
import sympy
from support.discrete import mapped
from support.following import kinds

import chaosdrill as cd
from chaosdrill.dataset.branches import BranchEnd, Special

x, y, r, mu, a, b = sympy.symbols("x y r mu a b", real=True)


@pytest.mark.parametrize("transient", [1000, 1010])
def test_a_closed_branch_is_walked_once(transient):
    system = cd.build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "omega": 3.24, "e": 0.6})
    branch = cd.continue_orbit(system, {"omega": (3.18, 3.30)}, period=6, transient=transient)
    assert branch["branch_end"].values.tolist() == [BranchEnd.CLOSED]
    values = branch["special_value"].values
    assert len(values) == len(np.unique(values.round(9))) == 4
    # the same orbit, which may begin at another of its strobes
    for name in ("omega", "multiplier_real", "multiplier_imag"):
        first, last = (np.sort(np.ravel(branch[name].values[k])) for k in (0, -1))
        np.testing.assert_allclose(last, first, atol=1e-7)


@pytest.mark.parametrize(("near", "slope"), [(0.0, 0.3), (3e-6, 0.3), (1e-6, 1.5)])
def test_a_branch_that_crosses_itself_is_walked_once_from_the_crossing_and_beside_it(near, slope):
    """A figure eight of fixed points: the way back to a start beside the crossing leads past it across."""
    eight = mapped({x: x + b * (mu**4 - mu**2 + (x - 1) ** 2)}, {"mu": near, "b": slope}, (1 + near,))
    found = cd.continue_orbit(eight, {"mu": (-2, 2)}, start="guess", step=0.1)
    assert found["branch_end"].values.tolist() == [BranchEnd.CLOSED]
    assert sorted(zip(np.round(found["special_value"].values), kinds(found), strict=True)) == [
        *((-1, Special.FOLD), (0, Special.BRANCH_POINT), (1, Special.FOLD)),
    ]


@pytest.fixture(scope="module")
def loop():
    """Cycles of squared radius rho about (c, 0), with (mu/a)^2 + ((rho - 1)/0.5)^2 = 1: an ellipse; z decays."""
    rate = "(1 - (mu/a)**2 - (((x - c)**2 + (y/unit)**2 - 1)/0.5)**2)"
    return cd.HybridSystem(
        name="loop", states="x y z", parameters={"mu": 0.0, "a": 1.0, "c": 0.7, "unit": 1.0},
        modes={"on": {"x": f"(x-c)*{rate} - 2*y/unit", "y": f"y*{rate} + 2*unit*(x-c)", "z": "0.3*(x - c) - 0.5*z"}},
    )  # fmt: skip


@pytest.mark.parametrize(("side", "turn", "size", "step"), [(1, 2.0, 40.0, 0.1), (-1, 2.0, 1.0, None)])
def test_a_closed_branch_of_a_flow_is_walked_once(loop, side, turn, size, step):
    """It returns to its first orbit at another point of that, where the plane that it begins on has come to.

    Where the cycle repels, a turn enlarges what a line between two orbits misses 160,000 times.
    """
    radius = np.sqrt(1 + side * 0.5 * np.sqrt(1 - 0.6**2))
    start = radius * np.exp(1j * turn)
    system = loop.with_parameters(mu=0.6 * size, a=size, unit=size).with_initial(
        x=0.7 + start.real, y=size * start.imag, z=(0.3 * start / (0.5 + 2j)).real
    )
    branch = cd.continue_orbit(system, {"mu": (-2 * size, 2 * size)}, start="guess", step=step and step * size)
    assert "closed loop" in branch["branch_end_text"].item()
    assert branch["special_kind"].values.tolist() == [Special.FOLD, Special.FOLD]
    np.testing.assert_allclose(np.sort(branch["special_value"]), [-size, size], rtol=1e-12)
    mu, (x, y, _) = branch["mu"].values / size, branch["orbit_state"].values.T
    height = ((x - 0.7) ** 2 + (y / size) ** 2 - 1) / 0.5
    np.testing.assert_allclose(mu**2 + height**2, 1, atol=1e-10)
    around = np.ptp(np.unwrap(np.arctan2(height, mu)))
    assert around == pytest.approx(2 * np.pi, abs=1e-5)


@pytest.mark.parametrize(("size", "pace"), [(1.0, 1.0), (1e-9, 1e-5)])
def test_a_closed_branch_of_motions_that_run_away_is_walked_once(size, pace):
    """Cycles of radius^2 1 +- sqrt(1/4 - k^2); the start is beside the outer one, of multiplier 2e8."""
    radius = "(r**2 + ((x/k)**2 + (y/k)**2 - 1)**2 - 1/4)*w"
    system = cd.HybridSystem(
        name="isola", states="x y", parameters={"r": 0.0, "k": size, "w": pace}, initial={"x": size * np.sqrt(1.5)},
        modes={"on": {"x": f"{radius}*x - w*y", "y": f"{radius}*y + w*x"}},
    )  # fmt: skip
    branch = cd.continue_orbit(system, {"r": (-1.0, 1.0)}, step=0.02)
    assert "closed loop" in branch["branch_end_text"].item()
    assert kinds(branch) == [Special.FOLD] * 2
    np.testing.assert_allclose(np.sort(branch["special_value"]), [-0.5, 0.5], atol=1e-9)


@pytest.mark.parametrize(("begin", "start"), [(0.5, 0.0), (1.5, np.sqrt(0.5))])
def test_a_pitchfork_gives_both_partners_and_their_cascades(begin, start):
    """y := k y - y^3: partners y^2 = k - 1 from k = 1, their periods doubling at 2 and sqrt(5)."""
    system = mapped({x: r * x - x**3}, {"r": begin}, [start])
    branch = cd.continue_orbit(system, {"r": (0.2, 2.4)}, start="guess", doublings=2)
    points, states = branch["r"].values, branch["orbit_state"].values[:, 0]
    simple = branch["period"].values == 1
    off = states[simple] * (states[simple] ** 2 - (points[simple] - 1))
    assert np.abs(off).max() < 1e-9
    for side in (1, -1):
        assert points[simple & (side * states > 0.1)].max() == 2.4
    assert points[simple & (np.abs(states) < 1e-9)].max() == 2.4
    assert points[simple].min() == 0.2
    kinds_there = branch["special_kind"].values
    doublings = branch["special_value"].values[kinds_there == Special.PERIOD_DOUBLING]
    assert [int(np.sum(np.abs(doublings - value) < 1e-10)) for value in (2, np.sqrt(5))] == [2, 2]


def test_partners_that_meet_again_are_walked_once():
    """y^2 = (1 - k^2) / 4 is a closed curve through both branch points."""
    system = mapped({x: x + x * (1 - r**2) / 4 - x**3}, {"r": -1.3}, [0.0])
    branch = cd.continue_orbit(system, {"r": (-2.0, 2.0)}, start="guess", doublings=1)
    assert branch["branch_end"].values.tolist() == [BranchEnd.LIMIT, BranchEnd.CLOSED]
    loop = branch["branch"].values == 1
    values, states = branch["r"].values[loop], branch["orbit_state"].values[loop, 0]
    assert np.abs(states**2 - (1 - values**2) / 4).max() < 1e-9
    crossings = branch["special_value"].values[branch["special_kind"].values == Special.BRANCH_POINT]
    np.testing.assert_allclose(np.sort(np.abs(crossings)), 1, atol=1e-6)
    assert len(crossings) == 2


@pytest.mark.parametrize("doublings", [0, 1])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_branch_that_crosses_itself_is_walked_once_and_the_crossing_stands_once(sign, doublings):
    """Bernoulli's lemniscate (x^2 + k^2)^2 = x^2 - k^2, upright or, with the other sign, lying."""
    system = cd.Map(
        states=(x,), parameters={"r": 0.0 if sign > 0 else 0.5},
        images={x: x + (sign * (x**2 - r**2) - (x**2 + r**2) ** 2) / 10},
    )  # fmt: skip
    start = 1.0 if sign > 0 else np.sqrt(np.sqrt(3) / 2 - 0.75)
    branch = cd.continue_orbit(
        system.with_initial(x=start), {"r": (-2.0, 2.0)}, start="guess", step=0.05, doublings=doublings
    )
    assert branch["branch_end"].values.tolist() == [BranchEnd.CLOSED]
    states, values = branch["orbit_state"].values[:, 0], branch["r"].values
    assert branch.attrs["message"] == ""
    assert np.abs(sign * (states**2 - values**2) - (states**2 + values**2) ** 2).max() < 1e-11
    folds = [1 / np.sqrt(8), -1 / np.sqrt(8)] * 2 if sign > 0 else [1.0, -1.0]
    assert sorted(kinds(branch)) == sorted([Special.FOLD] * len(folds) + [Special.BRANCH_POINT])
    np.testing.assert_allclose(np.sort(branch["special_value"]), np.sort([*folds, 0.0]), atol=1e-9)


def test_a_crossing_at_a_small_state_is_as_well_known_as_its_error_says():
    """The nodal cubic u^2 = k^2 (1 + k) in x = sinh(u): its loop begins and ends at 0."""
    u = sympy.asinh(x)
    nodal = mapped({x: sympy.sinh(u + (u**2 - r**2 * (1 + r)) * sympy.Rational(3, 10))}, {"r": -0.5}, [0.0])
    start = nodal.with_initial(x=-float(np.sinh(np.sqrt(0.125))))
    branch = cd.continue_orbit(start, {"r": (-2.0, 1.0)}, start="guess")
    assert sorted(kinds(branch)) == sorted([Special.FOLD, Special.BRANCH_POINT])
    assert (np.abs(np.sort(branch["special_value"]) - [-1, 0]) <= np.sort(branch["special_error"])).all()
    assert branch.attrs["message"] == ""


@pytest.mark.parametrize("step", [0.02, 0.03])
def test_a_crossing_is_as_well_known_as_its_error_says(step):
    """u := u - u (mu - u) (mu + u - 1): two branches cross at 1/2, where an orbit is known to the root of round-off."""
    u, v = (2 * x - y) / 3, (2 * y - x) / 3
    u = u - 3 * v**2 / 10
    image, other = u - u * (mu - u) * (mu + u - 1), v / 2
    image += 3 * other**2 / 10
    system = mapped({x: 2 * image + other, y: image + 2 * other}, {"mu": -0.3}, [0.0, 0.0])
    branch = cd.continue_orbit(system, {"mu": (-0.45, 1.3)}, start="guess", doublings=1, step=step)
    found, error = branch["special_value"].values, branch["special_error"].values
    assert set(kinds(branch)) == {Special.BRANCH_POINT}
    assert set(found.round(9)) == {0.0, 0.5, 1.0}
    assert (np.abs(found - found.round(9)) <= error).all()
    assert error.max() < 1e-9


@pytest.mark.parametrize("step", [0.01, 0.02])
def test_a_loop_turns_back_where_a_straight_branch_crosses(step):
    """u := u - u (u^2 + mu^2 - 1/4) / 2, in units of 1e-6: at 1/2 only errors of the orbits change the parameter."""
    v = 10**6 * y - 3 * 10**6 * x / 10 + (10**6 * x) ** 2 / 5
    u = 10**6 * x - 3 * v**2 / 10
    first = u - u * (u**2 + mu**2 - sympy.Rational(1, 4)) / 2 + 3 * (v / 2) ** 2 / 10
    images = {x: first / 10**6, y: (3 * first / 10 - first**2 / 5 - v / 2) / 10**6}
    branch = cd.continue_orbit(mapped(images, {"mu": 0.0}, [5e-7, 1e-7]), {"mu": (-1.0, 1.0)}, start="guess", step=step)
    assert branch["branch_end"].values.tolist() == [BranchEnd.CLOSED]
    assert kinds(branch) == [Special.BRANCH_POINT] * 2
    assert (np.abs(np.sort(branch["special_value"]) - [-0.5, 0.5]) <= branch["special_error"]).all()


def test_all_branches_are_followed_where_several_cross():
    """Two coupled pitchforks: at mu = 0 four branches cross, on the axes and on the diagonals, in bent coordinates."""
    u, v = x - (y - x) ** 2 / 5, y - x
    first, other = (p + a * p * (mu - p**2 - b * q**2) for p, q in ((u, v), (v, u)))
    images = {x: first + other**2 / 5, y: other + first + other**2 / 5}
    together = mapped(images, {"mu": -0.2, "a": 0.3, "b": 0.5}, [0.0, 0.0])
    found = cd.continue_orbit(together, {"mu": (-0.5, 0.6)}, start="guess", doublings=1, step=0.05)
    assert kinds(found) == [Special.BRANCH_POINT]
    assert found["special_multiplicity"].item() == 2
    assert not found.attrs["message"]
    assert found["branch_parent"].values.tolist() == [-1] + [0] * 8
    ends = found.sel(point=np.flatnonzero(found["mu"] == 0.6))
    u, v = (ends["orbit_state"].sel(state=name).values for name in "xy")
    v = v - u
    u = u - v**2 / 5
    far, near = np.sqrt(0.6), np.sqrt(0.6 / 1.5)
    known = [
        (0, 0),
        (far, 0),
        (-far, 0),
        (0, far),
        (0, -far),
        *((p * near, q * near) for p in (1, -1) for q in (1, -1)),
    ]
    np.testing.assert_allclose(
        sorted(zip(u.round(9), v.round(9), strict=True)), sorted(np.round(known, 9).tolist()), atol=2e-9
    )


def test_the_branches_of_a_ring_are_followed_where_two_multipliers_are_one():
    """Three maps p/2 + p^2 - p^3 with repelling neighbours: two multipliers are 1 at a = 1/3, where six ways lead off.

    On each two maps are alike; in the plane of equal sums the branches come in threes, which turns permute.
    """
    states = sympy.symbols("x y z", real=True)
    total = sum(states)
    images = {p: p / 2 + p**2 - p**3 + a * (p - (total - p) / 2) for p in states}
    ring = cd.Map(states=states, parameters={"a": 0.3}, images=images)
    found = cd.continue_orbit(ring, {"a": (0.25, 0.345)}, start="guess", doublings=1, step=0.005)
    assert abs(found["special_value"][0].item() - 1 / 3) <= found["special_error"][0].item()
    assert found["special_multiplicity"][0] == 2
    assert found["branch_parent"].values.tolist() == [-1] + [0] * 6
    for number in range(1, 7):
        own = found["orbit_state"].values[found["branch"].values == number]
        alike = [np.abs(own[:, i] - own[:, j]).max() < 1e-9 for i, j in ((0, 1), (1, 2), (2, 0))]
        assert sum(alike) == 1
    ends = [found["orbit_state"].values[found["branch"].values == number][-1].round(9) for number in range(1, 7)]
    assert len({tuple(sorted(one)) for one in ends}) == 2
    assert len({tuple(one) for one in ends}) == 6


def test_an_isola_of_period_three_is_walked_once_between_its_folds():
    """The logistic map with r = 3.84 - mu^2: its window of period 3 begins at r = 1 + sqrt(8)."""
    system = cd.Map("x", {"mu": 0.0}, {"x": "(3.84 - mu**2)*x*(1 - x)"}, initial={"x": 0.1494})
    branch = cd.continue_orbit(system, {"mu": (-0.3, 0.3)}, period=3, start="guess", step=0.005)
    assert branch.cd.words("special_kind").values.tolist() == ["fold"] * 2
    fold = np.sqrt(2.84 - np.sqrt(8))
    assert np.abs(np.sort(branch["special_value"].values) - [-fold, fold]).max() < 1e-13
    assert "closed loop" in branch["branch_end_text"].item()


def test_a_branch_whose_rebounds_change_in_number_is_no_loop():
    """A follower that chatters back onto its cam: its motion begins anew from there at every frequency."""
    cam, speed, onto = "-cos(w*t)", "w*sin(w*t)", "q + cos(w*t)"
    follower = cd.HybridSystem(
        states="q v",
        parameters={"w": 2.645},
        modes={
            "contact": {"q": speed, "v": "w**2*cos(w*t)"},
            "flight": {"q": "v", "v": "-(q + 4) - v/10"},
        },
        transitions=[
            cd.Transition(
                "lift", "contact", "flight", "w**2*cos(w*t) + 4 - cos(w*t) + w*sin(w*t)/10", -1, {"q": cam, "v": speed}
            ),
            cd.Transition("bounce", "flight", "flight", onto, -1, {"v": f"{speed} - 0.6*(v - {speed})"}),
            cd.Transition("land", "flight", "contact", onto, -1, {"q": cam, "v": speed}, completes="bounce"),
        ],
        period="2*pi/w",
        initial={"mode": "contact", "q": -1.0},
    )
    branch = cd.continue_orbit(follower, {"w": (2.64, 2.652)}, step=0.0075, max_points=12)
    assert "loop" not in str(branch["branch_end_text"].values)
    assert float(branch["w"].max()) > 2.6455
