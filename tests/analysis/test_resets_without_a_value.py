"""A reset that divides by zero, or gives what no double holds, ends a run with an outcome, in every analysis.

Warnings are errors in all tests: numpy's own about such numbers would show here.
"""

from functools import partial

import pytest
import sympy
from support.short_calls import short_calls

import chaosdrill as cd
from chaosdrill.dataset import Outcome
from chaosdrill.declared import ANALYSES

SHORT = short_calls(("x", [-0.3, 0.0]), ("v", [0.0, 0.3]), ("w", [2.6, 2.7]), ("d", [0.1, 0.2]))
FORCED = {
    **{name: partial(getattr(cd, name), **given) for name, given in SHORT.items()},
    "dop853": lambda system: cd.trajectory(system, periods=20, method="dop853"),
    "rk4": lambda system: cd.trajectory(system, periods=20, method="rk4"),
    "section": lambda system: cd.poincare_section(system, periods=20, at="zero"),
    "attracted": lambda system: cd.periodic_orbit(system, start="attractor"),
}
FREE = {
    "trajectory": lambda system: cd.trajectory(system, duration=60.0),
    "lyapunov_spectrum": lambda system: cd.lyapunov_spectrum(system, duration=60.0),
    "poincare_section": lambda system: cd.poincare_section(system, duration=60.0, at="zero"),
    "periodic_orbit": lambda system: cd.periodic_orbit(system, start="guess"),
    "search": lambda system: cd.periodic_orbit(system, start="search", max_period=1),
    "continue_orbit": lambda system: cd.continue_orbit(system, {"d": (0.05, 0.1)}, max_points=5),
}
RESETS = ["1/x", "log(x)", "x**(-1/2)", "10**300*exp(600 + x)"]
RUNS = ("trajectory", "lyapunov_spectrum", "poincare_section")
"""Where each kind of reset is tried: it ends the run; all analyses see its outcome alone, whatever the reset was."""


def system(reset, forced):
    """An oscillator, driven or driving itself, with a third state that is reset where x is zero."""
    drive = "cos(w*t) - d*v" if forced else "d*v*(1 - x**2)"
    return cd.HybridSystem(
        name="no number",
        states=["x", "v", "y"],
        time="t" if forced else None,
        parameters={"w": 2.7, "d": 0.1},
        modes={"all": {"x": "v", "v": f"-x + {drive}", "y": "-y"}},
        transitions=[cd.Transition("zero", "all", "all", guard="x", direction=1, reset={"y": reset})],
        period=2 * sympy.pi / sympy.Symbol("w", real=True) if forced else None,
        initial={"x": -0.3},
    )


def test_every_analysis_is_called():
    assert {entry.function for entry in ANALYSES.values()} <= {*FORCED, "equilibria"}  # which takes no reset


@pytest.mark.parametrize("reset", RESETS)
@pytest.mark.parametrize(("forced", "calls"), [(True, FORCED), (False, FREE)], ids=["forced", "free"])
def test_a_reset_without_a_value_is_an_outcome(reset, forced, calls):
    tried = system(reset, forced)
    for name in calls if reset == RESETS[0] else RUNS:
        found = calls[name](tried)
        if name == "basin_measures":
            assert found["fraction_none"] == 1
            assert found.sizes["attractor"] == 0
            continue
        outcomes = set(found["outcome"].values.ravel().tolist())
        # a start above the guard may never come to it, and a search then finds no orbit
        assert outcomes <= {Outcome.NONFINITE, Outcome.ESCAPED}, name
        assert outcomes or name in ("search", "periodic_orbit")
