"""A system without forcing has a diagram once it is given a unit of time and a section, as the error says."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.scene import parse_scene

X, Y, Z, C = sympy.symbols("x y z c", real=True)
A = sympy.Rational(1, 5)
SCENE = """
system.model = 'lorenz'
[analysis.a]
kind = 'bifurcation-diagram'
sweep.rho = [28.0]
transient = 1
periods = 8
"""


def roessler(**more):
    field = {X: -Y - Z, Y: X + A * Y, Z: A + Z * (X - C)}
    turn = cd.Transition("turn", "flow", "flow", guard=Y, direction=+1, reset={})
    start = {X: 1.0, Y: 1.0}
    return cd.HybridSystem(
        name="turns",
        states=(X, Y, Z),
        parameters={"c": 2.5},
        modes={"flow": field},
        transitions=[turn],
        initial=start,
        **more,
    )


def test_what_to_do_is_said():
    with pytest.raises(cd.SettingsError, match=r"turns has no forcing period.* define it with a period.* at='turn'"):
        cd.bifurcation_diagram(roessler(), sweep={"c": [2.5]}, transient=1, periods=8)
    with pytest.raises(cd.SceneError, match=r"lorenz has no forcing period, .*a transition that marks a section"):
        cd.check(parse_scene(SCENE))


@pytest.mark.parametrize("unit", [5, 7])
def test_it_works_whatever_the_unit(unit):
    """One turn, two turns, chaos (Strogatz 2015, section 12.3; exponent 0.0714: Sprott 2003), whatever the unit."""
    found = cd.bifurcation_diagram(
        roessler(period=sympy.Integer(unit)),
        sweep={"c": [2.5, 3.5, 5.7]},
        transient=100,
        periods=400,
        exponents=2,
        at="turn",
    )
    assert found["period"].values.ravel().tolist() == [1, 2, 0]
    assert [cd.Outcome(int(o)).name for o in found["outcome"].values.ravel()] == ["PERIODIC", "PERIODIC", "CHAOTIC"]
    exponent = found["lyapunov_exponent"].values[:, 0]
    assert np.all(np.abs(exponent[:2, 0]) < 1e-3)
    assert abs(exponent[2, 0] - 0.0714) < 2 * float(found["lyapunov_error"].values[2, 0, 0]) < 0.02
