"""Soft or hard: coefficients of normal forms, against closed forms in several coordinates."""

from types import SimpleNamespace

import numpy as np
import pytest
import sympy
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import chaosdrill as cd
from chaosdrill.dataset.branches import Criticality, Special
from chaosdrill.orbits.criticality import _terms, extrapolated
from chaosdrill.orbits.problem import LostError

x, y, mu, c, unit, angle, bend = sympy.symbols("x y mu c unit angle bend", real=True)


def bent(image, size=1.0):
    """A map of (u, v) in other coordinates, x = size (1 + u + bend v^2), y = size (1 + v + (u + bend v^2)^2 / 4)."""
    along = x / unit - 1
    v = y / unit - 1 - along**2 / 4
    mapped, other = image(along - bend * v**2, v)
    first = mapped + bend * other**2
    return cd.Map(
        states=(x, y), images={x: unit * (1 + first), y: unit * (1 + other + first**2 / 4)}, name="bent",
        parameters={"mu": -0.1, "c": 1.0, "unit": size, "bend": 0.0, "angle": 1.0}, initial={x: size, y: size},
    )  # fmt: skip


def turned(u, v):
    growth = 1 + mu - c * (u**2 + v**2)
    return growth * (sympy.cos(angle) * u - sympy.sin(angle) * v), growth * (
        sympy.sin(angle) * u + sympy.cos(angle) * v
    )


SYSTEMS = {
    Special.PERIOD_DOUBLING: bent(lambda u, v: (-(1 + mu) * u + c * u**3 + u * v, v / 2 + u**2 / 5)),
    Special.BRANCH_POINT: bent(lambda u, v: ((1 + mu) * u - c * u**3 + u * v, v / 2 + u**2 / 5)),
    Special.NEIMARK_SACKER: bent(turned),
}
# what the slaved direction adds: v = h u^2 with h (1 - 1/2) = 1/5, so that u v = 2/5 u^3
SLAVED = {Special.PERIOD_DOUBLING: 0.4, Special.BRANCH_POINT: -0.4, Special.NEIMARK_SACKER: 0.0}

away = (x / unit - c) * (x / unit + 2)
QUINTIC = cd.Map(
    states=(x,),
    parameters={"mu": -0.1, "c": 0.0, "unit": 1.0},
    images={x: x + unit * (mu * away + away**5)},
    initial={x: 0.0},
)


@settings(max_examples=6)
@given(
    kind=st.sampled_from(list(SYSTEMS)), cubic=st.floats(-3, 3), curve=st.floats(-1, 1),
    size=st.sampled_from([1.0, 1e-6, 1e5]), step=st.floats(0.01, 0.05),
    turn=st.floats(0.3, 2.8).filter(lambda a: min(abs(a - np.pi / 2), abs(a - 2 * np.pi / 3)) > 0.05),
)  # fmt: skip
def test_criticality_is_that_of_the_normal_form_in_any_coordinates(kind, cubic, curve, size, step, turn):
    exact = cubic + SLAVED[kind]
    assume(abs(exact) > 0.01)
    system = SYSTEMS[kind].with_parameters(c=cubic, unit=size, bend=curve, angle=turn).with_initial(x=size, y=size)
    branch = cd.continue_orbit(system, {"mu": (-0.15, 0.1)}, start="guess", step=step)
    assert branch["special_kind"].values.tolist() == [kind]
    expected = Criticality.SUPERCRITICAL if exact > 0 else Criticality.SUBCRITICAL
    assert int(branch["special_criticality"][0]) == expected
    assert expected.advice in str(branch["special_text"].values[0])
    # a circle of radius r is sqrt(2) r long in a critical eigenvector of length 1
    coefficient = 2 * exact if kind == Special.NEIMARK_SACKER else exact
    assert abs(branch["special_coefficient"].values[0] - coefficient) <= branch["special_coefficient_error"].values[0]


def special(system, sweep, kind, **given):
    branch = cd.continue_orbit(system, sweep, start="guess", **given)
    return branch.isel(special=np.flatnonzero(branch["special_kind"].values == kind)[0])


@pytest.mark.parametrize(
    ("power", "expected"), [(2, Criticality.TRANSCRITICAL), (3, Criticality.SUBCRITICAL), (5, Criticality.UNDECIDED)]
)
def test_what_crosses_a_state_at_rest(power, expected):
    system = cd.Map(states=(x,), parameters={"mu": -0.1}, images={x: (1 + mu) * x + x**power}, initial={x: 0.0})
    found = special(system, {"mu": (-0.2, 0.15)}, Special.BRANCH_POINT)
    assert int(found["special_criticality"]) == expected


@pytest.mark.parametrize("place", [0.0, 0.01, -0.3, 0.49])
@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e5])
def test_without_a_cubic_term_nothing_is_told_wherever_the_state_is(place, unit):
    found = special(
        QUINTIC.with_parameters(c=place, unit=unit).with_initial(x=place * unit),
        {"mu": (-0.2, 0.15)},
        Special.BRANCH_POINT,
    )
    assert not abs(found["special_coefficient"]) > found["special_coefficient_error"]
    assert int(found["special_criticality"]) == Criticality.UNDECIDED


@pytest.mark.parametrize(("place", "unit"), [(1.6e-270, 1.0), (5e-324, 1e5), (0.1, 1e-160)])
def test_states_as_small_as_numbers_can_be_have_their_branches(place, unit):
    system = QUINTIC.with_parameters(c=place, unit=unit).with_initial(x=place * min(unit, 1.0))
    found = special(system, {"mu": (-0.2, 0.15)}, Special.BRANCH_POINT)
    assert abs(float(found["special_value"])) < 1e-15


@pytest.mark.parametrize("decayed", [1e-264, 5e-324])
def test_a_pitchfork_beside_a_state_that_has_decayed(decayed):
    system = cd.Map((x, y), {"mu": -0.1}, {x: (1 + mu) * x - x**3, y: y / 2}, initial={x: 0.0, y: decayed})
    branch = cd.continue_orbit(system, {"mu": (-0.2, 0.15)}, start="guess", step=0.05)
    assert branch.cd.words("special_criticality").values.tolist() == ["supercritical"]
    assert abs(branch["special_value"].item()) < 1e-15


def test_the_logistic_map_doubles_softly():
    """Slope -1 and second derivative -6 at 2/3: the coefficient is 6^2 / 4 = 9, in parts of 2/3."""
    system = cd.Map(states=(x,), parameters={"mu": 2.9}, images={x: mu * x * (1 - x)}, initial={x: 1 - 1 / 2.9})
    found = special(system, {"mu": (2.5, 3.2)}, Special.PERIOD_DOUBLING)
    assert int(found["special_criticality"]) == Criticality.SUPERCRITICAL
    assert abs(float(found["special_coefficient"]) - 4) <= float(found["special_coefficient_error"]) < 1e-6


def test_the_delayed_logistic_map():
    """Kuznetsov 2023, section 4.7: a(0) = -2 at r = 2, for a q of square 2 about (1/2, 1/2)."""
    system = cd.Map(
        states=(x, y),
        parameters={"mu": 1.9},
        images={x: mu * x * (1 - y), y: x},
        initial={x: 1 - 1 / 1.9, y: 1 - 1 / 1.9},
    )
    found = special(system, {"mu": (1.7, 2.2)}, Special.NEIMARK_SACKER)
    assert float(found["special_value"]) == pytest.approx(2, abs=1e-11)
    assert int(found["special_criticality"]) == Criticality.SUPERCRITICAL
    assert abs(float(found["special_coefficient"]) - 2 / 2 / 4) <= float(found["special_coefficient_error"]) < 1e-6


LOGISTIC = {x: mu * x * (1 - x / unit)}
CUBIC = {x: x**3 / unit**2 - mu * x}
GOLDEN = (1 + 5**0.5) / 2
ROOT = 1 + 6**0.5
CYCLES = {
    "logistic": (
        LOGISTIC,
        3.4,
        ROOT,
        (ROOT + 1 + ((ROOT - 3) * (ROOT + 1)) ** 0.5 * np.array([1, -1])) / (2 * ROOT),
        Special.PERIOD_DOUBLING,
    ),
    "pitchfork": (CUBIC, 1.8, 2.0, np.array([1.0, -1.0]), Special.BRANCH_POINT),
    "cubic": (CUBIC, 2.1, 5**0.5, np.array([GOLDEN**0.5, -(GOLDEN**-0.5)]), Special.PERIOD_DOUBLING),
}


@pytest.mark.parametrize("size", [1.0, 1e-6])
@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.parametrize("name", CYCLES)
def test_a_coefficient_depends_on_no_point_of_a_cycle(name, first, size):
    """The Schwarzian derivatives S on a cycle, by the chain rule, for an eigenvector v of mean square 1: -S v^2 / 6."""
    image, begin, point, cycle, kind = CYCLES[name]
    step = sympy.lambdify((x, mu), image[x].xreplace({unit: 1}))
    one, two, three = (sympy.lambdify((x, mu), sympy.diff(image[x].xreplace({unit: 1}), x, n)) for n in (1, 2, 3))
    assert step(cycle[0], point) == pytest.approx(cycle[1])
    slope = one(cycle, point)
    schwarzian = three(cycle, point) / slope - 1.5 * (two(cycle, point) / slope) ** 2
    squares = np.array([1, slope[0] ** 2]) * 2 / (1 + slope[0] ** 2) * np.mean(cycle**2)
    place = cycle[0]
    for _ in range(1000 + first):
        place = step(place, begin)
    system = cd.Map((x,), {"mu": begin, "unit": size}, image, initial={x: size * place})
    found = special(system, {"mu": (begin - 0.04, point + 0.03)}, kind, period=2)
    assert int(found["special_criticality"]) == Criticality.SUPERCRITICAL
    coefficient, error = (found[f"special_coefficient{name}"].item() for name in ("", "_error"))
    assert abs(coefficient + schwarzian @ squares / 6) <= error


def test_a_coefficient_depends_on_no_time_at_which_an_orbit_begins():
    """The Roessler system: its first doubling, from three points of the cycle, one in other units."""
    z = sympy.Symbol("z", real=True)
    system = cd.HybridSystem(
        states=(x, y, z), parameters={"mu": 2.8, "unit": 1.0}, name="roessler",
        modes={"free": {x: -y - z, y: x + y / 5, z: unit / 5 + z * (x / unit - mu)}},
        initial={"mode": "free", x: -2.0, y: -2.0, z: 0.1},
    )  # fmt: skip
    path = cd.trajectory(system, transient=300.0, duration=4.0, samples=3)["states"].values[-3:]
    found = []
    for state, size in zip(path, (1.0, 1.0, 1e3), strict=True):
        scaled = dict(zip((x, y, z), (size * state).tolist(), strict=True))
        begun = system.with_parameters(unit=size).with_initial(**{s.name: v for s, v in scaled.items()})
        found.append(special(begun, {"mu": (2.75, 2.9)}, Special.PERIOD_DOUBLING, step=0.05))
    values = np.array([one["special_coefficient"].item() for one in found])
    # third differences at 1e-2 of a map with the accuracy 1e-13
    np.testing.assert_allclose(values, values[0], rtol=1e-8)


@pytest.mark.parametrize("turn", [np.pi / 2, 2 * np.pi / 3])
def test_a_strong_resonance_is_undecided(turn):
    system = SYSTEMS[Special.NEIMARK_SACKER].with_parameters(angle=turn)
    found = special(system, {"mu": (-0.2, 0.15)}, Special.NEIMARK_SACKER)
    assert int(found["special_criticality"]) == Criticality.UNDECIDED


def test_across_impacts_the_doubled_orbit_lies_where_the_coefficient_says():
    system = cd.build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "omega": 2.64, "e": 0.8})
    branch = cd.continue_orbit(system, {"omega": (2.6, 2.69)}, doublings=1, max_points=400)
    owner, values, stable = branch["branch"].values, branch["omega"].values, branch["stable"].values
    doublings = np.flatnonzero(branch["special_kind"].values == Special.PERIOD_DOUBLING)
    at, index = branch["special_value"].values[doublings], branch["special_index"].values[doublings]
    for born in range(1, branch.sizes["branch_number"]):
        near = values[owner == born][:3]
        k = int(np.abs(at - near[0]).argmin())
        beside = [j for j in range(index[k] - 3, index[k] + 4) if j != index[k] and owner[j] == owner[index[k]]]
        repels = [j for j in beside if (values[j] - at[k]) * (near[-1] - at[k]) > 0 and not stable[j]]
        soft = int(branch["special_criticality"].values[doublings[k]]) == Criticality.SUPERCRITICAL
        assert bool(repels) == soft
    assert branch.sizes["branch_number"] > 1


@pytest.mark.parametrize("beside", [0.0, 1e-16])
def test_two_multipliers_with_one_vector_have_no_coefficient(beside):
    """At a 1:2 resonance the left and the right vector are at a right angle, to rounding or exactly."""
    returns = SimpleNamespace(basis=np.eye(2), derivative=lambda deviation: np.array([[-1.0, 1.0], [beside, -1.0]]))
    with pytest.raises(np.linalg.LinAlgError):
        _terms(returns, lambda values: np.abs(values + 1))


@pytest.mark.parametrize("room", [0.2, 1e-3, 1e-4])
def test_differences_are_taken_where_there_is_room(room):
    """Beside a population that nearly dies out most displacements lead below zero, where motions run away."""

    def beside(distance):
        if distance > room:
            raise LostError
        return np.array([np.sinh(distance) / distance])

    (value,), (error,), _ = extrapolated(beside)
    assert abs(value - 1) <= error < 1e-9
