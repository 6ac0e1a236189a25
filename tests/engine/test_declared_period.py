"""A period that is declared is one of the system, in any unit, or the run is refused."""

import math

import pytest
import sympy

import chaosdrill as cd
from chaosdrill.engine.period import check_period, repeats

X, T, OMEGA = sympy.symbols("x t omega", real=True)

UNITS = [1.0, 1e-10, 1e-15, 1e-30, 1e20]


def driven(drive, period, unit=1.0):
    """A decaying state with a drive, in a unit of its own, whose period cannot be proved: omega is 1 by its number."""
    return cd.HybridSystem(
        name="driven",
        states=(X,),
        parameters={"omega": 1.0},
        modes={"on": {X: unit * drive - X}},
        transitions=[cd.Transition("meets", "on", "on", guard=X / unit - drive, direction=1, reset={})],
        time=T,
        period=period,
        initial={X: unit},
    )


def test_a_period_may_hold_a_logarithm_of_exponentials():
    softplus = sympy.log(1 + sympy.exp(OMEGA))
    system = driven(sympy.cos(T / softplus), 2 * sympy.pi * softplus)
    strobed = cd.trajectory(system, periods=2, samples=2)
    assert strobed["time"].values[-1] == pytest.approx(4 * math.pi * math.log(1 + math.e), rel=1e-14)


@pytest.mark.parametrize("later", [1e6, 1e9])
def test_a_drive_with_decimal_numbers_may_begin_at_any_time(later):
    """Such phases have rounding far above what a period may be wrong by."""
    drive = sympy.sin(2.65334772785532 * (T - later))
    assert repeats(driven(drive, 2 * sympy.pi / 2.65334772785532))
    with pytest.raises(cd.ModelError, match="does not repeat after the declared period"):
        driven(drive, 2 * sympy.pi / 2.653347727)


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize(
    "drive",
    [sympy.sin(OMEGA * T), sympy.sqrt(1 + sympy.cos(OMEGA * T) ** 2), sympy.sin(1000 * OMEGA * T)],
    ids=str,
)
def test_a_period_at_the_numbers_of_the_run_is_accepted(unit, drive):
    period = sympy.Float(float(2 * sympy.pi))
    system = driven(drive, period, unit)
    check_period(system, float(period))
    assert not repeats(system)


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("period", [1.0, 6.283, 6.2832])
def test_what_is_no_period_is_refused_in_any_unit(unit, period):
    """Whether the definition is wrong, or a parameter of a run."""
    with pytest.raises(cd.ModelError, match="does not repeat after the declared period"):
        driven(sympy.sin(T), sympy.Float(period), unit)
    system = driven(sympy.sin(OMEGA * T), sympy.Float(2 * math.pi), unit)
    with pytest.raises(cd.SettingsError, match="driven does not repeat after its period"):
        cd.poincare_section(system.with_parameters(omega=2 * math.pi / period), transient=0, periods=2)


@pytest.mark.parametrize("unit", UNITS)
def test_a_rounded_period_is_one_for_a_definition_as_for_a_run(unit):
    system = driven(sympy.sin(OMEGA * T), sympy.Float(6.2831853), unit)
    check_period(system, 6.2831853)


@pytest.mark.parametrize(
    "period", ["6.2831853/omega", "2*3.1415927/omega", "43.982297/7/omega", "2*6.2831853", "turn", "2*turn", "turn/2"]
)
def test_a_number_of_a_period_may_be_rounded_wherever_it_stands(period):
    rate = 2 if period == "turn/2" else 1
    one = {"parameters": {"omega": 1.0, "turn": 6.2831853}, "modes": {"on": {"x": f"cos({rate}*omega*t) - x"}}}
    system = cd.HybridSystem(states="x", period=period, **one)
    assert cd.trajectory(system, periods=1, samples=2)["time"].values[-1] == pytest.approx(
        6.2831853 * {"2*6.2831853": 2, "2*turn": 2, "turn/2": 0.5}.get(period, 1)
    )


@pytest.mark.parametrize(
    ("parameters", "period"),
    [
        ({"omega": 1.3, "turn": 6.2831853}, "turn/omega"),
        ({"omega": 1.3, "turn": 6.2831853}, "turn*omega**-1"),
        ({"omega": 3.1415927, "turn": 2.0}, "turn"),
        ({"omega": 3.1415927, "turn": 2.0}, "2*pi/omega"),
    ],
)
def test_a_parameter_of_a_period_may_be_rounded_as_a_number_may(parameters, period):
    rate = "cos(omega*t) + cos(2*pi*t/turn) - x" if parameters["turn"] == 2.0 else "cos(omega*t) - x"
    system = cd.HybridSystem(states="x", parameters=parameters, period=period, modes={"on": {"x": rate}})
    end = {"turn": 2.0, "2*pi/omega": 2 * math.pi / 3.1415927}.get(period, 6.2831853 / 1.3)
    assert cd.trajectory(system, periods=1, samples=2)["time"].values[-1] == pytest.approx(end, rel=1e-15)


def test_a_parameter_of_few_digits_is_meant_as_it_stands():
    with pytest.raises(cd.ModelError, match="does not repeat after the declared period"):
        cd.HybridSystem(
            states="x",
            parameters={"omega": 1.3, "turn": 6.283},
            period="turn/omega",
            modes={"on": {"x": "cos(omega*t) - x"}},
        )


@pytest.mark.parametrize(
    "period",
    ["2*pi/omega*(1 + 1e-9)", "2*pi/omega*(1 + 1/10**9)", "2*pi/(omega - 1e-7)", "2*pi/omega*(1.5 - 0.4999999)"],
)
def test_what_is_added_to_a_period_is_no_rounding_of_its_numbers(period):
    """However it is written: half a unit of the last digit of a number is less."""
    with pytest.raises(cd.ModelError, match="does not repeat after the declared period"):
        cd.HybridSystem(states="x", parameters={"omega": 1.0}, period=period, modes={"on": {"x": "cos(omega*t) - x"}})
