"""Scenes in SI units: units, the equations of the paper, and faults."""

import math
import tomllib

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

import chaosdrill as cd
from chaosdrill.errors import ChaosdrillError, ModelError, SettingsError
from chaosdrill.scene import parse_scene
from chaosdrill.systems.drill.si import QUANTITIES, metres_per_hour, si_to_dimensionless
from chaosdrill.units import FORCE, LENGTH, parse_quantity
from chaosdrill.workflow import run

# Quantities are read in SI, and a wrong unit is never taken for a right one.


@pytest.mark.parametrize(
    ("text", "value", "dimension"),
    [
        ("250 kg", 250.0, (1, 0, 0, 0)),
        ("0.25t", 250.0, (1, 0, 0, 0)),
        ("2 mm", 2e-3, (0, 1, 0, 0)),
        ("-1.5e-3 km", -1.5, (0, 1, 0, 0)),
        ("40 kN/m", 4e4, (1, 0, -2, 0)),
        ("3.8 kN*s/m", 3800.0, (1, 0, -1, 0)),
        ("3.8 kN s/m", 3800.0, (1, 0, -1, 0)),
        ("3.8 kN·s/m", 3800.0, (1, 0, -1, 0)),
        ("1 MN/mm", 1e9, (1, 0, -2, 0)),
        ("2 N/m^1.5", 2.0, (1, -0.5, -2, 0)),
        ("2 kg m/s2", 2.0, (1, 1, -2, 0)),
        ("12 s/m", 12.0, (0, -1, 1, 0)),
        ("90 rpm", 3 * math.pi, (0, 0, -1, 1)),
        ("2 Hz", 4 * math.pi, (0, 0, -1, 1)),
        ("180 deg", math.pi, (0, 0, 0, 1)),
        ("1 1/min", 1 / 60, (0, 0, -1, 0)),
        ("0.8", 0.8, (0, 0, 0, 0)),
    ],
)
def test_quantity(text, value, dimension):
    quantity = parse_quantity(text)
    assert quantity.value == pytest.approx(value, rel=1e-15)
    assert quantity.dimension == pytest.approx(dimension)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("kg", "not a number"),
        ("", "not a number"),
        ("2,5 kg", "cannot read the unit"),
        ("5 lbf", "unknown unit 'lbf'; known are 1, kg"),
        ("5 12", "cannot read the unit"),
        ("5 kg//m", "cannot read the unit"),
        ("5 kg**", "cannot read the unit"),
        ("1e999 kg", "beyond all doubles, or nearer to 0 than any"),
        ("1e-999 kg", "beyond all doubles, or nearer to 0 than any"),
        ("5e-324 mm", "beyond all doubles, or nearer to 0 than any"),
        ("1 km^9999999", "cannot read the unit"),
        ("nan kg", "not a number"),
        ("1 kg" + " " * 200, "not a number"),
        ("__import__('os')", "not a number"),
    ],
)
def test_refused(text, reason):
    with pytest.raises(ValueError, match=reason):
        parse_quantity(text)


# A drill from quantities with units in Python is that of the scene with the same quantities.


@pytest.fixture
def quantities(in_si):
    return tomllib.loads(in_si)["system"]["si"]


def test_it_is_the_drill_of_the_scene(in_si, quantities):
    drill = cd.drill(**quantities)
    scene = cd.parse_scene(in_si).system
    assert drill.parameters == scene.parameters
    assert drill.parameters["eps"] == 250 / 125
    assert drill.parameters["eta"] == pytest.approx(100 * math.sqrt(250 / 4e6), rel=1e-15)
    assert drill.parameters["b"] == pytest.approx(5600 / (0.8 * 10e3), rel=1e-15)


def test_what_has_no_quantity_is_given_as_a_number(quantities):
    quantities.pop("omega")
    assert cd.drill(**quantities, eta=0.7, phi=0.25).parameters["eta"] == 0.7
    assert cd.drill(**quantities, eta=0.7, phi="45 deg").parameters["phi"] == pytest.approx(math.pi / 4)


@pytest.mark.parametrize(
    ("change", "error", "told"),
    [
        ({"m1": "250 s"}, ModelError, "m1: has the wrong dimension"),
        ({"m1": 250}, ModelError, "m1: needs a unit, as in '250 kg'"),
        ({"K": None}, ModelError, "give K too, as in K='4e6 N/m'"),
        ({"eta": 0.8}, ModelError, "omega: eta is given too"),
        ({"mass": "250 kg"}, ModelError, "unknown parameter 'mass'"),
        ({"eta": "0.8"}, ChaosdrillError, "eta"),
        ({"m1": "1e300 kg"}, ModelError, "m1: received '1e300 kg', which makes m1/m2 .8e\\+297. too large"),
        ({"m1": "1e-300 kg"}, ModelError, "m1: received '1e-300 kg', which makes m1/m2 .8e-303. too large or"),
        ({"C": "1e-200 N*s/m"}, ModelError, "C: received '1e-200 N.s/m', which makes C/"),
        ({"K": "1e308 N/m", "m1": "1e-308 kg"}, ModelError, "K: received|m1: received"),
        ({"lambda": "1e200 s/m"}, ModelError, "lambda: received '1e200 s/m'"),
    ],
)
def test_what_is_wrong_is_told_alone(quantities, change, error, told):
    given = {name: value for name, value in (quantities | change).items() if value is not None}
    with pytest.raises(error, match=told) as caught:
        cd.drill(**given)
    assert len(str(caught.value)) < 200


def test_what_is_given_as_zero_is_zero(quantities):
    quantities |= {"C": "0 N*s/m", "A": "0 N", "R": "0 m", "lambda": "0 s/m"}
    drill = cd.drill(**quantities)
    assert [drill.parameters[name] for name in ("xi", "a", "r", "lam")] == [0.0] * 4


def test_a_number_without_a_unit_is_as_before():
    assert cd.drill(n=1.5).parameters["n"] == 1.5
    with pytest.raises(SettingsError, match="must be a finite number"):
        cd.drill(n="1.5")


# A scene in SI units moves as equations (1) to (4) of the paper do in SI units.


# the quantities of the scene, and a state of the drill: stretch, speeds of bit and rock (m, m/s), time (s)
M1, M2, K, C, A, B, W = 250.0, 125.0, 4e6, 3800.0, 2000.0, 5600.0, 100.0
STATIC, KINETIC, GAMMA = 0.8 * 10e3, 0.48 * 10e3, 12.0
STRETCH, BIT, ROCK, TIME = 1.3e-3, 0.11, 0.04, 0.017


@pytest.fixture
def scene(in_si):
    return parse_scene(in_si)


@pytest.fixture
def here(scene):
    """Parameters, state and time of the dimensionless system at the state above."""
    system = scene.system
    length, second = scene.scales["length_m"], scene.scales["time_s"]
    state = {"y": STRETCH / length, "u": BIT / length * second, "w": ROCK / length * second, "t": TIME / second}
    return {sympy.Symbol(name, real=True): value for name, value in (system.parameters | state).items()}


def rate(scene, here, mode, state):
    return float(scene.system.modes[mode][sympy.Symbol(state, real=True)].subs(here))


def test_scales(scene):
    assert scene.scales["length_m"] == pytest.approx(STATIC / K, rel=1e-15)
    assert scene.scales["time_s"] == pytest.approx(math.sqrt(M1 / K), rel=1e-15)


def test_acceleration_of_the_bit(scene, here):
    force = A * math.cos(W * TIME + math.pi / 2) + B - C * (BIT - ROCK) - K * STRETCH
    expected = force / M1 * scene.scales["time_s"] ** 2 / scene.scales["length_m"]
    assert rate(scene, here, "slip", "u") == pytest.approx(expected, rel=1e-12)


def test_acceleration_of_the_rock(scene, here):
    friction = KINETIC + (STATIC - KINETIC) * math.exp(-GAMMA * ROCK)
    force = C * (BIT - ROCK) + K * STRETCH - friction
    expected = force / M2 * scene.scales["time_s"] ** 2 / scene.scales["length_m"]
    assert rate(scene, here, "slip", "w") == pytest.approx(expected, rel=1e-12)


def test_stop_and_stiffness(scene):
    parameters = scene.system.parameters
    assert parameters["r"] * scene.scales["length_m"] == pytest.approx(2e-3, rel=1e-15)
    # the contact's force at a depth of a micrometre, in units of the static friction
    depth = 1e-6
    expected = 4.8e12 * depth / STATIC
    assert parameters["k"] * depth / scene.scales["length_m"] == pytest.approx(expected, rel=1e-12)
    # lam times a dimensionless speed is lambda times the speed in m/s
    speed = scene.scales["length_m"] / scene.scales["time_s"]
    assert parameters["lam"] == pytest.approx(2.4 * speed, rel=1e-12)


# A scene in SI units and the dimensionless one give the same motion; the SI one adds the progression in m/h.


ANALYSIS = """
[analysis.section]
kind = "poincare-section"
transient = 20
periods = 6
"""
# by hand, from equation (8): sqrt(K/m1) = 126.49.../s, mu_e F_N = 8 kN, mu_e F_N / K = 2 mm
DIMENSIONLESS = """\
[system]
model = "percussive-drill"
effects = { drive = "harmonic", friction = "stribeck", rock = "moving", contact = "hunt-crossley" }
[system.parameters]
eps = 2.0
xi = 0.06008327554319921
eta = 0.7905694150420949
a = 0.25
b = 0.7
r = 1.0
mu = 0.6
g = 3.0357865537616441
lam = 0.6071573107523288
k = 12e5
"""


@pytest.fixture
def results(in_si):
    return [run(parse_scene(text + ANALYSIS))["section"] for text in (in_si, DIMENSIONLESS)]


def test_same_motion(results):
    si, dimensionless = results
    assert si.sizes["iterate"] == 6
    np.testing.assert_allclose(si["section"], dimensionless["section"], rtol=1e-8, atol=1e-10)


def test_progression_in_metres_per_hour(results):
    si, dimensionless = results
    # 2 mm in every 7.905694 ms
    expected = float(dimensionless["progression_rate"]) * 2e-3 / 7.905694150420949e-3 * 3600
    assert expected > 0
    assert float(si["progression_rate_si"]) == pytest.approx(expected, rel=1e-8)
    assert si["progression_rate_si"].attrs["units"] == "m h-1"
    assert "progression_rate_si" not in dimensionless


def test_scales_are_kept(in_si):
    tree = run(parse_scene(in_si + ANALYSIS))
    assert tree.attrs["si_length_m"] == pytest.approx(2e-3, rel=1e-14)
    assert tree.attrs["si_time_s"] == pytest.approx(7.905694150420949e-3, rel=1e-14)


# The dimensionless drill does not depend on the units that its quantities are written in.


positive = st.floats(1e-3, 1e3)
factors = st.floats(1e-2, 1e2)


@given(
    st.fixed_dictionaries({name: positive for name in QUANTITIES if name not in ("n", "omega")}),
    st.floats(0.8, 2.5),
    st.tuples(factors, factors, factors),
)
def test_change_of_units(quantities, exponent, units):
    quantities |= {"n": exponent}
    stiffness = tuple(f - exponent * m for f, m in zip(FORCE, LENGTH, strict=True))
    rescaled = {}
    for name, value in quantities.items():
        dimension = stiffness if name == "k_c" else QUANTITIES[name].dimension
        mass, length, time = (unit**power for unit, power in zip(units, dimension[:3], strict=True))
        rescaled[name] = value * mass * length * time
    before, scales = si_to_dimensionless(quantities)
    after, others = si_to_dimensionless(rescaled)
    assert before.keys() == after.keys() >= {"a", "b", "xi", "eps", "eta", "mu", "g", "r", "lam", "n", "k", "phi"}
    for name, value in before.items():
        assert abs(after[name] / value - 1) < 1e-9, name
    ratio = metres_per_hour(others) / metres_per_hour(scales)
    assert abs(ratio * units[2] / units[1] - 1) < 1e-9


# Quantities with a wrong unit, a wrong sign, missing, or of nothing that is simulated.


CASES = [
    ('m1 = "250 kg"', 'm1 = "-250 kg"', "5: system.si.m1: must be greater than 0, received '-250 kg'"),
    (
        'm1 = "250 kg"',
        'm1 = "250 N"',
        "5: system.si.m1: has the wrong dimension, received '250 N'",
    ),
    ('m1 = "250 kg"', "m1 = 250", "5: system.si.m1: needs a unit, as in '250 kg'; received 250"),
    ('m1 = "250 kg"', "m1 = true", "5: system.si.m1: expected a quantity such as '250 kg', received True"),
    ('m1 = "250 kg"', 'M1 = "250 kg"', "5: system.si.M1: unknown quantity; did you mean 'm1'?"),
    ('m1 = "250 kg"', 'm1 = "1e300 kg"', "5: system.si.m1: received '1e300 kg', which makes m1/m2"),
    ('K = "4 MN/m"', 'K = "0 N/m"', "7: system.si.K: must be greater than 0"),
    ('C = "3.8 kN*s/m"', 'C = "-3.8 kN*s/m"', "8: system.si.C: must not be negative"),
    ('omega = "100 rad/s"', 'omega = "100 1/s"', "12: system.si.omega: has the wrong dimension"),
    ('omega = "100 rad/s"', 'rpm = "90 rpm"', "4: system.si.lobes: missing; a scene in SI units needs it, as in '3'"),
    ('omega = "100 rad/s"', 'omega = "9 Hz"\nlobes = 3', "4: system.si.rpm: missing"),
    ("mu_d = 0.48", "", "4: system.si.mu_d: missing; a scene in SI units needs it, as in '0.48'"),
    ("mu_d = 0.48", "mu_d = 0.9", "4: system.si: the friction ratio mu_d/mu_e must be at least 0 and at most 1"),
    ('k_c = "4.8e12 N/m"', 'k_c = "4.8e12 N/m^1.5"', "17: system.si.k_c: has the wrong dimension"),
    ('"hunt-crossley"', '"none"', "11: system.si.R: no chosen effect uses it"),
    ("[system.si]", "parameters.eta = 1\n[system.si]", "13: system.si.omega: system.parameters.eta is given too"),
]


@pytest.mark.parametrize(("old", "new", "message"), CASES, ids=[case[1] or case[0] for case in CASES])
def test_fault(in_si, faults, old, new, message):
    assert old in in_si
    assert any(line.startswith(f"scene.toml:{message}") for line in faults(in_si.replace(old, new, 1)))


def test_quantities_of_another_system(faults):
    text = '[system]\nmodel = "lorenz"\n[system.si]\nm1 = "250 kg"\n'
    assert faults(text)[0].startswith("scene.toml:3: system.si: only percussive-drill")


def test_lobes_and_rotation_make_the_frequency(in_si):
    direct = parse_scene(in_si.replace('"100 rad/s"', '"4.5 Hz"'))
    turned = parse_scene(in_si.replace('omega = "100 rad/s"', 'rpm = "90 rpm"\nlobes = 3'))
    assert turned.parameters["eta"] == pytest.approx(direct.parameters["eta"], rel=1e-14)
    assert "lobes" not in turned.parameters


def test_contact_of_another_exponent(in_si):
    scene = parse_scene(in_si.replace("n = 1", "n = 1.5").replace("4.8e12 N/m", "4.8e12 N/m^1.5"))
    # force at a depth of one dimensionless unit, which is 2 mm
    assert scene.parameters["k"] == pytest.approx(4.8e12 * 2e-3**1.5 / 8e3, rel=1e-12)
