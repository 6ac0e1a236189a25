"""A drill from quantities with units in Python is that of the scene with the same quantities."""

import math
import tomllib

import pytest

import chaosdrill as cd
from chaosdrill.errors import ChaosdrillError, ModelError, SettingsError


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
        ({"K": None}, ModelError, "K have to be given too, as in K='4e6 N/m'"),
        ({"eta": 0.8}, ModelError, "omega: eta is given too"),
        ({"mass": "250 kg"}, ModelError, "unknown parameter 'mass'"),
        ({"eta": "0.8"}, ChaosdrillError, "eta"),
        ({"m1": "1e300 kg"}, ModelError, "m1: received '1e300 kg', which makes m1/m2 .8e\\+297. too large"),
        (
            {"m1": "1e-300 kg"},
            ModelError,
            "m1: received '1e-300 kg', which makes m1/m2 .8e-303. too large or",
        ),
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
