"""Orbits of the drill against its Taylor series in 30 digits."""

import numpy as np
import pytest
from mpmath import mp
from scipy.special import lambertw
from support.drill_in_series import SLIP, Drill
from support.drill_orbits import ALL, CASCADE, TESTS, located, named
from support.following import followed
from support.motion import arc

import chaosdrill as cd
from chaosdrill.dataset.branches import Special
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.branches import branches

# The drill in Taylor series: SciPy sees the same events.


START = ("0.5117707419326684", "0.2579689590074009", "0.3668787222623992")
"""Strobe state of the orbit at eta = 0.8 in quadruple precision, by another program."""


def test_scipy_sees_the_same_events(digits):
    digits(24)
    eta = 0.8
    state = [float(value) for value in START]
    run = Drill("0.8").run([mp.mpf(value) for value in START], SLIP, 1)

    def slip(t, s):
        y, u, w = s
        force = y + 0.12 * (u - w)
        return [u - w, 0.7 + 0.25 * np.cos(eta * t + np.pi / 2) - force, force - 0.6 - 0.4 * np.exp(-3 * w)]

    def stick(t, s):
        return [s[1], 0.7 + 0.25 * np.cos(eta * t + np.pi / 2) - s[0] - 0.12 * s[1], 0.0]

    t, s = arc(slip, 0.0, state, 7.0, lambda _, s: -s[2])
    times = [t]
    t, s = arc(stick, t, [s[0], s[1], 0.0], 7.0, lambda _, s: s[0] + 0.12 * s[1] - 1)
    times.append(t)
    t, s = arc(slip, t, s, 7.0, lambda _, s: s[0] - 1)
    times.append(t)
    entry = 1 + 0.6 * (s[1] - s[2])
    rebound = (1 + lambertw(-entry * np.exp(-entry)).real) / 0.6
    bit = (s[1] + s[2] - rebound) / 2
    _, s = arc(slip, t, [1.0, bit, bit + rebound], 2 * np.pi / eta - t)
    np.testing.assert_allclose(times, [float(event.time) for event in run.events], atol=1e-10)
    np.testing.assert_allclose(s, [float(value) for value in run.state], atol=1e-10)


def test_the_exit_speed_is_lamberts(digits):
    digits(30)
    drill = Drill("0.8")
    for v in ("1e-9", "1e-3", "0.4", "5"):
        entry = 1 + drill.lam * mp.mpf(v)
        with mp.workdps(70):
            known = (1 + mp.lambertw(-entry * mp.exp(-entry)).real) / drill.lam
        assert abs(drill.exit_speed(mp.mpf(v)) / known - 1) < 1e-18


# The table of special points is what its program finds from eight digits.


def name(special):
    return f"{special.kind}-{special.periods}-{special.eta[:7]}"


@pytest.mark.parametrize(
    "special",
    [named("p1", "period doubling", 0.76), named("p1", "grazing", 0.45)],
    ids=name,
)
def test_it_is_found_again(digits, special):
    digits(20)
    found = located(special)
    assert abs(found.eta - mp.mpf(special.eta)) < 1e-10
    if special.kind != "grazing":
        assert abs(TESTS[special.kind](found)) < 1e-8


# Branches of the drill at xi = 0.06 against special points that another program located in 30 digits.


KINDS = {
    "fold": Special.FOLD,
    "period doubling": Special.PERIOD_DOUBLING,
    "grazing": Special.GRAZING,
}


@pytest.fixture(scope="module")
def found(drill):
    """The branches of the orbits known at 0.8 and at 0.6, the latter's doubled ones included."""
    results = []
    for eta, period, doublings in ((0.8, 1, 1), (0.6, 2, 1)):
        system = drill.with_parameters(eta=eta)
        results.append(
            branches(system, "eta", (0.44, 0.81), period, "attractor", 300, doublings, 0.005, 2000, Numerics(), None)
        )
    return results


@pytest.mark.parametrize("known", ALL, ids=lambda p: f"{p.branch}-{p.kind}-{p.eta[:8]}")
def test_a_special_point_is_where_the_other_program_has_it(found, known):
    events = [
        (result, e)
        for result in found
        for e in result.events
        if e.code == KINDS[known.kind] and result.period[e.point] == known.periods
    ]
    result, nearest = min(events, key=lambda pair: abs(pair[1].values[0] - float(known.eta)))
    assert abs(nearest.values[0] - float(known.eta)) < 1e-11
    strobes = result.section[nearest.point, : known.periods]
    there = np.array([float(s) for s in known.state])
    assert np.abs(strobes - there).max(axis=1).min() < 1e-8
    if known.kind == "grazing":
        assert nearest.text.endswith(f"the branch {known.beyond}")
        beside = (nearest.point - 2, nearest.point + 2)
        without = min(beside, key=lambda k: len(result.sequences[result.sequence[k]].split()))
        assert np.sign(result.values[without, 0] - float(known.eta)) == known.without
    else:
        multipliers = result.multipliers[nearest.point]
        for one in known.multipliers:
            assert np.abs(multipliers - one).min() < 1e-6
        assert (multipliers == 0).sum() == 1


def test_no_orbit_of_period_1_doubles_between_060_and_064(found):
    """Its multipliers stay far from -1 there, so the diagram's doublings are those of other orbits."""
    result = found[0]
    inside = (result.branch == 0) & (result.values[:, 0] > 0.6) & (result.values[:, 0] < 0.64)
    assert inside.sum() > 5
    assert (np.abs(result.multipliers[inside, 0]) > 2.5).all()
    assert not any(
        e.code == Special.PERIOD_DOUBLING and 0.6 < e.values[0] < 0.64
        for e in result.events
        if result.branch[e.point] == 0
    )


@pytest.mark.parametrize("tolerance", [None, 1e-6])
def test_errors_that_are_told_are_those_there_are(found, drill, tolerance):
    """Those of bisection between sequences of events, too: they are no better than the orbits are."""
    if tolerance is not None:
        numerics = Numerics(tolerance=tolerance)
        found = [branches(drill, "eta", (0.57, 0.9), 1, "attractor", 300, 1, 0.005, 2000, numerics, None)]
    # of the same kind two points of the drill are never nearer than that
    near = [
        (abs(e.values[0] - float(known.eta)), e.error)
        for known in ALL
        for result in found
        for e in result.events
        if e.code == KINDS[known.kind]
        and result.period[e.point] == known.periods
        and abs(e.values[0] - float(known.eta)) < 1e-6
    ]
    assert len(near) >= 9
    assert all(gap <= error for gap, error in near)
    kept = np.array([error for _, error in near])
    assert np.median(kept) < 10 * (tolerance or Numerics().tolerance)


def test_a_whole_cascade_is_that_of_the_other_program(drill):
    """From the period-2 orbit that doubles at 0.6705, downward to period 32."""
    birth = next(p for p in ALL if p.branch == "p2" and p.eta.startswith("0.6705"))
    y, u, w = (float(value) for value in birth.state)
    system = drill.with_parameters(eta=0.672).with_initial(y=y, u=u, w=w, mode="slip")
    result = branches(system, "eta", (0.655, 0.69), 2, "guess", 0, 4, 0.0005, 150, Numerics(), None)
    assert result.cascade.periods.tolist() == [2, 4, 8, 16, 32]
    assert np.abs(result.cascade.values - CASCADE).max() < 2e-11


# The drill's curves over frequency and static load, against independent values, the ordinary engine and branches.


SAMPLES = 20_000

LIMITS = {"eta": (0.40, 0.90), "b": (0.60, 0.79)}


@pytest.fixture(scope="module")
def two_parameters():
    return cd.drill(drive="harmonic", friction="stribeck", rock="moving", contact="hunt-crossley", xi=0.06)


@pytest.fixture(scope="module")
def doubling(two_parameters):
    return followed(two_parameters.with_parameters(eta=0.78), LIMITS | {"b": (0.66, 0.75)}, "period_doubling", 0.08)


@pytest.fixture(scope="module")
def grazing(two_parameters):
    return followed(two_parameters.with_parameters(eta=0.78), LIMITS, "grazing", 0.04)


def at_point(drill, result, k, eta=0.0):
    """The system at a point of a curve, or at a frequency beside it, started on its orbit."""
    values = dict(zip(result.parameters, result.values[k], strict=True))
    state = dict(zip(drill.state_names, result.section[k, 0], strict=True))
    system = drill.with_parameters(eta=values["eta"] + eta, b=values["b"])
    return system.with_initial(mode=drill.mode_names[result.mode[k]], **state)


def spread(result, count):
    return np.linspace(0, len(result.values) - 1, count + 2)[1:-1].astype(int).tolist()


def test_the_curves_start_where_independent_values_say(doubling, grazing):
    # own Taylor series in 34 digits
    known = {0: 0.76452469484555915, 1: 0.45532342522408643}
    for number, result in enumerate((doubling, grazing)):
        (start,) = (e for e in result.events if e.text == "start of the curve")
        assert abs(start.values[0] - known[number]) < 1e-10
        assert start.error < 1e-10


def test_a_multiplier_of_the_ordinary_engine_is_minus_one(two_parameters, doubling):
    for k in spread(doubling, 6):
        system = at_point(two_parameters, doubling, k)
        run = cd.trajectory(system, periods=1, samples=1, tangents=True)
        assert np.abs(run["states"].values[-1] - doubling.section[k, 0]).max() < 1e-10
        assert np.abs(np.linalg.eigvals(run["final_tangent"].values) + 1).min() < 1e-8


def test_branches_at_other_loads_double_there(two_parameters, doubling):
    for k in spread(doubling, 4):
        eta = doubling.values[k, 0]
        system = at_point(two_parameters, doubling, k, 1e-3)
        found = branches(system, "eta", (eta - 4e-3, eta + 4e-3), 1, "guess", 0, 0, 1e-3, 100, Numerics(), None)
        places = [e.values[0] for e in found.events if e.code == Special.PERIOD_DOUBLING]
        assert np.abs(np.array(places) - eta).min() < 1e-10


def test_the_ordinary_engine_touches_the_stop(two_parameters, grazing):
    usual = np.flatnonzero(grazing.sequence == np.bincount(grazing.sequence).argmax())
    for k in usual[np.linspace(0, len(usual) - 1, 6)[1:-1].astype(int)].tolist():
        system = at_point(two_parameters, grazing, k)
        y = cd.trajectory(system, periods=1, samples=SAMPLES)["states"].values[:, 0]
        tops = np.flatnonzero((y[2:-2] > y[1:-3]) & (y[2:-2] >= y[3:-1])) + 2
        fits = [np.polyfit([-1, 0, 1], y[t - 1 : t + 2], 2) for t in tops]
        heights = np.array([np.polyval(fit, -fit[1] / (2 * fit[0])) for fit in fits])
        assert np.abs(heights - system.parameters["r"]).min() < 1e-9


def test_the_curve_of_grazing_goes_on_where_another_event_begins(grazing):
    usual = np.bincount(grazing.sequence).argmax()
    appear = [e for e in grazing.events if e.text == "release and stick appear; the curve continues"]
    (junction,) = (e for e in appear if usual in grazing.sequence[e.point - 1 : e.point + 2])
    assert junction.code == Special.GRAZING
    beyond = grazing.values[grazing.sequence != grazing.sequence[junction.point]]
    assert len(beyond) > 2
    assert np.linalg.norm(beyond - junction.values, axis=1).min() < 1e-4
    # the ordinary engine sees the slip that began
    assert grazing.message == ""


def test_doubled_orbits_stop_grazing_where_the_single_one_doubles_and_grazes(two_parameters):
    limits = {"eta": (0.42, 0.475), "b": (0.7352, 0.7432)}
    # near that end of both curves
    slips = two_parameters.with_initial(mode="slip")
    at_single = slips.with_parameters(eta=0.46487, b=0.73635).with_initial(y=0.83475, u=-0.0515, w=0.1311)
    at_double = slips.with_parameters(eta=0.46579, b=0.73558).with_initial(y=0.8444, u=-0.02718, w=0.13211)
    single = followed(at_single, limits, "period_doubling", 0.04, start="guess")
    double = followed(at_double, limits, "grazing", 0.04, period=2, start="guess")
    there = single.values[[0, -1]]
    ends = double.values[[0, -1]]
    assert np.linalg.norm(there[:, np.newaxis] - ends, axis=-1).min() < 1e-5
    assert "doubled orbit" in double.branches[0].end
