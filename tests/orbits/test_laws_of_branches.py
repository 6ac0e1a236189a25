"""Laws that every branch obeys, over families whose diagrams are known in closed form."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
import sympy
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq, fsolve
from support.discrete import mapped
from support.following import kinds

import chaosdrill as cd
from chaosdrill.dataset.branches import BranchEnd, Special
from chaosdrill.orbits import crossings
from chaosdrill.orbits.crossings import unexplained
from chaosdrill.orbits.multipliers import Spectra
from chaosdrill.orbits.roots import bracketed

x, y, z, w, r, mu, a, b, unit = sympy.symbols("x y z w r mu a b unit", real=True)


def stepped(images, parameters, initial, condition=None):
    """A map, applied once a period by an event; with a condition, one of two maps."""
    clock = sympy.Symbol("clock", real=True)
    choices = [images] if condition is None else images
    steps = [
        cd.Transition(
            f"step{k}", "wait", "wait", guard=clock - 1, direction=1, reset={**one, clock: 0},
            condition=condition if condition is not None and k == 0 else None,
        )
        for k, one in enumerate(choices)
    ]  # fmt: skip
    states = tuple(choices[0])
    return cd.HybridSystem(
        name="map", states=(*states, clock), parameters=parameters, period=sympy.Integer(1),
        modes={"wait": {**dict.fromkeys(states, 0), clock: 1}}, transitions=steps,
        initial={**dict(zip(states, initial, strict=True)), clock: 0.5},
    )  # fmt: skip


# The curve lives in all points of an orbit: windows of the logistic map.


def where_multiplier_is(critical, period, near, start, image, slope):
    """The parameter, by another root finder in other unknowns."""

    def equations(unknowns):
        points, value = unknowns[:-1], unknowns[-1]
        return [*(image(points, value) - np.roll(points, -1)), np.prod(slope(points, value)) - critical]

    orbit = [start]
    for _ in range(period - 1):
        orbit.append(image(orbit[-1], near))
    return float(fsolve(equations, [*orbit, near], xtol=1e-13)[-1])


def fold_of_window(period, near, start):
    """Where f^p(x) = x has a double root."""
    return where_multiplier_is(1, period, near, start, lambda x, r: r * x * (1 - x), lambda x, r: r * (1 - 2 * x))


WINDOWS = [
    (3, 3.835, (3.8, 3.87)),
    (3, 3.835, (3.0, 4.0)),
    (4, 3.9605, (3.955, 3.97)),
    (5, 3.7385, (3.72, 3.76)),
    (6, 3.6268, (3.62, 3.64)),
    (7, 3.7018, (3.695, 3.71)),
]


@pytest.mark.parametrize(("period", "inside", "limits"), WINDOWS)
def test_the_fold_of_a_window_stands_once_and_both_branches_go_on(period, inside, limits):
    system = LOGISTIC.with_parameters(r=inside)
    branch = cd.continue_orbit(system, {"r": limits}, period=period, transient=3000)
    exact = fold_of_window(period, inside, 0.5)
    folds = branch["special_value"].values[branch["special_kind"].values == Special.FOLD]
    assert len(folds) == 1
    assert abs(folds[0] - exact) < 1e-11
    assert branch["branch_end"].values.tolist() == [BranchEnd.LIMIT]
    assert branch["r"].values[[0, -1]].tolist() == [limits[1], limits[1]]
    assert branch["r"].values.min() == pytest.approx(exact, abs=1e-11)
    assert branch.attrs["message"] == ""


LOGISTIC = stepped({x: r * x * (1 - x / unit)}, {"r": 3.835, "unit": 1.0}, [0.4])


@settings(max_examples=6)
@given(
    step=st.floats(0.0002, 0.0015), turns=st.integers(0, 2), size=st.sampled_from([1.0, 1e-6, 1e6]),
    inside=st.floats(3.8295, 3.8405),
)  # fmt: skip
def test_nothing_of_a_fold_depends_on_the_step_the_start_or_the_unit(step, turns, size, inside):
    """sqrt(8) + 1 is the fold; the period doubles where (f^3)' = -1, at 3.841499..."""
    start = 0.5
    for _ in range(300 + turns):
        start = inside * start * (1 - start)
    system = LOGISTIC.with_parameters(r=inside, unit=size).with_initial(x=start * size)
    branch = cd.continue_orbit(system, {"r": (3.8, 3.85)}, period=3, transient=200, step=step)
    assert sorted(kinds(branch)) == [Special.FOLD, Special.PERIOD_DOUBLING]
    found = branch["special_value"].values
    assert np.abs(np.sort(found) - [1 + np.sqrt(8), 3.841499007543]).max() < 1e-10
    assert branch["special_multiplicity"].values.tolist() == [1, 1]


def test_a_fold_sharper_than_the_range_is_not_missed():
    """Of a period of 7 in a window 1e-4 wide, beside which orbits that close to 3e-11 are none."""
    near, points = 3.88604, [0.5]
    for _ in range(20_000):
        points.append(near * points[-1] * (1 - points[-1]))
    start = min(points[-7:], key=lambda one: abs(one - 0.5))
    window = cd.Map("x", {"r": near}, {"x": "r*x*(1 - x)"}, name="window", initial={"x": start})
    found = cd.continue_orbit(window, {"r": (3.8859605921, 3.8860902275275087)}, period=7, start="guess")
    assert found["special_value"].values == pytest.approx([fold_of_window(7, near, start)], abs=1e-11)
    assert found["r"].values.min() == pytest.approx(found["special_value"].item(), abs=1e-11)


@pytest.mark.parametrize("wide", [1.5, 3.0, 1e3])
@pytest.mark.parametrize(("period", "inside"), [(6, 3.9975831), (7, 3.9847476), (7, 3.9993971)])
def test_narrow_windows_begin_with_a_fold_and_end_with_a_doubling(period, inside, wide):
    """The window of period 6 is 2.4e-6 wide, of the last of period 7 it is 1.4e-7."""

    def images(values):
        point, slope = 0.5, 0.0
        for _ in range(period):
            point, slope = values * point * (1 - point), point * (1 - point) + values * (1 - 2 * point) * slope
        return point, slope

    for _ in range(9):
        point, slope = images(inside)
        inside -= (point - 0.5) / slope
    functions = (lambda x, r: r * x * (1 - x), lambda x, r: r * (1 - 2 * x))
    exact = [where_multiplier_is(mu, period, inside, 0.5, *functions) for mu in (1, -1)]
    limits = inside - wide * (inside - exact[0]), min(inside + wide * (exact[1] - inside), 4.0)
    window = mapped({x: sympy.Symbol("r") * x * (1 - x)}, {"r": inside}, [0.5])
    branch = cd.continue_orbit(window, {"r": limits}, period=period, start="guess")
    assert sorted(kinds(branch)) == [Special.FOLD, Special.PERIOD_DOUBLING]
    off = np.sort(branch["special_value"].values) - exact
    assert (np.abs(off) <= branch["special_error"].values.max()).all()
    assert branch["r"].values[[0, -1]].tolist() == [limits[1], limits[1]]


RICKER = (lambda x, r: x * np.exp(r * (1 - x)), lambda x, r: np.exp(r * (1 - x)) * (1 - r * x))
SINE = (lambda x, r: r * np.sin(np.pi * x), lambda x, r: r * np.pi * np.cos(np.pi * x))
CUBIC = (lambda x, r: r * x * (1 - x**2), lambda x, r: r * (1 - 3 * x**2))
IMAGES = {RICKER: "x*exp(r*(1 - x))", SINE: "r*sin(pi*x)", CUBIC: "r*x*(1 - x**2)"}


def settled(functions, value, point=0.51):
    for _ in range(3000):
        point = functions[0](point, value)
    return point


@pytest.mark.parametrize(
    ("functions", "begin", "period", "inside", "limits", "parts"),
    [
        (RICKER, 0.51, 5, 3.36495, (3.3578302857, 3.3738502857), 120),  # almost a loss of rank
        (RICKER, 0.51, 5, 3.924925, (3.88225484, 3.99745484), 200),  # two legs 5e-8 apart
        (RICKER, 0.51, 5, 3.924925, (3.88225484, 3.99745484), 1000),
        (SINE, 0.501, 6, 0.9892, (0.9891888854306944, 0.9892188854306944), 200),  # 1e-5 of the range from a limit
    ],
)
def test_a_fold_as_sharp_as_a_hairpin_is_a_fold(functions, begin, period, inside, limits, parts):
    start = settled(functions, inside, begin)
    exact = where_multiplier_is(1, period, inside, start, *functions)
    window = cd.Map("x", {"r": inside}, {"x": IMAGES[functions]}, name="window", initial={"x": start})
    step = (limits[1] - limits[0]) / parts
    branch = cd.continue_orbit(window, {"r": limits}, period=period, start="guess", step=step)
    assert sorted(kinds(branch)) == [Special.FOLD, Special.PERIOD_DOUBLING]
    found = int(np.flatnonzero(branch["special_kind"].values == Special.FOLD)[0])
    assert abs(float(branch["special_value"][found]) - exact) < 1e-11
    assert branch["r"].values[[0, -1]].tolist() == [limits[1], limits[1]]


@pytest.mark.parametrize(
    ("functions", "inside", "before"), [(RICKER, 3.173525, 3.155), (SINE, 0.9436, 0.942), (CUBIC, 2.463304, 2.4605)]
)
@pytest.mark.parametrize("parts", [100, 300])
def test_a_doubled_orbit_does_not_go_on_as_one_of_half_its_period(functions, inside, before, parts):
    exact = where_multiplier_is(-1, 3, before, settled(functions, before), *functions)
    start = settled(functions, inside)
    window = cd.Map("x", {"r": inside}, {"x": IMAGES[functions]}, name="window", initial={"x": start})
    limits = (exact - (inside - exact) / 4, inside + (inside - exact) / 4)
    step = (limits[1] - limits[0]) / parts
    branch = cd.continue_orbit(window, {"r": limits}, period=6, start="guess", step=step)
    told = branch["branch_end_text"].item()
    value, error = re.search(r"another period doubling, r = (\S+) \(error (\S+)\)", told).groups()
    assert abs(float(value) - exact) <= float(error) + 1e-11 < 1e-9


def test_steps_beside_a_doubling_grow_with_the_way_along_the_branch():
    """They do not shrink with the distance of the parameter, which goes with the square of that of the states."""
    branch = cd.continue_orbit(LOGISTIC.with_parameters(r=2.95), {"r": (2.9, 300.0)}, doublings=2, max_points=500)
    assert branch["branch_end"].values.tolist() == [BranchEnd.LIMIT] * 3
    np.testing.assert_allclose(branch["doubling_value"], [3, 1 + np.sqrt(6), 3.5440903595519], atol=1e-10)


def test_a_doubled_orbit_outside_the_limits_is_none():
    """All happens within 1e-6 of the parameter, less than the way to the first doubled orbit."""
    rate = 3 + 0.46 * r / (1e-6 + r) + r / 10
    system = mapped({x: rate * x * (1 - x)}, {"r": 0.004}, [0.4])
    branch = cd.continue_orbit(system, {"r": (-5e-7, 1.0)}, doublings=1)
    assert branch["branch_parent"].values.tolist() in ([-1], [-1, 0])


# Multipliers that cross together are one special point, with their number.


def quadratic(u):
    return mu - u**2


def ring(e):
    def image(own, left, right):
        return (1 - 2 * e) * quadratic(own) + e * (quadratic(left) + quadratic(right))

    return {x: image(x, y, z), y: image(y, z, x), z: image(z, x, y)}


@pytest.mark.parametrize("tenths", [1, -1, 2])
def test_a_ring_of_three_doubles_in_phase_and_twice_across(tenths):
    """Across the ring the multiplier is -2 x (1 - 3 e), twice; x is the root of x = mu - x^2."""
    e = sympy.Rational(tenths, 10)
    start = (np.sqrt(3) - 1) / 2
    branch = cd.continue_orbit(mapped(ring(e), {"mu": 0.5}, [start] * 3), {"mu": (0.3, 3.0)}, start="guess")
    across = 1 / (2 * (1 - 3 * tenths / 10))
    expected = sorted([(0.75, 1), (across**2 + across, 2)])
    assert kinds(branch) == [Special.PERIOD_DOUBLING] * 2
    np.testing.assert_allclose(branch["special_value"].values, [value for value, _ in expected], atol=1e-11)
    assert branch["special_multiplicity"].values.tolist() == [count for _, count in expected]


def turn(u, v):
    angle = sympy.Rational(7, 10)
    growth = (1 + mu) * (1 - u**2 - v**2)
    cosine, sine = sympy.cos(angle), sympy.sin(angle)
    return growth * (cosine * u - sine * v), growth * (sine * u + cosine * v)


@pytest.mark.parametrize(
    ("images", "kind", "multiplicity"),
    [
        ({x: x + mu * x - x**3, y: y + mu * y - y**3, z: z + mu * z}, Special.BRANCH_POINT, 3),
        (dict(zip((x, y, z, w), (*turn(x, y), *turn(z, w)), strict=True)), Special.NEIMARK_SACKER, 4),
        (dict(zip((x, y), turn(x, y), strict=True)), Special.NEIMARK_SACKER, 2),
        ({x: -x - mu * x, y: -y - mu * y + x / 3, z: z / 2}, Special.PERIOD_DOUBLING, 2),
    ],
)
def test_what_crosses_together_at_rest_is_one_point(images, kind, multiplicity):
    branch = cd.continue_orbit(mapped(images, {"mu": -0.31}, [0.0] * len(images)), {"mu": (-0.5, 0.45)}, start="guess")
    assert kinds(branch) == [kind]
    assert abs(branch["special_value"].values[0]) < 1e-7
    assert branch["special_multiplicity"].values.tolist() == [multiplicity]
    assert branch["branch_end"].values.tolist() == [BranchEnd.LIMIT]


@pytest.mark.parametrize("step", [0.0085, 0.0527])
def test_multipliers_of_several_kinds_that_cross_together_are_told_apart(step):
    """(x, y, z) := (y, z, mu - x^2): the multipliers are the cube roots of -2 x, at mu = 0.75 those of -1."""
    images = {x: y, y: z, z: quadratic(x)}
    branch = cd.continue_orbit(
        mapped(images, {"mu": 0.5}, [(np.sqrt(3) - 1) / 2] * 3), {"mu": (0.3, 2.0)}, start="guess", step=step
    )
    found = dict(zip(kinds(branch), branch["special_multiplicity"].values.tolist(), strict=True))
    assert found == {Special.PERIOD_DOUBLING: 1, Special.NEIMARK_SACKER: 2}
    np.testing.assert_allclose(branch["special_value"].values, 0.75, atol=1e-11)


class Segment:
    """Points with given multipliers."""

    def __init__(self, *multipliers):
        values = np.array(multipliers, dtype=complex)
        self.spectra = Spectra(values, np.full(len(values), 1e-13))
        self.curve = SimpleNamespace(problem=SimpleNamespace(neutral=SimpleNamespace(count=0)))


@pytest.mark.parametrize(("area", "count"), [(1.0, 2), (0.999, 1), (0.9, 1)])
def test_a_multiplier_and_its_inverse_are_at_a_fold_together(area, count):
    """Henon's map by its Jacobian; orbits of period 1 and 3 in closed form.

    Fixed points are x = (-(1 + j) +- sqrt((1 + j)^2 + 4 a))/2. Where areas are preserved those of period 3 are 1 - q,
    q, q with q = +- sqrt(a - 1), and the trace is 2 + 2 q - 8 q^2 + 8 q^3: -2 at q = -1/2.
    """
    system = mapped({x: a - x**2 - b * y, y: x}, {"a": 0.0, "b": area}, [0.0, 0.0])
    branch = cd.continue_orbit(system, {"a": (-1.2, 0.3)}, start="guess", step=0.05)
    assert (kinds(branch), branch["special_multiplicity"].values.tolist()) == ([Special.FOLD], [count])
    assert abs(branch["special_value"].item() + (1 + area) ** 2 / 4) <= branch["special_error"].item() < 1e-12
    if area == 1:
        start = fsolve(lambda p: 1.2 - p**2 - np.roll(p, 1) - np.roll(p, -1), [1.2, 0.1, -0.5], xtol=1e-14)
        begin = system.with_parameters(a=1.2).with_initial(x=start[0], y=start[2])
        branch = cd.continue_orbit(begin, {"a": (0.9, 1.4)}, start="guess", period=3, step=0.02)
        found = dict(zip(branch["special_value"].values.round(11).tolist(), kinds(branch), strict=True))
        assert found == {1.0: Special.FOLD, 1.25: Special.PERIOD_DOUBLING}
        assert branch["special_multiplicity"].values.tolist() == [2, 2]


@pytest.mark.parametrize(
    ("rows", "marks", "found"),
    [
        ([(0.5, 0.9), (0.5, 1.1)], {}, (0, 1, 0, 1)),
        ([(0.5, 0.9), (0.5, 1.0), (0.5, 1.1)], {1: 1}, None),
        ([(0.5, 0.9), (0.5, 1.0), (1.2, 1.1)], {1: 1}, (0, 2, 0, 2)),
        ([(0.5, 0.9), (0.5, 1 + 1e-9), (0.5, 0.9)], {}, None),
        ([(1.5, 0.9), (1.0, 0.9), (0.5, 0.9), (0.5, 0.9)], {1: 1, 3: 0}, None),
    ],
)
def test_a_count_that_changes_without_a_special_point_is_told(rows, marks, found):
    assert unexplained(Segment(*rows), marks) == found


# Both sides of a border collision.


SKEW = stepped(
    [{x: a * x + mu * unit}, {x: b * x + mu * unit}], {"a": 0.5, "b": -0.5, "mu": 0.3, "unit": 1.0}, [0.0], x <= 0
)


@settings(max_examples=3)
@given(
    left=st.floats(-0.9, 0.9), right=st.floats(-4, -0.2), side=st.sampled_from([-0.3, 0.3]),
    size=st.sampled_from([1.0, 1e6]),
)  # fmt: skip
def test_a_border_collision_is_passed_from_either_side(left, right, side, size):
    """x := a x + mu for x <= 0, else b x + mu: the fixed points mu / (1 - a) and mu / (1 - b)."""
    slope = left if side < 0 else right
    system = SKEW.with_parameters(a=left, b=right, mu=side, unit=size).with_initial(x=side * size / (1 - slope))
    branch = cd.continue_orbit(system, {"mu": (-1.0, 1.0)}, start="guess")
    values, found = branch["mu"].values, branch["orbit_state"].values[:, 0]
    assert {values.min(), values.max()} == {-1.0, 1.0}
    np.testing.assert_allclose(found, size * values / (1 - np.where(values < 0, left, right)), atol=1e-8 * size)
    borders = [k for k, kind in enumerate(kinds(branch)) if kind == Special.OUTCOME_SWITCH]
    assert len(borders) == 1
    assert abs(branch["special_value"].values[borders[0]]) <= branch["special_error"].values[borders[0]]


@pytest.mark.parametrize("step", [0.02, 0.2])
def test_a_branch_does_not_turn_back_where_its_orbits_are_small(step):
    """x := a x + y + mu for x <= 0, else b x + y + mu, y := 0: fixed points mu / (1 - a) and mu / (1 - b), mu > 0."""
    slopes = {"a": 1.8616461126377946, "b": -0.9492316563593217}
    images = [{x: slope * x + y + mu, y: sympy.Integer(0)} for slope in (a, b)]
    system = stepped(images, {**slopes, "mu": 0.3}, [0.3 / (1 - slopes["a"]), 0.0], x <= 0)
    branch = cd.continue_orbit(system, {"mu": (-1.0, 1.0)}, start="guess", step=step)
    values, found = branch["mu"].values, branch["orbit_state"].values[:, 0]
    assert values[[0, -1]].tolist() == [1.0, 1.0]
    assert (np.diff(found) * (found[-1] - found[0]) > 0).all()
    assert kinds(branch) == [Special.OUTCOME_SWITCH]


@pytest.mark.parametrize("beyond", [1e-3, 1e-4])
def test_a_fold_just_before_a_change_of_events_is_found(beyond):
    """x := x + mu - x^2 folds at 0; from x = -beyond on another transition is taken, which changes y alone."""
    images = [{x: x + mu - x**2, y: y / 2 + x}, {x: x + mu - x**2, y: y / 2 + x + (x + a) / 2}]
    system = stepped(images, {"mu": 0.2, "a": beyond}, [np.sqrt(0.2), 2 * np.sqrt(0.2)], x <= -a)
    branch = cd.continue_orbit(system, {"mu": (-0.1, 0.25)}, start="guess")
    assert sorted(kinds(branch)) == sorted([Special.FOLD, Special.OUTCOME_SWITCH])
    np.testing.assert_allclose(np.sort(branch["special_value"]), [0.0, beyond**2], atol=1e-14)


# Where a stay of no time begins, the paths that never stay cross the branch.

RUBBED = cd.in_modes(
    name="rubbed", states="v", parameters={"A": 3.0, "c": 0.9}, field={"v": "A*cos(t) + c - sign(v)"},
    period="2*pi", initial={"v": 1.0},
)  # fmt: skip


def reversal(amplitude):
    """The bias at which a mass that lets go at A cos t + c = 1 stops again just where A cos t + c = -1."""

    def speed(bias):
        begin, end = -np.arccos((1 - bias) / amplitude), 2 * np.pi - np.arccos((-1 - bias) / amplitude)
        return amplitude * (np.sin(end) - np.sin(begin)) + (bias - 1) * (end - begin)

    return brentq(speed, 0.5, 1.0, xtol=1e-15)


@settings(max_examples=3)
@example(step=5e-4, side=0.05, amplitude=3.0)
@given(step=st.floats(3e-4, 5e-3), side=st.sampled_from([-0.05, 0.05]), amplitude=st.floats(2.0, 5.0))
def test_a_reversal_begins_at_one_place_whatever_the_step(step, side, amplitude):
    border = reversal(amplitude)
    limits = (border - 0.06, border + 0.06)
    branch = cd.continue_orbit(RUBBED.with_parameters(A=amplitude, c=border + side), {"c": limits}, step=step)
    assert (branch["c"].values.min(), branch["c"].values.max()) == limits
    assert kinds(branch) == [Special.SWITCHING_SLIDING]
    assert abs(branch["special_value"].values[0] - border) <= branch["special_error"].values[0]


@pytest.mark.parametrize("step", [0.01, 0.05])
def test_an_orbit_of_many_turns_passes_where_it_touches_a_surface_of_the_field(step):
    """Chua's field is continuous there, so that nothing ends; the two turns that touch are of one branch."""
    system = cd.build("chua").with_parameters(
        alpha=8.654963378868732, beta=14.608282531448825, m0=-1.2275743630687892, m1=-0.6467015752823141
    )
    system = system.with_initial(x=1.0, y=-0.4069285031760282, z=-1.2428337101839113, mode="middle")
    branch = cd.continue_orbit(system, {"beta": (13.4, 14.7)}, start="guess", step=step)
    assert branch["branch_end"].values.tolist() == [BranchEnd.LIMIT]
    assert branch["branch_end_text"].values.tolist() == ["the parameter reached its limit"]
    assert kinds(branch).count(Special.GRAZING) == 2


@pytest.mark.parametrize("step", [None, 0.03])
def test_a_branch_stays_on_orbits_of_one_number_of_turns(step):
    """Orbits of five and six turns start side by side; the state half a period later passes through spikes."""
    system = cd.build("roessler").with_parameters(a=0.22898916010028217, b=0.21403835930751522, c=6.400442674669338)
    system = system.with_initial(x=-2.018621652291931, y=-3.7786413302394237, z=0.02433874340614788)
    branch = cd.continue_orbit(system, {"c": (5.9, 6.9)}, start="guess", step=step)
    assert sorted(kinds(branch)) == [Special.FOLD, Special.PERIOD_DOUBLING]
    assert branch["branch_end_text"].values.tolist() == ["the parameter reached its limit"]
    assert branch["c"].values[[0, -1]].tolist() == [6.9, 6.9]
    assert np.ptp(branch["period_time"].values) < 2


def test_a_branch_ends_where_beyond_every_orbit_is_one_of_a_family():
    """Two masses on a belt that slip one after the other may do so with any delay; they are coupled if both slip."""
    system = cd.build("two-masses-on-belt").with_parameters(k=0.3847, F_k=0.4935, belt=0.1908, F_s=1.0837)
    branch = cd.continue_orbit(system, {"F_s": (1.0, 1.2)}, transient=300)
    assert "one of a family" in str(branch["branch_end_text"].values[0])
    assert branch.sizes["sequence_number"] == 1


@pytest.mark.parametrize("slow", [1e-6, 1e-8])
def test_a_special_point_is_no_better_known_than_its_orbit(slow):
    """x := x + slow (0.3 - x), known to round-off over slow, and y := -(r + x) y, which doubles at r = 0.7."""
    system = mapped({x: x + slow * (0.3 - x), y: -(r + x) * y - y**3}, {"r": 0.5}, [0.3, 0.0])
    branch = cd.continue_orbit(system, {"r": (0.4, 0.93)}, start="guess")
    assert kinds(branch) == [Special.PERIOD_DOUBLING]
    off, error = abs(float(branch["special_value"][0]) - 0.7), float(branch["special_error"][0])
    assert off <= error < 1e-12 / slow


@pytest.mark.parametrize("size", [1.0, 1 / 64])
def test_a_branch_of_a_flow_goes_on_through_its_folds_in_any_unit(size):
    """Cycles with mu = 8 q^3 - h q, q = r^2 - 1, fold twice; planes across the flow move along them on the way."""
    q0, h, w = -0.3165710539858352, 0.7118216247002567, 1.2883192254392675
    rate = f"(mu - ((x - 0.8)**2 + (y/{size!r})**2 - 1)**3*8 + ((x - 0.8)**2 + (y/{size!r})**2 - 1)*h)"
    system = cd.HybridSystem(
        name="folded", states="y x z", parameters={"mu": 8 * q0**3 - h * q0, "h": h},
        modes={
            "on": {
                "y": f"y*{rate} + {w * size!r}*(x - 0.8)",
                "x": f"(x - 0.8)*{rate} - {w / size!r}*y",
                "z": "-z + 0.3*(x - 0.8)",
            }
        },
    )  # fmt: skip
    start = np.sqrt(1 + q0) * np.exp(2.571j)
    system = system.with_initial(x=0.8 + start.real, y=size * start.imag, z=(0.3 * start / (1 + 1j * w)).real)
    branch = cd.continue_orbit(system, {"mu": (-0.147, 0.147)}, start="guess", step=0.003)
    fold = 2 * h / 3 * np.sqrt(h / 24)
    assert (branch["mu"].values.min(), branch["mu"].values.max()) == (-0.147, 0.147)
    np.testing.assert_allclose(np.sort(branch["special_value"]), [-fold, fold], rtol=1e-12)


@pytest.mark.parametrize("start", [(1.78575683, 0.09231752), (-1.79026362, -0.0634159)])
def test_a_branch_ends_at_a_canard_and_says_so_wherever_its_orbits_begin(start):
    """Van der Pol's oscillator explodes at 1 - k/8 - 3 k^2/32 - 173 k^3/1024 - ... (Zvonkin and Shubin 1984,
    doi:10.1070/RM1984v039n02ABEH003091)."""
    system = cd.HybridSystem(
        name="canard", states="x y", parameters={"a": 0.9, "k": 0.05}, initial=dict(zip("xy", start, strict=True)),
        modes={"m": {"x": "y - x**3/3 + x", "y": "k*(a - x)"}},
    )  # fmt: skip
    branch = cd.continue_orbit(system, {"a": (0.8, 1.1)}, start="guess")
    values = branch["a"].values
    assert values[-1] == values.max() == pytest.approx(1 - 0.05 / 8 - 3 * 0.05**2 / 32 - 173 * 0.05**3 / 1024, abs=1e-5)
    assert (np.diff(branch["period_time"].values) > 0).all()
    assert branch["branch_end"].values.tolist() == [BranchEnd.NO_CONVERGENCE]
    assert "canard" in branch["branch_end_text"].item()


@pytest.mark.parametrize("size", [1e-9, 1.0])
def test_a_fold_behind_logarithms(size):
    """u -> u + k - u^2 in x = exp(u)."""
    u = sympy.log(x / unit)
    fold = mapped({x: unit * sympy.exp(u + r - u**2)}, {"r": 0.25, "unit": size}, [size * np.exp(0.5)])
    branch = cd.continue_orbit(fold, {"r": (-0.5, 0.5)}, start="guess")
    assert kinds(branch) == [Special.FOLD]
    assert abs(branch["special_value"].item()) <= branch["special_error"].item() < 1e-12


def test_a_map_that_overflows_has_no_orbit():
    """No x is exp(sqrt(x)): s^2 < exp(s)."""
    upward = mapped({x: sympy.exp(sympy.sqrt(x)) + r}, {"r": 0.0}, [1.5])
    branch = cd.continue_orbit(upward, {"r": (0.0, 0.1)}, start="guess")
    assert branch.sizes["point"] == 0
    assert branch.attrs["message"]


@pytest.mark.parametrize("step", [0.02, 0.04])
def test_a_doubled_branch_ends_where_its_halves_coincide(step):
    """x := -(1 + (1 - k^2) / 4) x + x^3: the doubled orbit is x^2 = (1 - k^2) / 4, from one doubling to the other."""
    system = mapped({x: -(1 + (1 - r**2) / 4) * x + x**3, y: y / 3 + x}, {"r": -1.3}, [0.0, 0.0])
    branch = cd.continue_orbit(system, {"r": (-2.0, 2.0)}, start="guess", doublings=1, step=step)
    assert branch["branch_end"].values.tolist() == [BranchEnd.LIMIT, BranchEnd.DOUBLING]
    words = branch["branch_end_text"].values[1].rstrip(").").split()
    error = float(words[-1])
    assert error < 1e-11
    last = branch.isel(point=int(np.flatnonzero(branch["branch"] == 1)[-1]))
    assert abs(float(last["r"]) - 1) <= error
    assert abs(float(last["orbit_state"][0])) < 1e-5


# A state that stays at zero has the unit of what it would do elsewhere.


CORNER = [{x: x / 2 + y + mu * unit, y: 0 * x}, {x: y - x / 2 + mu * unit, y: -x / 4}]
ELSEWHERE = {
    "pitchfork": ({x: x + mu * x - x**3 / unit**2}, Special.BRANCH_POINT, 3, lambda m, u: u * (u**2 - m)),
    "transcritical": ({x: x + mu * x - x**2 / unit}, Special.BRANCH_POINT, 3, lambda m, u: u * (u - m)),
    "flip": ({x: -x - mu * x + x**3 / unit**2}, Special.PERIOD_DOUBLING, 2, lambda m, u: u * (u**2 - m)),
    "corner": (CORNER, Special.OUTCOME_SWITCH, 1, lambda m, u: u - m / np.where(m < 0, 0.5, 1.75)),
}


@pytest.mark.parametrize(("images", "kind", "count", "off"), ELSEWHERE.values(), ids=ELSEWHERE)
def test_branches_of_orbits_at_zero_are_the_same_in_any_unit(images, kind, count, off):
    """Whole branches of closed forms in u = x / unit, with one special point at mu = 0 and as many points."""
    corner = isinstance(images, list)
    begin = [-0.6, 0.0] if corner else [0.0]
    given = {"mu": -0.3, "unit": 1.0}
    system = stepped(images, given, begin, x <= 0) if corner else mapped(images, given, begin)
    points = set()
    for size in (1e-9, 1.0, 1e9):
        here = system.with_parameters(unit=size).with_initial(x=begin[0] * size)
        branch = cd.continue_orbit(here, {"mu": (-0.4, 0.4)}, start="guess", doublings=1, step=0.05)
        points.add(branch.sizes["point"])
        assert (kinds(branch), len(branch["branch_end"])) == ([kind], count)
        assert abs(branch["special_value"].item()) <= branch["special_error"].item()
        assert np.abs(off(branch["mu"].values, branch["orbit_state"].values[:, 0] / size)).max() < 1e-9
        for one in range(count):
            assert np.abs(branch["mu"].values[branch["branch"].values == one]).max() == 0.4
    assert len(points) == 1


# A sign change is found whatever the function is like.


@settings(max_examples=200)
@given(root=st.floats(0.001, 0.999), power=st.sampled_from([1 / 3, 1, 3, 9]), jump=st.floats(0, 10))
def test_a_bracketed_root_is_found_without_an_exception(root, power, jump):
    calls = []

    def function(place):
        calls.append(place)
        away = place - root
        return np.sign(away) * (jump + abs(away) ** power)

    assert abs(bracketed(function, 0.0, 1.0) - root) < 1e-12 + 1e-16 ** (1 / max(power, 1))
    assert len(calls) <= 202


def test_a_test_function_that_fails_stops_nothing(monkeypatch):
    """The logistic map doubles its period at 3, whatever somebody else looks for."""

    def broken(segment):
        raise ZeroDivisionError("no value")

    monkeypatch.setattr(crossings, "TESTS", [crossings.BranchTest(Special.LEVEL, broken, np.abs), *crossings.TESTS])
    branch = cd.continue_orbit(mapped({x: r * x * (1 - x)}, {r: 2.8}, [0.6]), {"r": (2.8, 3.2)})
    assert kinds(branch) == [Special.PERIOD_DOUBLING]
    assert float(branch["special_value"][0]) == pytest.approx(3.0, abs=1e-11)
    assert branch.attrs["message"].count("the test function of a level failed: ZeroDivisionError('no value')") == 1
