"""The mode of a start is that whose region sympy finds to hold there, with plain arithmetic or more."""

import json

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.model.regions import UNTOLD, modes_at

CONDITIONS = {
    "plain": "x**2/3 - a*y > 1/7",
    "connectives": "((x > y) and (a*x <= 1)) or (x < -2)",
    "functions": "(sin(x) + sqrt(a) > y) and (exp(-a) < x + 3)",
    "sums under logarithms": "3*log(1 + exp(x)) > 2.2 + a*log(cosh(y))",
    "more than arithmetic": "(Abs(x) > Max(y, a)) and (floor(x) < 2)",
    "equal sides": "x - x/2 - x/2 + a - a >= 0",
}


@pytest.mark.parametrize("condition", CONDITIONS.values(), ids=CONDITIONS)
def test_a_start_is_where_its_region_holds(condition):
    system = cd.HybridSystem(
        states="x y",
        parameters={"a": 0.5},
        modes={"in": {"x": "y", "y": "-x"}, "out": {"x": "-y", "y": "x"}},
        transitions=[cd.Transition("over", "in", "out", guard="x - 9", direction=+1)],
        regions={"in": condition},
        initial={"mode": "out"},
    )
    rng = np.random.default_rng(20261126)
    states, values = rng.uniform(-4, 4, (40, 2)), rng.uniform(0.2, 2, 40)
    found, possible = modes_at(system, {"a": values}, states)
    x, y, a = (sympy.Symbol(name, real=True) for name in "xya")
    holds = [
        bool(system.regions["in"].subs({x: float(one), y: float(other), a: float(value)}))
        for (one, other), value in zip(states, values, strict=True)
    ]
    assert found.tolist() == [0 if one else UNTOLD for one in holds]
    assert possible.all()
    # what a record keeps
    assert json.loads(json.dumps(system.shared["regions"])) == system.shared["regions"]


def test_what_all_regions_ask_of_parameters_alone_makes_a_start_possible():
    system = cd.HybridSystem(
        states="x",
        parameters={"a": 0.5},
        modes={"left": {"x": "1"}, "right": {"x": "-1"}},
        regions={"left": "(x < 0) and (a < 1)", "right": "(x >= 0) and (a < 1)"},
    )
    modes, possible = modes_at(system, {"a": np.array([0.5, 2.0])}, np.array([[-1.0], [1.0]]))
    assert modes.tolist() == [0, UNTOLD]
    assert possible.tolist() == [True, False]
