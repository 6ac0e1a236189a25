"""Branches at the borders of maps in pieces, doublings at which a family begins or none does, and how branches end."""

import numpy as np
import pytest
import sympy
from support.discrete import mapped
from support.following import kinds

import chaosdrill as cd
from chaosdrill.dataset.branches import BranchEnd, Special

x, mu, a, b = sympy.symbols("x mu a b", real=True)

PIECES = (sympy.Piecewise((0.4 * x + mu, x <= 0), (-0.7 * x + mu, True)), mu - 0.15 * x - 0.55 * sympy.Abs(x))


@pytest.mark.parametrize("image", PIECES, ids=["pieces", "abs"])
@pytest.mark.parametrize(("side", "size"), [(-1, 1.0), (1, 1.0), (1, 1e-9)])
def test_a_map_of_pieces_goes_on_through_its_border(side, size, image):
    """x -> a x + mu for x <= 0, b x + mu else: the fixed point mu / (1 - slope) passes 0 where both slopes are < 1."""
    start = 0.2 * size * side / (0.6 if side < 0 else 1.7)
    one = cd.Map((x,), {"mu": 0.2 * size * side}, {x: image}, initial={x: start})
    found = cd.continue_orbit(one, {"mu": (-size, size)}, start="guess")
    names = ("branch 1", "branch 2")[:: -side if image is PIECES[0] else side]
    assert found["special_text"].item().startswith(" becomes ".join(names))
    assert found["special_value"].item() == pytest.approx(0, abs=1e-10 * size)
    values, states = found["mu"].values / size, found["orbit_state"].values[:, 0] / size
    assert (values.min(), values.max()) == (-1, 1)
    assert states == pytest.approx(values / np.where(values < 0, 0.6, 1.7), abs=1e-10)


def test_a_cycle_of_two_shrinks_to_the_border_where_it_was_born():
    """x -> x/2 + mu for x <= 0, -3x/2 + mu else: x1 = -mu/3.5 and x2 = 6 mu/7 take turns where mu > 0."""
    image = sympy.Piecewise((x / 2 + mu, x <= 0), (-3 * x / 2 + mu, True))
    found = cd.continue_orbit(mapped({x: image}, {"mu": 0.35}, [-0.1]), {"mu": (-1, 1)}, start="guess", period=2)
    assert "shrank onto the orbit of half its period" in found["branch_end_text"].item()
    assert found["mu"].values.min() == pytest.approx(0, abs=1e-9)
    assert not kinds(found)


@pytest.mark.parametrize(("size", "start", "step"), [(1.0, -0.8, None), (1e6, -1.2, 0.05)])
def test_the_flip_of_a_kinked_map_begins_a_family_up_to_its_border(size, start, step):
    """x -> a x + b for x > 0, x/2 + b else: at a = -1 all of (0, b) are in 2-cycles; beyond, one of these is left."""
    image = sympy.Piecewise((a * x + b, x > 0), (x / 2 + b, True))
    kinked = mapped({x: image}, {"a": start, "b": size}, [size / (1 - start)])
    found = cd.continue_orbit(kinked, {"a": (-1.6, -0.5)}, start="guess", doublings=1, step=step)
    assert kinds(found) == [Special.PERIOD_DOUBLING, Special.OUTCOME_SWITCH]
    assert found["special_value"].values == pytest.approx(-1, abs=1e-12)
    assert "form a family at this one value" in found["special_text"].values[0]
    assert "soft" not in found["special_text"].values[0]
    alone = cd.continue_orbit(kinked, {"a": (-1.6, -0.5)}, start="guess", step=step)
    assert alone["special_text"].item() == found["special_text"].values[0]
    assert "continues" in found["special_text"].values[1]
    doubled = found.isel(point=found["branch"].values == 1)
    values, lower = doubled["a"].values, doubled["section"].values.min(axis=(1, 2)) / size
    family = abs(values + 1) < 1e-9
    assert (lower[family].min(), lower[family].max()) == (pytest.approx(0, abs=1e-6), pytest.approx(0.5, abs=0.01))
    assert not doubled["stable"].values[family].any()
    assert lower[~family] == pytest.approx((1 + values[~family]) / (1 - values[~family] / 2), abs=1e-10)
    assert values.min() == -1.6


@pytest.mark.parametrize(("power", "middle"), [(11, 0.0), (25, 2.0)])
def test_a_flat_flip_begins_no_family(power, middle):
    """u -> -(1 + a) u + u^n has the 2-cycle +-a^(1/(n - 1)), whose multiplier is ((n - 1) a - 1)^2."""
    u, other = x - middle, 2 / (power - 1)
    flat = mapped({x: middle - (1 + a) * u + u**power}, {"a": -0.3}, [middle])
    found = cd.continue_orbit(flat, {"a": (-0.5, 0.5)}, start="guess", doublings=1)
    assert kinds(found) == [Special.PERIOD_DOUBLING, Special.BRANCH_POINT]
    assert found["special_value"].values == pytest.approx([0, other], abs=1e-9)
    assert "family" not in found["special_text"].values[0]
    doubled = found.isel(point=found["branch"].values == 1)
    values, stable = doubled["a"].values, doubled["stable"].values
    assert stable[(values > 1e-6) & (values < other - 1e-6)].all()
    assert not stable[values > other + 1e-6].any()
    assert values.max() == 0.5


def test_the_flip_of_a_held_control_begins_a_family():
    """Between ticks x' = x/2 + u, at each u = -k x: x -> (e - 2 k (e - 1)) x in a tick, with e = exp(1/2)."""
    k, u, t = sympy.symbols("k u t", real=True)
    tick = cd.Transition("tick", "on", "on", guard=sympy.sin(sympy.pi * t), direction=0, reset={u: -k * x})
    control = cd.HybridSystem(
        name="control", states=(x, u), time=t, parameters={"k": 1.2}, period=sympy.Integer(2),
        modes={"on": {x: x / 2 + u + 0.2, u: 0}}, transitions=[tick], initial={x: 1.0},
    )  # fmt: skip
    alone = cd.continue_orbit(control, {"k": (0.7, 3.5)}, step=0.2)
    found = cd.continue_orbit(control, {"k": (0.7, 3.5)}, doublings=1, step=0.2)
    assert alone["special_text"].item() == found["special_text"].item()
    assert kinds(found) == [Special.BRANCH_POINT]  # of two ticks
    assert "form a family at this one value" in found["special_text"].item()
    assert found["special_value"].item() == pytest.approx((np.exp(0.5) + 1) / np.expm1(0.5) / 2, abs=1e-9)
    assert found["branch_end"].values.tolist() == [BranchEnd.LIMIT, BranchEnd.ESCAPED, BranchEnd.ESCAPED]


@pytest.mark.parametrize(("low", "high", "branches"), [(2.0, 3.0, 1), (3.0, 3.3, 2)])
def test_a_special_point_at_a_limit_is_listed(low, high, branches):
    """x -> r x (1 - x) has its fixed point 1 - 1/r double at r = 3."""
    middle = (low + high) / 2
    logistic = mapped({x: a * x * (1 - x)}, {"a": middle}, [1 - 1 / middle])
    found = cd.continue_orbit(logistic, {"a": (low, high)}, start="guess", doublings=1)
    assert kinds(found) == [Special.PERIOD_DOUBLING]
    assert found["special_value"].item() == pytest.approx(3, abs=1e-12)
    assert found.sizes["branch_number"] == branches
    assert not found.attrs.get("message")


def test_default_bounds_go_with_the_start_of_each_system():
    for start in (2.0, 20.0):
        grows = cd.Map("x", {"r": 0.5}, {"x": "r*x + 1"}, initial={"x": start})
        branch = cd.continue_orbit(grows, {"r": (0.4, 1.5)}, step=0.2)
        assert branch["branch_end"].item() == BranchEnd.ESCAPED
        assert float(branch["orbit_state"].max()) == pytest.approx(1e9 * start, rel=1e-6)


@pytest.mark.parametrize(
    "system",
    [
        cd.Map("x", {"r": 0.5}, {"x": "x/2 + sqrt(r)"}),
        cd.HybridSystem(
            states="x", time="t", parameters={"r": 0.5}, period="2*pi", modes={"m": {"x": "sqrt(r)*cos(t) - x"}}
        ),
    ],
)
def test_orbits_without_events_that_end_tell_of_no_speed(system):
    words = cd.continue_orbit(system, {"r": (-1, 1)}, step=0.2)["branch_end_text"].item()
    assert "be undefined" in words
    assert "speed" not in words
    assert "step" not in words


@pytest.mark.parametrize("low", [-5, -1e9, -np.inf])
def test_a_branch_ends_where_its_orbits_reach_their_bounds(low):
    grows = cd.Map("x", {"r": 0.5}, {"x": "r*x + 1"}, initial={"x": 2.0}, bounds={"x": (low, 5)})
    branch = cd.continue_orbit(grows, {"r": (0.4, 0.95)})
    assert branch["branch_end"].item() == BranchEnd.ESCAPED
    assert float(branch["r"].max()) == pytest.approx(0.8, abs=1e-8)


@pytest.mark.parametrize("bound", [(-1e6, 1e6), (-100.0, 1e5), (-100.0, np.inf)])
def test_a_canard_that_a_run_does_not_follow_is_no_escape(bound):
    """Off it the linear prediction runs away; no orbit is larger than its spikes of 30."""
    neuron = cd.build("izhikevich")
    bounded = neuron.remade(bounds={**neuron.bounds, "v": bound})
    branch = cd.continue_orbit(bounded, {"c": (-70.0, -40.0)}, step=0.5, transient=200)
    assert branch["branch_end"].item() == BranchEnd.NO_CONVERGENCE
    assert "as along a canard" in branch["branch_end_text"].item()


@pytest.mark.parametrize(("size", "step"), [(1.0, None), (1e6, 0.5)])
def test_a_neuron_stops_where_its_drive_is_the_threshold(size, step):
    """It fires after ln(drive / (drive - threshold)), which has no bound, while the speed at the spike vanishes."""
    neuron = cd.build("integrate-and-fire", {"threshold": size, "drive": 1.5 * size})
    step = None if step is None else step * size
    found = cd.continue_orbit(neuron, {"drive": (0.5 * size, 3 * size)}, at="spike", step=step)
    assert found["special_text"].item() == "spike vanishes; the branch ends"
    assert found["special_error"].item() < 1e-7 * size
    assert abs(found["special_value"].item() - size) <= found["special_error"].item()


@pytest.fixture(scope="module")
def thermostat():
    """On from 1 - p to p and off on the way back, half a period of ln(p / (1 - p)) each."""
    x, p = sympy.symbols("x p", real=True)
    switches = [
        cd.Transition("hot", source="on", target="off", guard=x - p, direction=1),
        cd.Transition("cold", source="off", target="on", guard=x - 1 + p, direction=-1),
    ]
    modes, start = {"on": {x: 1 - x}, "off": {x: -x}}, {"mode": "on", x: 0.5}
    return cd.HybridSystem(
        name="thermostat", states=(x,), parameters={"p": 0.7}, modes=modes, transitions=switches, initial=start
    )


@pytest.mark.parametrize(
    ("end", "step"), [(1.2, None), (1.2, 0.1), (1.2, 0.013), (1.0, None), (1.0, 0.04), (1.0, 0.003)]
)
def test_both_switches_of_a_thermostat_take_ever_longer(thermostat, end, step):
    """The orbits with the same switches that are found ever nearer to the end are those of the branch itself."""
    branch = cd.continue_orbit(thermostat, {"p": (0.55, end)}, step=step)
    assert branch["branch_end"].item() == BranchEnd.GRAZING
    assert branch["special_text"].item() == "hot and cold vanish; the branch ends"
    assert 0 <= 1 - branch["special_value"].item() <= branch["special_error"].item() < 1e-7


@pytest.mark.parametrize("step", [0.02, 0.2])
def test_an_event_that_is_not_slow_says_nothing_of_where_a_branch_ends(step):
    """A clock ticks ever more slowly, and stops at 2, while the states that it moves leave their piece at 0."""
    moves = {"guard": "c - 1", "direction": 1, "source": "on", "target": "on"}
    system = cd.HybridSystem(
        name="clock", states="y c", parameters={"mu": -0.3}, initial={"mode": "on", "y": -0.6, "c": 0.0},
        modes={"on": {"y": "0", "c": "2 - mu"}},
        transitions=[
            cd.Transition("tick", condition="y <= 0", reset={"y": "y/2 + mu", "c": "0"}, **moves),
            cd.Transition("tock", condition="y > 0", reset={"y": "mu - 3*y/2", "c": "0"}, **moves),
        ],
    )  # fmt: skip
    branch = cd.continue_orbit(system, {"mu": (-1, 1)}, start="guess", step=step)
    assert abs(branch["special_value"].item()) <= branch["special_error"].item() < 1e-7 * step
