"""Edge states against saddles that are known in closed form, or by Newton's method."""

from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.analysis.grids.edges import OTHER, UNKNOWN, _Edge, _Stopped, bracket, mean_rates, told_by

FEW = {"transient": 40, "periods": 16, "max_period": 4, "rounds": 8}
WELLS = [{"x": 0.9}, {"x": -0.8}]


def near(found, name, exact, least=1e-9):
    """Whether a rate is as near to an exact one as its error says."""
    value, error = (float(np.ravel(found[one])[0]) for one in (name, name.replace("exponent", "error")))
    error = float(found["growth_rate_error"]) if name == "growth_rate" else error
    return abs(value - exact) <= 4 * error + least and error < 1e-5


@pytest.fixture(scope="module")
def double_well():
    system = cd.HybridSystem(
        name="double-well", states="x v", parameters={"d": 0.25, "f": 0.1, "u": 1.0}, time="t", period="2*pi",
        modes={"on": {"x": "v", "v": "x - x**3/u**2 - d*v + f*u*cos(t)"}}, initial={"x": 0.9, "v": 0.0},
    )  # fmt: skip
    return system, cd.edge_states(system, initial=WELLS, **FEW)


def test_the_saddle_between_two_wells_is_the_edge_state(bistable):
    """x' = a + x - x^3 at a = 0: the edge is x = 0, left at the rate 1."""
    found = cd.edge_states(bistable, initial=[{"x": 0.7, "y": 1.0}, {"x": -0.9, "y": -0.7}], **FEW)
    assert found["outcome"] == cd.Outcome.EQUILIBRIUM
    np.testing.assert_allclose(found["edge_state"], 0, atol=1e-5)
    assert (abs(found["edge_state"]) <= 2 * found["edge_error"] + 1e-12).all()
    assert near(found, "growth_rate", 1.0)
    np.testing.assert_allclose(found["lyapunov_exponent"], [1, -0.5], rtol=1e-6)
    assert found["side_period"].values.tolist() == [0, 0] or (found["side_outcome"] == cd.Outcome.PERIODIC).all()


def test_the_edge_state_of_a_forced_well_is_the_orbit_that_newton_finds(double_well):
    system, found = double_well
    orbit = cd.periodic_orbit(system.with_initial(x=-0.05, v=0.01), start="guess")
    assert (int(found["period"]), found["outcome"]) == (1, cd.Outcome.PERIODIC)
    off = abs(found["edge_state"] - orbit["orbit_state"]).values
    assert (off <= 4 * found["edge_error"].values + 1e-11).all()
    assert (found["edge_error"] < 1e-7).all()
    exact = np.log(abs(orbit["multiplier_real"].values)) / (2 * np.pi)
    assert near(found, "growth_rate", exact[0])
    np.testing.assert_allclose(found["lyapunov_exponent"], exact, rtol=1e-6)
    assert found["track_distance"].values[0] <= 1e-8 < found["track_distance"].values.max() <= 1e-5


@pytest.mark.parametrize("unit", [1e-6, 1e3])
def test_the_edge_state_does_not_depend_on_units(double_well, unit):
    system, exact = double_well
    starts = [{"x": unit * start["x"]} for start in WELLS]
    found = cd.edge_states(system.with_parameters(u=unit), initial=starts, **FEW)
    assert (int(found["outcome"]), int(found["period"])) == (cd.Outcome.PERIODIC, 1)
    error = found["edge_error"] / unit
    assert (abs(found["edge_state"] / unit - exact["edge_state"]) <= 4 * error + 1e-11).all()
    assert (error < 1e-7).all()


@pytest.mark.parametrize("transient", [0, 1, 3])
def test_a_transient_that_is_too_short_is_extended_or_refused(double_well, transient):
    system, exact = double_well
    for extension in (0, 4):
        found = cd.edge_states(
            system, initial=WELLS, transient=transient, periods=4, max_period=1, rounds=3, max_extension=extension
        )
        if found["outcome"] == cd.Outcome.PERIODIC:
            np.testing.assert_allclose(found["edge_state"], exact["edge_state"], atol=1e-7)
        else:
            assert "longer transient" in found.attrs["reason"] or "no two starts" in found.attrs["reason"]


def test_neither_the_order_of_the_starts_nor_further_ones_matter(double_well):
    system, found = double_well
    more = [WELLS[1], {"x": -0.7}, WELLS[0]]
    swapped = cd.edge_states(system, initial=more, **FEW)
    np.testing.assert_allclose(swapped["edge_state"], found["edge_state"], atol=1e-8)
    np.testing.assert_allclose(swapped["growth_rate"], found["growth_rate"], rtol=1e-7)
    assert (swapped["side_start"].values == found["side_start"].values[::-1]).all()


def test_units_do_not_matter(double_well):
    """x in units of 1/1000, v in units of 1000, time in units of 2: all distances are parts of an extent."""
    found = double_well[1]
    scaled = cd.HybridSystem(
        name="other-units", states="p q", parameters={"d": 0.25, "f": 0.1}, time="s", period="pi",
        modes={"on": {"p": "2e6*q", "q": "2e-3*(p/1000 - (p/1000)**3 - 1000*d*q + f*cos(2*s))"}},
        initial={"p": 900, "q": 0.0},
    )  # fmt: skip
    there = cd.edge_states(scaled, initial=[{"p": 900}, {"p": -800}], **FEW)
    np.testing.assert_allclose(there["edge_state"] / [1000, 1e-3], found["edge_state"], atol=1e-8)
    np.testing.assert_allclose(there["growth_rate"], 2 * found["growth_rate"], rtol=1e-7)
    np.testing.assert_allclose(there["track_distance"][:3], found["track_distance"][:3], rtol=1e-3)


def test_an_unstable_cycle_is_found_on_a_section():
    """r' = r (m + r^2 - r^4), which turns once in 2 pi: a cycle at r^2 = (1 - sqrt(1 + 4 m))/2."""
    swirl = "(m + x**2 + y**2 - (x**2 + y**2)**2)"
    system = cd.HybridSystem(
        name="swirl", states="x y", parameters={"m": -0.1}, initial={"x": 1.0, "y": -0.1},
        modes={"on": {"x": f"x*{swirl} - y", "y": f"y*{swirl} + x"}},
    )  # fmt: skip
    found = cd.edge_states(system, initial=[{"x": 1.0}, {"x": 0.1}], at="y > 0", **FEW)
    square = (1 - np.sqrt(1 + 4 * system.parameters["m"])) / 2
    assert (int(found["period"]), found["outcome"]) == (1, cd.Outcome.PERIODIC)
    assert found["side_outcome"].values.tolist() == [cd.Outcome.PERIODIC, cd.Outcome.EQUILIBRIUM]
    assert float(found["edge_state"][0]) == pytest.approx(np.sqrt(square), abs=1e-7)
    assert near(found, "growth_rate", 2 * square * (1 - 2 * square))
    assert near(found, "lyapunov_exponent", 2 * square * (1 - 2 * square))
    np.testing.assert_allclose(np.diff(found["track_time"])[1:], 2 * np.pi, rtol=1e-6)


def test_the_saddle_of_an_impact_oscillator_parts_its_chaos_from_the_orbit_that_does_not_touch():
    """A cycle of two periods, which Newton's method finds from nearby."""
    system = cd.HybridSystem(
        name="impact-oscillator", states="x v", parameters={"zeta": 0.05, "omega": 2.5, "e": 0.8}, time="t",
        modes={"free": {"x": "v", "v": "-x - 2*zeta*v + cos(omega*t)"}}, period="2*pi/omega",
        transitions=[cd.Transition("impact", "free", "free", "x - 0.3", 1, {"v": "-e*v"}, kind="impact")],
        initial={"x": 0.0, "v": 0.3},
    )  # fmt: skip
    starts = [{"x": 0.2429, "v": 0.0895}, {"x": -0.19, "v": 0.0226}]
    found = cd.edge_states(system, initial=starts, transient=100, periods=32, max_period=4, rounds=16)
    state = dict(zip(system.state_names, found["edge_state"].values.round(3).tolist(), strict=True))
    orbit = cd.periodic_orbit(system.with_initial(**state), start="guess", period=2)
    assert (int(found["period"]), int(orbit["period"])) == (2, 2)
    assert abs(orbit["section"] - found["edge_state"]).max("state").min() < 1e-7
    exact = np.log(abs(orbit["multiplier_real"].values)) / (2 * float(found["forcing_period"]))
    assert near(found, "growth_rate", exact[0])
    np.testing.assert_allclose(found["lyapunov_exponent"], exact, rtol=1e-5)
    drawn = cd.plot(found, kind="edge-states").figure.axes[0].lines
    (stars,) = (line for line in drawn if str(line.get_label()).startswith("edge state"))
    apart = np.abs(stars.get_xydata()[:, np.newaxis] - orbit["section"].values).max(axis=2)
    assert sorted(apart.argmin(axis=1)) == [0, 1]
    assert apart.min(axis=1).max() < 1e-5


def test_modes_by_their_regions_are_crossed_on_the_way_to_the_edge():
    """Between two wells x'' = 2 x - d x' + f cos t is linear, and its only orbit that stays is a cosine and a sine."""
    well = "-(x {} 1) - d*v + f*cos(t)"
    forces = {"left": well.format("+"), "inner": "2*x - d*v + f*cos(t)", "right": well.format("-")}
    borders = [("inner", "left", "x + 1/3", -1), ("left", "inner", "x + 1/3", 1)]
    borders += [("inner", "right", "x - 1/3", 1), ("right", "inner", "x - 1/3", -1)]
    system = cd.HybridSystem(
        name="pieces", states="x v", time="t", period="2*pi", parameters={"d": 0.3, "f": 0.05},
        modes={name: {"x": "v", "v": force} for name, force in forces.items()},
        transitions=[cd.Transition(f"{one}-{other}", one, other, *rest) for one, other, *rest in borders],
        regions={"left": "x < -1/3", "inner": "x > -1/3 and x < 1/3", "right": "x > 1/3"},
        initial={"x": 0.9, "v": 0.0},
    )  # fmt: skip
    found = cd.edge_states(system, initial=WELLS, **FEW)
    exact = np.linalg.solve([[-3, 0.3], [-0.3, -3]], [0.05, 0])
    np.testing.assert_allclose(found["edge_state"], exact, atol=1e-8)
    assert system.mode_names[int(found["edge_mode"])] == "inner"
    assert near(found, "growth_rate", (np.sqrt(0.3**2 + 8) - 0.3) / 2)


def test_the_edge_state_of_the_drill_sticks_and_loses_a_direction_each_period():
    """Between fast and slow drilling at eta = 0.52."""
    drill = cd.drill(xi=0.12, b=0.7, eta=0.52)
    starts = [{"y": -1.0, "u": -1 / 3}, {"y": -1.0, "u": -1.0}]
    found = cd.edge_states(drill, initial=starts, transient=300, periods=64, max_period=2, rounds=8)
    assert (int(found["period"]), found["outcome"]) == (1, cd.Outcome.PERIODIC)
    near_it = dict(zip(drill.state_names, found["edge_state"].values.round(3).tolist(), strict=True))
    mode = drill.mode_names[int(found["edge_mode"])]
    orbit = cd.periodic_orbit(drill.with_initial(**near_it, mode=mode), start="guess")
    np.testing.assert_allclose(found["edge_state"], orbit["orbit_state"], atol=2e-6)
    with np.errstate(divide="ignore"):
        exact = np.log(abs(orbit["multiplier_real"].values)) / float(found["forcing_period"])
    np.testing.assert_allclose(found["lyapunov_exponent"], exact, rtol=1e-5)
    assert found["lyapunov_exponent"][2] == -np.inf
    assert near(found, "growth_rate", exact[0])


def test_the_edge_of_escape_is_the_top_of_the_barrier():
    system = cd.HybridSystem(
        name="escape", states="x v", parameters={"d": 0.3}, modes={"on": {"x": "v", "v": "-x + x**2 - d*v"}},
        initial={"x": 0.5, "v": 0.0}, bounds={"x": (-20, 20)},
    )  # fmt: skip
    found = cd.edge_states(
        system, initial=[{"x": 0.5}, {"x": 1.5, "v": 0.3}], duration=60.0, transient=60.0, rounds=6, exponents=1
    )
    assert found["outcome"] == cd.Outcome.EQUILIBRIUM
    assert found["side_outcome"].values.tolist() == [cd.Outcome.EQUILIBRIUM, cd.Outcome.ESCAPED]
    np.testing.assert_allclose(found["edge_state"], [1, 0], atol=1e-5)
    exact = (np.sqrt(0.3**2 + 4) - 0.3) / 2
    assert near(found, "growth_rate", exact, 1e-6)


def test_a_map_has_a_chaotic_edge_state_whose_exponents_are_exact():
    """x -> x (a + b z) - x^3 under a logistic z: at x = 0 the mean of log(a + b z) over the arcsine density."""
    driven = cd.Map(
        "x z", {"a": 1.5, "b": 0.3}, {"x": "x*(a + b*z) - x**3", "z": "4*z*(1 - z)"}, name="driven",
        initial={"x": 0.7, "z": 0.31},
    )  # fmt: skip
    starts = [{"x": 0.7}, {"x": -0.8, "z": 0.4}]
    found = cd.edge_states(driven, initial=starts, transient=60, periods=500, max_period=4, rounds=40)
    assert (int(found["period"]), found["outcome"]) == (0, cd.Outcome.CHAOTIC)
    exact = [np.log(2), 2 * np.log((np.sqrt(1.5) + np.sqrt(1.8)) / 2)]
    assert (abs(found["lyapunov_exponent"] - exact) <= 4 * found["lyapunov_error"]).all()
    assert (found["lyapunov_error"] < 0.03).all()
    assert abs(found["track_state"][:, 0]).max() < 0.1


@pytest.mark.parametrize(
    ("starts", "reason"),
    [([{"x": 1.9}, {"x": -2.1}], "third fate"), ([{"x": 1.9}, {"x": 2.2}], "no two starts")],
)
def test_what_has_no_edge_between_says_so(starts, reason):
    three = cd.HybridSystem(
        name="three-wells", states="x", parameters={}, modes={"on": {"x": "-x*(x**2 - 1)*(x**2 - 4)"}},
        initial={"x": 1.9},
    )  # fmt: skip
    found = cd.edge_states(three, initial=starts, duration=10.0, transient=10.0, max_extension=1)
    assert found["outcome"] == cd.Outcome.UNDECIDED
    assert reason in found.attrs["reason"]
    assert found.sizes["step"] == 0
    assert np.isnan(found["growth_rate"])


def test_a_jump_that_parts_two_fates_is_no_edge_state():
    jump = cd.Map("x", {}, {"x": "x/2 + sign(x)"}, name="jump", initial={"x": 1.0})
    found = cd.edge_states(jump, initial=[[1.9], [-1.1]], **FEW)
    assert "part at once" in found.attrs["reason"]
    assert found["outcome"] == cd.Outcome.UNDECIDED


def test_a_bracket_leaves_out_what_is_neither():
    assert bracket(np.array([1, 1, OTHER, 2, 1, 2])) == (4, 5)
    assert bracket(np.array([1, UNKNOWN, 2, 2])) == (0, 2)
    assert bracket(np.array([1, 2, 2, OTHER, 1, UNKNOWN, 2])) == (0, 1)


def of_runs(*rows):
    """What is known of runs of one state: outcome, period, mean and standard deviation of each."""
    outcome, period, mean, spread = (np.array(one) for one in zip(*rows, strict=True))
    moments = np.stack([mean, spread, np.zeros(len(rows)), np.full(len(rows), 2.0)], axis=1)[:, :, np.newaxis]
    none = np.zeros((len(rows), 0))
    return {"outcome": outcome, "period": period, "moments": moments, "lyapunov_exponent": none, "lyapunov_error": none}


@pytest.mark.parametrize(("needed", "longer"), [(0, 0), (2, 2), (9, 4)])
def test_a_state_that_no_bisection_has_replaced_is_told_by_longer_runs(needed, longer):
    """The first of a pair, which goes to the first attractor in runs that are so much longer."""
    edge = SimpleNamespace(longer=0, plan=SimpleNamespace(max_extension=4))
    edge.fates = lambda _, states: np.full(len(states), 1 if edge.longer >= needed else 2)
    given, pair = (SimpleNamespace(states=np.array([[0.0], [end]])) for end in (1.0, 0.1))
    with pytest.raises(_Stopped, match="give a longer transient") if needed > 4 else nullcontext():
        _Edge._ascertain(edge, given, pair)
    assert edge.longer == longer


def test_a_fate_is_told_by_where_runs_go_not_by_words_that_are_missing():
    """A late spiral on a section through its centre is one point, as the centre is; what has no word goes by means."""
    o = cd.Outcome
    known = of_runs((o.EQUILIBRIUM, 0, 1.0, 0.0), (o.CHAOTIC, 0, -1.0, 0.5))
    rows = [
        ((o.EQUILIBRIUM, 0, 1.0, 0.0), 1),
        ((o.PERIODIC, 1, 1.0, 1e-8), 1),
        ((o.PERIODIC, 1, 0.5, 0.0), OTHER),
        ((o.PERIODIC, 2, 1.0, 0.1), OTHER),
        ((o.CHAOTIC, 0, -1.02, 0.5), 2),
        ((o.UNDECIDED, 0, -1.02, 0.5), 2),
        ((o.UNDECIDED, 0, 1.0, 0.5), OTHER),
        ((o.TRANSIENT, 0, -1.0, 0.5), UNKNOWN),
        ((o.ESCAPED, 0, np.nan, np.nan), OTHER),
        ((o.FAILED, 0, np.nan, np.nan), UNKNOWN),
    ]
    assert told_by(known, of_runs(*(row for row, _ in rows))).tolist() == [code for _, code in rows]
    leaves = of_runs((o.ESCAPED, 0, np.nan, np.nan), (o.CHAOTIC, 0, -1.0, 0.5))
    assert told_by(leaves, of_runs(*(row for row, _ in rows)))[-2:].tolist() == [1, UNKNOWN]


def test_a_track_that_two_directions_leave_is_no_edge_state():
    """x' = x - x^3, y' = y (1/2 - x^2) - y^3: on the edge x = 0 the origin repels, and y = sqrt(1/2) attracts."""
    system = cd.HybridSystem(
        name="two-ways", states="x y", modes={"on": {"x": "x - x**3", "y": "y*(1/2 - x**2) - y**3"}}, initial={"x": 0.5}
    )  # fmt: skip
    lengths = {"duration": 40, "transient": 40, "rounds": 8}
    held = cd.edge_states(system, initial=[{"x": 0.7}, {"x": -0.9}], **lengths)
    assert held["outcome"] == cd.Outcome.UNDECIDED
    assert "several directions lead off" in held.attrs["reason"]
    np.testing.assert_allclose(held["lyapunov_exponent"], [1, 0.5], rtol=1e-6)
    free = cd.edge_states(system, initial=[{"x": 0.7, "y": 1e-3}, {"x": -0.9, "y": 2e-3}], **lengths)
    assert free["outcome"] == cd.Outcome.EQUILIBRIUM
    np.testing.assert_allclose(free["edge_state"], [0, np.sqrt(0.5)], atol=1e-8)


def test_errors_of_mean_rates_cover():
    """Those of blocks whatever their length; those of cycles bound what their steps share."""
    rng, hits = np.random.default_rng(1), 0
    for _ in range(300):
        blocks = np.repeat(np.arange(24), rng.integers(5, 15, 24))
        rate, error = mean_rates(0.3 + rng.standard_normal((len(blocks), 1)), np.ones(len(blocks)), blocks, 0)
        hits += abs(rate[0] - 0.3) <= 2 * error[0]
    assert 0.9 < hits / 300 < 0.985
    off = np.tile(1e-8 * 2.0 ** np.arange(10), 24)
    phases = np.tile([-1.0, 2.0, 1.0], 80)
    rate, error = mean_rates((phases + off)[:, np.newaxis], np.full(240, 2.0), np.zeros(240), 3)
    assert abs(rate[0] - 1 / 3) <= error[0] < 1e-5


def test_arguments_that_do_not_fit(bistable):
    with pytest.raises(cd.SettingsError, match="give starts: initial, a list, or random"):
        cd.edge_states(bistable, **FEW)
    with pytest.raises(cd.SettingsError, match="ten times closest"):
        cd.edge_states(bistable, initial=WELLS, closest=1e-5, **FEW)
    with pytest.raises(cd.SettingsError, match="leave one of them out"):
        cd.edge_states(bistable, initial=WELLS, random={"count": 2, "seed": 1, "x": (0, 1)}, **FEW)
