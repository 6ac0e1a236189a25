"""A user's own functions of an orbit, from outside: the impact oscillator and the linear one in closed form."""

from math import pi, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq
from support import closed_impact as impact

import chaosdrill as cd
from chaosdrill.dataset.branches import Special

ZETA, E, WALL = 0.05, 0.8, 0.3

FUNCTIONS = {
    "speed": {"of": "v", "take": "maximum", "at": "impact", "units": "m s-1"},
    "lost": {"of": "(1 - e**2)*v**2/2", "take": "total", "at": "impact"},
    "damped": {"of": "2*zeta*v**2", "take": "total"},
    "power": {"of": "amplitude*cos(omega*t)*v"},
    "highest": {"of": "x", "take": "maximum"},
    "swing": {"of": "v", "take": "maximum"},
    "time": {"of": "1", "take": "total", "modes": ["free"]},
}


@pytest.fixture(scope="module")
def oscillator():
    return cd.build("impact-oscillator").with_parameters(omega=1.9, zeta=ZETA, e=E, wall=WALL)


@pytest.fixture(scope="module")
def branch(oscillator):
    """Through the largest speed of the impact, which a level of 0.6 is behind."""
    wanted = {"functions": FUNCTIONS, "levels": {"speed": [0.6]}, "optima": ["speed"]}
    return cd.continue_orbit(oscillator, {"omega": (1.75, 2.05)}, step=0.01, **wanted)


def speed(omega, wall=WALL):
    """The speed of the fast orbit with one impact a period."""
    return max(orbit.speed for orbit in impact.one_impact(omega, wall, ZETA, E))


def slope(omega, wall=WALL, h=1e-4):
    """Of that speed over the frequency, to the fourth power of the step."""
    far, near = (speed(omega + k * h, wall) - speed(omega - k * h, wall) for k in (2, 1))
    return (8 * near - far) / (12 * h)


def of(dataset, name):
    """Values and errors of a function."""
    return (dataset[v].sel(function=name).values for v in ("function_value", "function_error"))


def special(dataset, kind):
    """Parameters of the special points of a kind, their errors, and what is said of them."""
    chosen = dataset["special_kind"].values == kind
    names = [name for name in ("special_value", "special_value_2") if name in dataset]
    values = np.array([dataset[name].values[chosen] for name in names]).T
    return values, dataset["special_error"].values[chosen], dataset["special_text"].values[chosen]


def test_the_speed_of_the_impact_is_that_of_the_closed_form(branch):
    values, errors = of(branch, "speed")
    assert branch["branch"].size > 50
    known = [
        min((orbit.speed for orbit in impact.one_impact(w, WALL, ZETA, E)), key=lambda v: abs(v - value))
        for w, value in zip(branch["omega"].values, values, strict=True)
    ]
    np.testing.assert_allclose(values, known, atol=1e-10)
    assert (np.abs(values - known) <= 2 * errors).mean() >= 0.95


def test_what_the_forcing_does_is_lost_by_damping_and_impacts(branch):
    """The power, a mean, against totals over time and events; the last of these against the closed form."""
    power, damped, lost, time = (np.array(list(of(branch, name))) for name in ("power", "damped", "lost", "time"))
    np.testing.assert_allclose(time[0], 2 * pi / branch["omega"], rtol=1e-12)
    np.testing.assert_allclose(lost[0], (1 - E**2) / 2 * np.array(list(of(branch, "speed")))[0] ** 2, rtol=1e-12)
    off = np.abs(power[0] * time[0] - damped[0] - lost[0])
    assert (off <= 2 * (power[1] * time[0] + damped[1] + lost[1])).mean() >= 0.95
    np.testing.assert_allclose(off, 0, atol=1e-9)


def test_the_highest_point_is_the_wall(branch):
    values, errors = of(branch, "highest")
    assert (np.abs(values - WALL) <= 2 * errors).all()


def test_the_largest_speed_along_the_branch(branch):
    values, errors, texts = special(branch, Special.OPTIMUM)
    known = brentq(slope, 1.88, 1.9, xtol=1e-15)
    assert len(values) == 1
    assert abs(values[0, 0] - known) <= 2 * errors[0] < 1e-9
    assert texts[0] == f"speed has a maximum of {speed(known):.9g}"


def test_where_the_speed_takes_a_value(branch):
    values, errors, texts = special(branch, Special.LEVEL)
    fast = brentq(lambda w: speed(w) - 0.6, 2.0, 2.05, xtol=1e-15)
    assert len(values) == 1
    assert abs(values[0, 0] - fast) <= 2 * errors[0] < 1e-10
    assert texts[0] == "speed = 0.6"


def test_a_constraint_is_held_over_two_parameters(oscillator):
    over = {"omega": (1.8, 2.05), "wall": (0.2, 0.4)}
    held = {"functions": FUNCTIONS, "levels": {"speed": [3.5]}, "follow": "level", "step": 0.02}
    curve = cd.continue_orbit(oscillator, over, **held)
    walls = curve["wall"].values
    assert [walls.min(), walls.max()] == pytest.approx([0.2, 0.4])
    for omega, wall in zip(curve["omega"].values, walls, strict=True):
        assert speed(omega, wall) == pytest.approx(3.5, abs=1e-11)


def test_optima_are_followed_over_a_second_parameter(oscillator):
    over = {"omega": (1.8, 2.05), "wall": (0.2, 0.4)}
    wanted = {"functions": FUNCTIONS, "optima": ["speed"], "follow": "optimum", "step": 0.02}
    curve = cd.continue_orbit(oscillator, over, **wanted)
    walls, omegas = curve["wall"].values, curve["omega"].values
    assert [walls.min(), walls.max()] == pytest.approx([0.2, 0.4])
    known = [brentq(slope, w - 5e-3, w + 5e-3, (d,), xtol=1e-15) for w, d in zip(omegas, walls, strict=True)]
    np.testing.assert_allclose(omegas, known, atol=1e-10)


def free(oscillator, omega, zeta):
    """The motion that never meets the wall, of amplitude 1/sqrt((1 - w^2)^2 + (2 zeta w)^2)."""
    return oscillator.with_parameters(wall=50.0, omega=omega, zeta=zeta)


def test_an_optimum_under_a_constraint(oscillator):
    """Where the amplitude is A the power is A^2 w sqrt(c - (1 - w^2)^2)/2, c = 1/A^2, over w: largest where
    3 w^2 = 2 + sqrt(1 + 3 c)."""
    start, height = free(oscillator, 1.05, 0.2), impact.amplitude(1.05, 0.2)
    over = {"omega": (0.8, 1.3), "zeta": (0.05, 0.4)}
    held = {"levels": {"highest": [height]}, "optima": ["power"], "follow": "level", "step": 0.02}
    curve = cd.continue_orbit(start, over, functions=FUNCTIONS, **held)
    values, errors, texts = special(curve, Special.OPTIMUM)
    c = 1 / height**2
    u = (2 + sqrt(1 + 3 * c)) / 3
    zeta = sqrt((c - (1 - u) ** 2) / (4 * u))
    assert len(values) == 1
    assert abs(values[0, 0] - sqrt(u)) <= 2 * errors[0] < 1e-8
    assert values[0, 1] == pytest.approx(zeta, abs=1e-8)
    assert texts[0].startswith("power has a maximum")
    assert float(texts[0].split()[-1]) == pytest.approx(height**2 * zeta * u, rel=1e-8)


def test_an_optimum_over_both_parameters(oscillator):
    """A zeta exp(-zeta) is largest over w at w^2 = 1 - 2 zeta^2, where it is exp(-zeta)/(2 sqrt(1 - zeta^2)), which is
    smallest where zeta = 1 - zeta^2."""
    golden = (sqrt(5) - 1) / 2
    start = free(oscillator, 0.55, 0.58)
    over = {"omega": (0.3, 0.7), "zeta": (0.55, 0.66)}
    functions = {"f": {"of": "x*zeta*exp(-zeta)", "take": "maximum"}}
    curve = cd.continue_orbit(start, over, functions=functions, optima=["f"], follow="optimum", step=0.02)
    np.testing.assert_allclose(curve["omega"] ** 2, 1 - 2 * curve["zeta"] ** 2, atol=1e-9)
    values, errors, texts = special(curve, Special.OPTIMUM)
    inner = [k for k, text in enumerate(texts) if "minimum" in text]
    assert len(inner) == 1
    assert abs(values[inner[0], 0] - sqrt(1 - 2 * golden**2)) <= 2 * errors[inner[0]] < 1e-7
    assert values[inner[0], 1] == pytest.approx(golden, abs=1e-7)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"functions": {"f": {"of": "x + z"}}}, r"functions\.f\.of.*'z'"),
        ({"functions": {"f": {"of": "x", "at": "impct"}}}, r"functions\.f\.at.*did you mean 'impact'"),
        ({"functions": {"f": {"of": "x", "modes": ["fly"]}}}, r"functions\.f\.modes.*'fly'.*known here: free"),
        ({"functions": {"f": {"of": "x", "take": "most"}}}, r"functions\.f\.take.*'most'.*maximum"),
        ({"functions": {"f": {"take": "mean"}}}, r"functions.*of.*missing"),
        ({"functions": {}}, "functions.*table of functions"),
        ({"levels": {"f": [1.0]}}, r"levels.*name it in functions"),
        ({"functions": {"f": {"of": "x"}}, "optima": ["g"]}, r"optima.*'g'"),
        ({"functions": {"f": {"of": "x"}}, "levels": {"f": 1.0}}, r"levels\.f.*list"),
    ],
)
def test_what_is_wrong_is_named(oscillator, given, words):
    with pytest.raises(cd.SettingsError, match=words):
        cd.continue_orbit(oscillator, {"omega": (1.8, 2.0)}, **given)


@pytest.mark.parametrize(("follow", "words"), [("level", "levels.*one level of one"), ("optimum", "optima.*one func")])
def test_what_is_followed_has_to_be_named(oscillator, follow, words):
    with pytest.raises(cd.SettingsError, match=words):
        cd.continue_orbit(oscillator, {"omega": (1.8, 2.0), "wall": (0.2, 0.4)}, follow=follow)


def test_an_orbit_has_them_too(oscillator):
    """The two orbits with one impact at 1.9, of which a search finds both."""
    known = sorted(orbit.speed for orbit in impact.one_impact(1.9, WALL, ZETA, E) if orbit.highest < WALL)
    orbit = cd.periodic_orbit(oscillator, functions=FUNCTIONS)
    value, error = (float(orbit[name].sel(function="speed")) for name in ("function_value", "function_error"))
    assert min(abs(value - one) for one in known) <= 2 * error < 1e-10
    assert orbit["function_units"].values.tolist()[0] == "m s-1"
    every = cd.periodic_orbit(oscillator, functions=FUNCTIONS, start="search", max_period=1)
    found = every["function_value"].sel(function="speed").values
    assert sorted(found) == pytest.approx(known, abs=1e-10)


def test_without_such_an_event_there_is_no_largest_speed(oscillator):
    quiet = cd.periodic_orbit(free(oscillator, 1.9, ZETA), functions=FUNCTIONS)
    values = dict(zip(quiet["function"].values.tolist(), quiet["function_value"].values.tolist(), strict=True))
    assert np.isnan(values["speed"])
    assert "speed on 1 of 1 orbits" in quiet.attrs["functions_message"]
    assert values["lost"] == 0
    height = impact.amplitude(1.9, ZETA)
    assert values["highest"] == pytest.approx(height, abs=1e-11)
    assert values["swing"] == pytest.approx(1.9 * height, abs=1e-11)
    assert values["power"] == pytest.approx(ZETA * (1.9 * height) ** 2, abs=1e-11)


def test_a_function_outside_its_domain_has_no_value_and_says_so(oscillator):
    functions = {"root": {"of": "sqrt(x - 10)"}, "same": {"of": "x"}}
    orbit = cd.periodic_orbit(oscillator, functions=functions)
    assert np.isnan(orbit["function_value"].values).tolist() == [True, False]
    assert "no value: root on 1 of 1 orbits; outside its domain" in orbit.attrs["functions_message"]


def test_a_scene_has_them(tmp_path):
    scene = tmp_path / "scene.toml"
    lines = '[system]\nmodel = "impact-oscillator"\n[analysis.orbit]\nkind = "periodic-orbit"\n'
    scene.write_text(lines + 'functions.f = { of = "z", at = "hit" }\n')
    with pytest.raises(cd.SceneError) as caught:
        cd.check(scene)
    assert "5: analysis.orbit.functions.f.of: unknown name 'z'" in str(caught.value)
    assert "5: analysis.orbit.functions.f.at: unknown event 'hit'" in str(caught.value)


def test_without_a_branch_there_are_no_columns(oscillator):
    wild = oscillator.with_initial(x=0.0, v=0.0).with_parameters(amplitude=0.0, wall=0.3)
    nothing = cd.continue_orbit(wild, {"omega": (1.8, 2.0)}, functions=FUNCTIONS, transient=0)
    assert nothing.sizes["point"] == 0
    assert nothing["function_value"].shape == (0, len(FUNCTIONS))


# Python functions of the orbit's record.


def highest(orbit):
    return orbit.maximum(orbit.states["x"])


def power(orbit):
    force = orbit.parameters["amplitude"] * np.cos(orbit.parameters["omega"] * orbit.times)
    return orbit.mean(force * orbit.states["v"])


def hit(orbit):
    return orbit.event_states["v"].max()


def trace(orbit):
    return orbit.multipliers.sum().real


@pytest.fixture(scope="module")
def pythonic(oscillator):
    """The same branch as `branch` in larger steps, with functions in Python beside the expressions."""
    both = {"speed": hit, "highest": highest, "power": {"of": power, "units": "W"}}
    tables = {f"{name} in words": FUNCTIONS[name] for name in both}
    wanted = {"functions": {**both, **tables, "trace": trace}, "levels": {"speed": [0.6]}, "optima": ["speed"]}
    return cd.continue_orbit(oscillator, {"omega": (1.85, 2.05)}, step=0.02, **wanted)


@pytest.mark.parametrize("name", ["speed", "highest", "power"])
def test_a_python_function_has_the_values_of_the_expression(pythonic, name):
    values, errors = of(pythonic, name)
    known, off = of(pythonic, f"{name} in words")
    assert (np.abs(values - known) <= errors + off).all()
    assert errors.max() < 1e-9
    told = str(pythonic.sel(function=name)["function_expression"].values)
    assert told == f"Python function {'hit' if name == 'speed' else name}"


def test_a_python_function_is_located_as_an_expression_is(pythonic):
    values, errors, _ = special(pythonic, Special.OPTIMUM)
    assert abs(values[0, 0] - brentq(slope, 1.88, 1.9, xtol=1e-15)) <= 2 * errors[0] < 1e-9
    values, errors, _ = special(pythonic, Special.LEVEL)
    assert abs(values[0, 0] - brentq(lambda w: speed(w) - 0.6, 2.0, 2.05, xtol=1e-15)) <= 2 * errors[0] < 1e-10


def test_a_python_function_sees_the_multipliers(pythonic):
    known = pythonic["multiplier_real"].sum("multiplier").values
    values, _ = of(pythonic, "trace")
    np.testing.assert_allclose(values, known, atol=1e-9)


def test_a_test_function_of_a_user_is_located_with_its_error():
    """Where the fixed point of r x (1 - x), 1 - 1/r, has the multiplier 2 - r of -1/2."""
    system = cd.Map(states="x", parameters={"r": 2.2}, images={"x": "r*x*(1 - x)"}, initial={"x": 0.5})
    functions = {"half": lambda orbit: orbit.multipliers[0].real + 0.5}
    found = cd.continue_orbit(system, {"r": (2.2, 2.9)}, functions=functions, levels={"half": [0.0]})
    values, errors, texts = special(found, Special.LEVEL)
    assert abs(values[0, 0] - 2.5) <= 2 * errors[0] < 1e-11
    assert texts.tolist() == ["half = 0"]


def test_a_level_of_a_python_function_is_held_over_two_parameters(oscillator):
    over = {"omega": (1.9, 1.95), "wall": (0.28, 0.32)}
    held = {"functions": {"speed": hit}, "levels": {"speed": [3.5]}, "follow": "level", "step": 0.02}
    curve = cd.continue_orbit(oscillator, over, **held)
    assert curve.sizes["point"] > 2
    for omega, wall in zip(curve["omega"].values, curve["wall"].values, strict=True):
        assert speed(omega, wall) == pytest.approx(3.5, abs=1e-11)


@pytest.mark.parametrize(
    ("function", "told"),
    [
        (lambda orbit: orbit.states["y"].max(), "KeyError('y')"),
        (lambda orbit: orbit.states["x"], "which is no number"),
        (lambda orbit: 1j, "which is no number"),
    ],
)
def test_what_a_python_function_raises_is_told(oscillator, function, told):
    found = cd.periodic_orbit(oscillator, functions={"wrong": function})
    assert int(found["outcome"]) == cd.Outcome.PERIODIC
    assert np.isnan(float(found["function_value"][0]))
    assert told in found.attrs["functions_message"]


@pytest.mark.parametrize(
    ("table", "told"),
    [
        ({"of": hit, "take": "maximum"}, "sees the whole orbit"),
        ({"of": hit, "at": "impact"}, "sees the whole orbit"),
        ({"of": "Python function hit"}, "pass the function itself"),
    ],
)
def test_what_a_python_function_cannot_have(oscillator, table, told):
    with pytest.raises(cd.SettingsError, match=told):
        cd.periodic_orbit(oscillator, functions={"speed": table})
