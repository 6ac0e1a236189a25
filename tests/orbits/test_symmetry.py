"""Symmetric systems over half of their motion: orbits, multipliers and pitchforks are those of the whole system."""

from math import acos, atan2, cos, exp, hypot, pi, sin, sqrt

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve

import chaosdrill as cd
from chaosdrill.dataset.branches import Special

ODD = {"x": "-x", "v": "-v"}


def multipliers(ds):
    return np.sort_complex(ds["multiplier_real"].values + 1j * ds["multiplier_imag"].values)


def found(system, **arguments):
    ds = cd.periodic_orbit(system, **arguments)
    assert int(ds["outcome"]) == cd.Outcome.PERIODIC, ds.attrs["message"]
    return ds


def impact_pair_half_map(gap, amplitude, omega, e):
    """Tangent map over half a period of the motion with one hit on each wall a period: in closed form."""
    a, b = -pi * (1 + e) / (1 - e), 2.0
    # gap = (amplitude/omega^2) (a sin(phase) + b cos(phase)) at the hit on the left wall
    phase = atan2(a, b) - acos(gap * omega**2 / amplitude / hypot(a, b))
    speed, half, push = -2 * e / (1 - e) * amplitude / omega * sin(phase), pi / omega, amplitude * cos(phase)
    met = speed / e
    time = np.array([(speed + push * half) / met, -half / met])
    return np.array([time, e * (np.array([-push, 1.0]) - push * time)])


@pytest.fixture(scope="module")
def pair():
    return cd.build("impact-pair").with_parameters(amplitude=0.3, e=0.6)


def test_multipliers_of_half_the_motion_are_roots_of_those_of_the_whole(pair):
    half, whole = found(cd.halved(pair, ODD)), found(pair)
    exact = np.sort_complex(np.linalg.eigvals(impact_pair_half_map(1.0, 0.3, 1.0, 0.6)).astype(complex))
    ours = multipliers(half)
    ours = np.delete(ours, np.abs(ours).argmin())
    np.testing.assert_allclose(ours, exact, rtol=1e-9)
    np.testing.assert_allclose(np.sort_complex(ours**2), multipliers(whole), rtol=1e-9)
    np.testing.assert_allclose(half["orbit_state"][:2], whole["orbit_state"], rtol=1e-10)
    assert float(half["period_time"]) == pytest.approx(pi, rel=1e-13)


def test_symmetry_is_lost_where_the_half_map_has_a_multiplier_of_minus_one(pair):
    exact = brentq(lambda a: np.linalg.det(impact_pair_half_map(1.0, a, 1.0, 0.6) + np.eye(2)), 0.3, 0.4, xtol=1e-14)
    half = cd.continue_orbit(cd.halved(pair, ODD), {"amplitude": (0.28, 0.4)}, doublings=1)
    kinds = half["special_text"].values
    at = [
        k
        for k, text in enumerate(kinds)
        if "twice the period" in text and half["branch"][half["special_index"][k]] == 0
    ]
    assert len(at) == 1
    assert float(half["special_value"][at[0]]) == pytest.approx(exact, abs=1e-11)
    assert half["special_criticality"][at[0]] == 1
    # the doubled orbit holds both partners, each of which is an orbit of the whole system
    both = half.isel(point=int(np.flatnonzero(half["branch"].values == 1)[-1]))
    amplitude, states = float(both["amplitude"]), both["section"].values[:2, :2]
    assert amplitude > exact
    assert np.abs(states[0] - states[1]).max() > 0.01
    one = [
        found(pair.with_parameters(amplitude=amplitude).with_initial(list(state)), start="guess") for state in states
    ]
    for state, ds in zip(states, one, strict=True):
        np.testing.assert_allclose(ds["orbit_state"], state, rtol=1e-9)
    np.testing.assert_allclose(multipliers(one[0]), multipliers(one[1]), rtol=1e-7)


def test_a_section_that_the_symmetry_keeps_is_that_of_the_whole_motion(pair):
    at, half = "x**2 > 0.25", cd.halved(pair, ODD)
    ours, whole = (cd.poincare_section(one, at=at, periods=8, transient=200) for one in (half, pair))
    assert float(ours["return_time"]) == pytest.approx(float(whole["return_time"]), rel=1e-12)
    np.testing.assert_allclose(abs(ours["section"][:, :2]), abs(whole["section"]), rtol=1e-9)


@pytest.mark.parametrize("at", ["x > 0", "x - v > 0.1", "x*sin(omega*t) > 0"])
def test_a_reflection_crosses_no_surface(pair, at):
    with pytest.raises(cd.SettingsError, match="the reflection 'half-free' throws states across it"):
        cd.poincare_section(cd.halved(pair, ODD), at=at, periods=8)
    with pytest.raises(cd.SettingsError, match=r"until is .* throws states across it"):
        cd.transient_chaos(cd.halved(pair, ODD), until=at, duration=8, initial=[{"x": 0.1}])


@pytest.mark.parametrize("at", ["x > 0", "-x > 0", "2*x < 0"])
def test_the_surface_of_a_reflection_is_named_by_it(at):
    with pytest.raises(cd.SettingsError, match="name that, as in at='half-flow'"):
        cd.poincare_section(cd.halved(cd.build("lorenz"), {"x": "-x", "y": "-y"}), at=at, periods=8)


WALLS = cd.HybridSystem(
    name="two-sided oscillator",
    states="x v",
    parameters={"zeta": 0.05, "omega": 1.8, "e": 0.7, "f": 2.4},
    modes={"free": {"x": "v", "v": "-x - 2*zeta*v + f*cos(omega*t)"}},
    transitions=[
        cd.Transition("right", "free", "free", "x - 1", 1, {"v": "-e*v"}),
        cd.Transition("left", "free", "free", "x + 1", -1, {"v": "-e*v"}),
    ],
    period="2*pi/omega",
    initial={"x": 0.0, "v": 1.5},
)


def drift(time, zeta=0.05):
    """Motion without the force over a time, shape (2, 2), also of a complex one."""
    w, decay = sqrt(1 - zeta**2), np.exp(-zeta * time)
    c, s = np.cos(w * time), np.sin(w * time) / w
    return decay * np.array([[c + zeta * s, s], [-s, c - zeta * s]])


def forced(time, f, omega, zeta=0.05):
    """The forced motion."""
    swing = f / (1 - omega**2 + 2j * zeta * omega)
    c, s = np.cos(omega * time), np.sin(omega * time)
    return np.array([swing.real * c - swing.imag * s, -omega * (swing.real * s + swing.imag * c)])


def symmetric_fold(zeta=0.05, omega=1.8, e=0.7):
    """The force at which two symmetric orbits with a hit on each wall begin: where b below is a double root.

    With x_p, v_p the forced motion at the hit, and b = e w + v_p for a hit at the speed w: half a period later all is
    reversed, so that w = kappa b and 1 - x_p = lambda b.
    """
    (p, q), (r, s) = drift(pi / omega, zeta)
    slope = q / (1 + p)
    speed = (1 + s - r * slope) / (1 + e)
    across = (1 - e * speed) / omega
    return abs(across) / hypot(slope, across) * hypot(1 - omega**2, 2 * zeta * omega)


def hits(unknowns, f, walls, turns, omega, sign=1.0, e=0.7):
    """What is left where hits on these walls, rows (time, speed), do not lead to each other, shape (2 N,).

    Where ``turns`` is a half, the last one leads to the image of the first; to ``sign`` times a deviation of it.
    """
    rows, left = unknowns.reshape(-1, 2), []
    again = rows[0].real + 1j * sign * rows[0].imag + np.array([2 * pi / omega * turns, 0.0])
    following = [*zip(walls[1:], rows[1:], strict=True), (walls[0] if turns >= 1 else -walls[0], again)]
    for wall, (time, speed), (other, (later, faster)) in zip(walls, rows, following, strict=True):
        begun = np.array([wall, -e * speed * wall]) - forced(time, f, omega)
        end = drift(later - time) @ begun + forced(later, f, omega)
        left += [end[0] - other, end[1] * other - faster]
    return np.array(left)


def where_hits_come_back(branch, number, omega, sign=-1.0, e=0.7):
    """The force at a special point where a multiplier is ``sign``, in closed form; the orbit before it is the guess."""
    point = branch.isel(point=int(branch["special_index"][number]) - 1)
    turns = 0.5 if branch["special_kind"][number] == Special.BRANCH_POINT else int(point["period"])
    near = float(point["f"])
    system = WALLS.with_parameters(f=near, omega=omega, e=e).with_initial(list(point["orbit_state"].values))
    start = found(system, period=max(1, turns), start="guess")
    before = start["event_state_before"].values
    count = len(before) // (1 if turns >= 1 else 2)
    walls = before[:count, 0].round().tolist()
    seen = np.stack([start["event_time"].values, np.abs(before[:, 1])], axis=1)[:count]

    def left(unknowns):
        moved = unknowns[:-1] + 1e-30j * np.eye(len(unknowns) - 1)
        # a deviation that comes back as it was, or with the opposite sign
        back = np.array([hits(one, unknowns[-1], walls, turns, omega, sign, e).imag / 1e-30 for one in moved])
        size = np.prod(np.linalg.norm(back, axis=1))
        missed = hits(unknowns[:-1] + 0j, unknowns[-1], walls, turns, omega, e=e).real
        return np.append(missed, np.linalg.det(back) / size)

    answer, told, _, _ = fsolve(left, [*seen.ravel(), near], xtol=1e-13, full_output=True)
    assert np.abs(told["fvec"]).max() < 1e-9
    return answer[-1]


def of_kind(branch, kind):
    return branch["special_value"].values[branch["special_kind"].values == kind]


def test_an_event_that_passes_the_reflection_is_no_special_point():
    half = cd.halved(WALLS, ODD)
    branch = cd.continue_orbit(half.with_parameters(f=1.0), {"f": (0.34, 1.2)})
    assert set(branch["event_sequence"].values) == {"half-free right", "half-free left"}
    assert branch["special_kind"].values.tolist() == [Special.FOLD]
    assert abs(float(branch["special_value"][0]) - symmetric_fold()) < 1e-12


def test_the_cascades_of_both_partners():
    """A plain call gives the pitchfork, both partners, and their doublings: twice those of the halved system."""
    system, limits = WALLS.with_parameters(omega=1.4, f=6.2), {"f": (6.1, 7.3)}
    whole = cd.continue_orbit(system, limits, doublings=2)
    half = cd.continue_orbit(cd.halved(system, ODD), limits, doublings=3)
    lost, partners = (of_kind(whole, kind) for kind in (Special.BRANCH_POINT, Special.PERIOD_DOUBLING))
    assert len(lost) == 1
    assert len(partners) == 6
    np.testing.assert_allclose(of_kind(half, Special.PERIOD_DOUBLING), [*lost, *np.sort(partners)[::2]], atol=1e-10)
    np.testing.assert_allclose(np.sort(partners)[1::2], np.sort(partners)[::2], atol=1e-10)
    for k in (0, 1, 4):
        assert float(whole["special_value"][k]) == pytest.approx(where_hits_come_back(whole, k, 1.4), abs=1e-10)


def touch_of_the_last_hit(branch, number, system, omega, e, beyond=2):
    """The force at which the last of the hits on one wall has no speed, in closed form; a guess is an orbit beyond."""
    point = branch.isel(point=int(branch["special_index"][number]) + beyond)
    near = system.with_parameters(f=float(point["f"])).with_initial(list(point["orbit_state"].values[:2]))
    orbit = found(near, start="guess")
    times, before, period = orbit["event_time"].values, orbit["event_state_before"].values, 2 * pi / omega
    walls = before[:, 0].round()
    first = int(np.flatnonzero(walls != np.roll(walls, 1))[0])
    times = np.roll(np.where(np.arange(len(times)) < first, times + period, times), -first)
    count = len(times) // 2
    rows = np.stack([times, np.abs(np.roll(before[:, 1], -first))], axis=1)[:count]
    rows[:, 0] += period / 2 * (walls[first] < 0)

    def left(unknowns):
        missed = hits(unknowns[:-1] + 0j, unknowns[-1], [1.0] * count, 0.5, omega, e=e).real
        return np.append(missed, unknowns[2 * count - 1])

    answer, told, _, _ = fsolve(left, np.append(rows, float(point["f"])), xtol=1e-14, full_output=True)
    assert np.abs(told["fvec"]).max() < 1e-12
    return answer[-1]


@pytest.fixture(scope="module")
def symmetric_walk():
    return cd.continue_orbit(WALLS.with_parameters(omega=1.4, e=0.5, f=5.0), {"f": (1.0, 13.0)})


def once(branch, within=(0.0, np.inf)):
    """The special points of a branch in order, shape (S, 2): kind and place; none of them stands twice."""
    values = branch["special_value"].values
    states = branch["orbit_state"].values[branch["special_index"].values, :2]
    both = np.column_stack([values, states])
    apart = np.abs(both[:, np.newaxis] - both).max(axis=2) + np.eye(len(both))
    assert apart.min(initial=1) > 1e-8
    inside = (values > within[0]) & (values < within[1])
    order = np.argsort(values[inside])
    return np.column_stack([branch["special_kind"].values, values])[inside][order]


def test_a_walk_along_symmetric_orbits_is_the_same_from_either_end(symmetric_walk):
    """Where both walls are touched at once partners begin as well, which are no part of it."""
    walk = cd.continue_orbit(WALLS.with_parameters(omega=1.4, e=0.5, f=9.8), {"f": (2.0, 12.0)}, step=0.1)
    within = (2.2, 11.0)
    np.testing.assert_allclose(once(walk, within), once(symmetric_walk, within), rtol=1e-9)
    assert all(one.count("left") == one.count("right") for one in walk["event_sequence"].values)


def test_grazings_pile_up_on_the_way_to_complete_chatter(symmetric_walk):
    """Each adds a hit on either wall; their distances tend to shrink by e, as the speeds of hits do in chatter."""
    assert "pile up" in str(symmetric_walk["branch_end_text"].values[0])
    kinds, system = symmetric_walk["special_kind"].values, WALLS.with_parameters(omega=1.4, e=0.5)
    touched = np.flatnonzero((kinds != Special.FOLD) & (kinds != Special.BRANCH_POINT))
    values, errors = (symmetric_walk[name].values[touched] for name in ("special_value", "special_error"))
    assert len(values) >= 20
    assert (np.diff(values) > 0).all()
    assert np.diff(values)[20] / np.diff(values)[19] == pytest.approx(0.5, abs=0.01)
    for k, beyond in ((0, 6), (1, 6), (2, 6), (7, 2), (13, 2), (15, 2), (18, 2)):
        exact = touch_of_the_last_hit(symmetric_walk, touched[k], system, 1.4, 0.5, beyond)
        assert abs(values[k] - exact) <= errors[k] < 2e-7


@pytest.mark.parametrize("limits", [(1.0, 13.0), (2.0, 40.0)])
def test_a_walk_along_partners_leads_through_the_pitchfork_and_the_double_touch_back_to_its_start(limits):
    """Each graze once more, at the place of the other: two pairs of states at one force."""
    branch = cd.continue_orbit(WALLS.with_parameters(omega=1.4, e=0.5, f=2.4), {"f": limits})
    points = once(branch)
    assert points[:, 0].tolist() == [Special.BRANCH_POINT, Special.GRAZING, Special.GRAZING, Special.GRAZING]
    assert abs(points[1, 1] - points[2, 1]) < 1e-10
    assert "closed" in str(branch["branch_end_text"].values[0])


@pytest.mark.parametrize(("f", "step"), [(2.7, None), (2.9, 0.08)])
def test_what_happens_just_before_a_touch_is_found_whatever_the_step(f, step):
    """Doubling, fold and touch within 5e-7 of the force: multipliers go to infinity at the touch."""
    e = 0.5665896983747587
    system = WALLS.with_parameters(omega=1.466, e=e, f=f).with_initial(x=-0.11743, v=2.18076)
    branch = cd.continue_orbit(system, {"f": (2.3, 3.1)}, start="guess", step=step)
    kinds, values = branch["special_kind"].values, branch["special_value"].values
    assert sorted(kinds) == [Special.FOLD, Special.PERIOD_DOUBLING, Special.GRAZING]
    assert np.ptp(values) < 5e-7
    for kind, sign in ((Special.PERIOD_DOUBLING, -1.0), (Special.FOLD, 1.0)):
        (number,) = np.flatnonzero(kinds == kind)
        assert abs(values[number] - where_hits_come_back(branch, number, 1.466, sign, e)) < 1e-11


def test_a_pitchfork_stands_once_though_its_partners_come_back_to_it():
    branch = cd.continue_orbit(WALLS.with_parameters(omega=1.4, e=0.5, f=2.2), {"f": (2.0, 6.3)}, doublings=1)
    assert branch["special_kind"].values.tolist().count(Special.BRANCH_POINT) == 2
    assert branch["branch_end_text"].values[1].startswith("The branch returned to its start")
    assert np.bincount(branch["branch"].values[branch["special_index"].values]).tolist() == [4, 3]


def test_a_cycle_that_touches_the_surface_of_the_reflection_goes_on():
    """A cycle of radius sqrt(mu) about x = c, and its image: two reflections a turn from mu = c^2 on."""
    field = {
        "x": "(x - c*z)*(mu - (x - c*z)**2 - y**2) - 2*y + c*z*(1 - z**2)",
        "y": "y*(mu - (x - c*z)**2 - y**2) + 2*(x - c*z)",
        "z": "z*(1 - z**2)",
    }
    given = {"parameters": {"mu": 0.8, "c": 1.0}, "initial": {"x": 1.5, "z": 1.0}}
    system = cd.HybridSystem(name="rings", states="x y z", modes={"on": field}, **given)
    half = cd.halved(system, {"x": "-x", "y": "-y", "z": "-z"})
    branch = cd.continue_orbit(half, {"mu": (0.7, 1.3)})
    assert branch.sizes["special"] == 0
    assert sorted(branch["event_sequence"].values.tolist()) == ["", "half-on half-on"]
    ours = np.sort(branch["multiplier_real"].values, axis=1)
    mu = branch["mu"].values
    exact = np.sort(np.stack([np.exp(-2 * pi * mu), np.full(len(mu), exp(-2 * pi)), np.ones(len(mu))], axis=1), axis=1)
    np.testing.assert_allclose(ours, exact, atol=1e-9)


def test_linear_oscillator_in_closed_form():
    system = cd.HybridSystem(
        states="x v",
        parameters={"zeta": 0.1, "omega": 1.3},
        modes={"on": {"x": "v", "v": "-x - 2*zeta*v + cos(omega*t)"}},
        quadratures={"work": "2*zeta*v**2", "way": "v"},
        transitions=[cd.Transition("middle", "on", "on", "x", 1), cd.Transition("still", "on", "on", "v", 0)],
        period="2*pi/omega",
    )
    half = cd.halved(system, ODD)
    ds = found(half)
    exact = -np.exp((-0.1 + 1j * np.array([-1, 1]) * sqrt(1 - 0.01)) * pi / 1.3)
    ours = multipliers(ds)
    np.testing.assert_allclose(np.delete(ours, np.abs(ours).argmin()), np.sort_complex(exact), rtol=1e-10)
    force = 1 / ((1 - 1.3**2) + 2j * 0.1 * 1.3)
    np.testing.assert_allclose(ds["orbit_state"][:2], [force.real, (1j * 1.3 * force).real], rtol=1e-10)
    # what the symmetry changes is left out
    assert set(half.quadratures) == {"work"}
    assert [t.name for t in half.transitions] == ["still", "half-on"]
    spectrum = cd.lyapunov_spectrum(half, transient=10, periods=200)
    np.testing.assert_allclose(spectrum["lyapunov_exponent"][:2], -0.1, atol=2e-3)


def driven():
    given = {"f": 0.0, "zeta": 0.1, "omega": 0.8}
    field = {"x": "v", "v": "-x - x**3 - 2*zeta*v + f"}
    return cd.driven(
        cd.HybridSystem(name="o", states="x v", time="t", parameters=given, modes={"on": field}, period="2*pi/omega"),
        "f",
        "square",
    )


def between_springs():
    return cd.in_modes(
        name="between springs",
        states="x v",
        time="t",
        parameters={"k": 5.0, "omega": 1.1},
        field={"x": "v", "v": "-x - k*Max(x - 1, 0) - k*Min(x + 1, 0) + 2*cos(omega*t)"},
        period="2*pi/omega",
        initial={"x": 0.2, "v": 0.1},
    )


@pytest.mark.parametrize(
    "make", [lambda: cd.build("impact-pair"), lambda: cd.build("den-hartog"), driven, between_springs]
)
def test_strobe_points_are_those_of_the_system_with_every_second_one_reflected(make):
    system = make()
    whole = cd.poincare_section(system, periods=6)["section"].values
    half = cd.poincare_section(cd.halved(system, ODD), periods=12)["section"].values[:, :2]
    later = cd.trajectory(system, periods=6, samples=2)
    np.testing.assert_allclose(half[1::2], whole, atol=1e-9)
    states, times = later["states"].values, later["time"].values
    middle = states[np.searchsorted(times, (np.arange(6) + 0.5) * system.forcing_period() - 1e-9)]
    np.testing.assert_allclose(half[0::2], -middle, atol=1e-9)


def test_modes_are_exchanged():
    system = cd.build("den-hartog")
    half = cd.halved(system, ODD)
    to = {t.source[0]: t.target for t in half.transitions if t.kind == "half"}
    assert to == {"forward": "backward", "backward": "forward", "stick": "stick"}
    one, both = multipliers(found(half)), multipliers(found(system))
    np.testing.assert_allclose(np.sort_complex(np.delete(one, np.abs(one).argmin()) ** 2), both, rtol=1e-9)


def test_lorenz_loses_its_symmetry_by_another_integrator():
    system = cd.halved(cd.build("lorenz").with_parameters(rho=350.0), {"x": "-x", "y": "-y"})
    branch = cd.continue_orbit(system, {"rho": (300, 360)}, at="half-flow")
    assert branch.sizes["special"] == 1
    rho, point = float(branch["special_value"][0]), branch.isel(point=int(branch["special_index"][0]))
    # Sparrow 1982, The Lorenz Equations: near r = 313
    assert rho == pytest.approx(313, abs=0.1)

    def field(_, y):
        (u, v, w), m = y[:3], y[3:].reshape(3, 3)
        slope = np.array([[-10, 10, 0], [rho - w, -1, -u], [v, u, -8 / 3]])
        return np.concatenate([[10 * (v - u), rho * u - v - u * w, u * v - 8 / 3 * w], (slope @ m).ravel()])

    start = np.concatenate([point["orbit_state"].values, np.eye(3).ravel()])
    end = solve_ivp(field, (0, float(point["period_time"])), start, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    half = np.diag([-1, -1, 1]) @ end[3:].reshape(3, 3)
    near = np.sort(np.linalg.eigvals(half).real)
    np.testing.assert_allclose(near, [-1, -exp(-41 / 3 * float(point["period_time"])), 1], atol=1e-5)


def test_map_in_closed_form():
    # x = -F(x) has x^2 = a - 1 and the multiplier 3 - 2 a: -1 at a = 2
    system = cd.Map("x", {"a": 1.5}, {"x": "-a*x + x**3"}, initial={"x": 0.7})
    half = cd.halved(system, {"x": "-x"})
    assert str(half.images[half.states[0]]) == "a*x - x**3"
    branch = cd.continue_orbit(half, {"a": (1.2, 2.2)})
    np.testing.assert_allclose(branch["special_value"], [2.0], atol=1e-12)
    np.testing.assert_allclose(branch["multiplier_real"][:, 0], 3 - 2 * branch["a"], atol=1e-9)


@pytest.mark.parametrize(("stiffness", "a"), [("sqrt(-a)", -4.0), ("sqrt(a - 100)", 400.0)])
def test_parameters_are_tried_about_their_values(stiffness, a):
    system = cd.HybridSystem(
        name="spring",
        states="x v",
        parameters={"a": a},
        modes={"free": {"x": "v", "v": f"-{stiffness}*((x + 1)**3 - (1 - x)**3) + cos(t)"}},
        period="2*pi",
    )
    assert cd.halved(system, ODD).parameters["a"] == a


def test_a_parameter_that_must_be_zero_is_left_out():
    gear = cd.build("gear-rattle").with_parameters(drag=0.0)
    half = cd.halved(gear, {"s": "backlash - s", "v": "-v"})
    assert set(gear.parameters) - set(half.parameters) == {"drag"}
    with pytest.raises(cd.SettingsError, match="drag"):
        half.with_parameters(drag=0.1)
    assert (
        cd.halved(gear.with_parameters(drag=0.0, beta=0.0), {"s": "backlash - s", "v": "-v"}).parameters["beta"] == 0.0
    )


def two_walls(**changed):
    left = {"guard": "x + 1", "direction": -1, "reset": {"v": "-e*v"}, "condition": "v**2 > e", **changed}
    return cd.HybridSystem(
        name="walls",
        states="x v",
        parameters={"e": 0.5, "f": 0.4},
        modes={"free": {"x": "v", "v": "-x + cos(t)"}},
        transitions=[
            cd.Transition("right", "free", "free", "x - 1", 1, {"v": "-e*v"}, condition="v**2 > e"),
            cd.Transition("left", "free", "free", **left),
        ],
        period="2*pi",
    )


@pytest.mark.parametrize(
    ("system", "symmetry", "told"),
    [
        (
            cd.build("impact-oscillator"),
            ODD,
            "'impact' has no image: the nearest is 'impact', but its guard at the image is -wall - x",
        ),
        (cd.build("duffing"), {"x": "-x"}, "mode 'flow': the image of a motion has the rate -v of x; .* it is v"),
        (cd.build("gear-rattle"), {"s": "backlash - s", "v": "-v"}, "drag"),
        (two_walls(reset={"v": "-f*v"}), ODD, "after it v is f\\*v, the image has e\\*v"),
        (two_walls(condition="v**2 >= e"), ODD, "its condition is v\\*\\*2 >= e"),
        (two_walls(priority=1), ODD, "its priority or what it completes is another"),
        (cd.build("duffing"), {"x": "2*x"}, "applied twice, x becomes 4\\*x; it must be x"),
        (cd.build("duffing"), {"y": "-y"}, "unknown state 'y'"),
        (cd.build("duffing"), {"x": "-t"}, "holds 't'"),
        (cd.build("duffing"), {}, "changes no state"),
        (cd.Map("x", {"a": 1.5}, {"x": "a*x + x**2"}), {"x": "-x"}, "the image of x is"),
    ],
)
def test_what_breaks_the_symmetry_is_told(system, symmetry, told):
    with pytest.raises(cd.ModelError, match=told):
        cd.halved(system, symmetry)


def swapped(bounds):
    return cd.Map("x y", {}, {"x": "y/2", "y": "x/2"}, bounds=bounds)


@pytest.mark.parametrize(
    ("system", "symmetry", "bounds"),
    [
        (two_walls(), ODD, {"x": (-1e9, 1e9), "v": (-1e9, 1e9)}),
        (two_walls().remade(bounds={"x": (-2, 5), "v": (-np.inf, 4)}), ODD, {"x": (-2, 2), "v": (-4, 4)}),
        (swapped({"x": (-1, 3)}), {"x": "y", "y": "x"}, {"x": (-1, 3), "y": (-1, 3)}),
        (swapped({"x": (-1, 3), "y": (-2, 2)}), {"x": "-y", "y": "-x"}, {"x": (-1, 2), "y": (-2, 1)}),
    ],
)
def test_bounds_hold_for_the_image_too(system, symmetry, bounds):
    assert {name: cd.halved(system, symmetry).bounds[name] for name in bounds} == bounds


def test_a_partner_that_escapes_ends_the_half_motion():
    """x = 3 cos(t) is within (-2, 5) up to acos(-2/3); its partner leaves at once."""
    spring = cd.HybridSystem(
        states="x v", time="t", modes={"free": {"x": "v", "v": "-x"}}, period="2*pi", initial={"x": 3.0, "v": 0.0},
        bounds={"x": (-2, 5)},
    )  # fmt: skip
    assert cd.trajectory(spring, periods=2).cd.outcome == "escaped"
    assert cd.trajectory(cd.halved(spring, ODD), periods=2).cd.outcome == "escaped"


@pytest.mark.parametrize(
    ("bounds", "symmetry", "told"),
    [
        ({"x": (1, 2)}, {"x": "-x", "y": "-y"}, "no x within its bounds"),
        (
            {"x": (-1, 2)},
            {"x": "(x + y)/sqrt(2)", "y": "(x - y)/sqrt(2)"},
            "x has bounds, and its image .* is not a number times one state",
        ),
    ],
)
def test_bounds_that_a_symmetry_cannot_keep_are_told(bounds, symmetry, told):
    still = cd.Map("x y", {}, {"x": "x/2", "y": "y/2"}, bounds=bounds)
    with pytest.raises(cd.ModelError, match=told):
        cd.halved(still, symmetry)


def test_a_halved_system_is_saved_as_any_other(tmp_path):
    half = cd.halved(cd.build("impact-pair"), ODD)
    cd.save_scene(tmp_path / "half.toml", system=half, analyses={"motion": {"kind": "trajectory", "periods": 2}})
    again = cd.load_scene(tmp_path / "half.toml").system
    one, other = (cd.trajectory(system, periods=3)["states"].values for system in (half, again))
    np.testing.assert_array_equal(one, other)


def test_partners_pass_the_pitchfork_at_which_they_come_back():
    """So near it that directions are round-off a fold may seem to stand there, even twice."""
    hit = {"v": "-e*v"}
    walls = cd.HybridSystem(
        name="near walls", states="x v", parameters={"omega": 1.5, "g": 0.4, "zeta": 0.05, "e": 0.8},
        modes={"free": {"x": "v", "v": "-x - 2*zeta*v + cos(omega*t)"}},
        transitions=[
            cd.Transition("right", "free", "free", "x - g", 1, hit),
            cd.Transition("left", "free", "free", "x + g", -1, hit),
        ],
        period="2*pi/omega", initial={"x": 0.0, "v": 0.5},
    )  # fmt: skip
    branch = cd.continue_orbit(walls, {"omega": (1.0, 3.0)})
    points = once(branch)
    assert (points[:, 0] == Special.BRANCH_POINT).sum() == 2
    # in units of the walls the force is 5/2
    scaled = branch.assign(f=branch["omega"] * 0 + 2.5, orbit_state=branch["orbit_state"] * 2.5)
    for number in np.flatnonzero(branch["special_kind"].values == Special.BRANCH_POINT):
        force = where_hits_come_back(scaled, number, float(branch["special_value"][number]), e=0.8)
        assert abs(force - 2.5) < 1e-9
