"""What can be asked for by name: kinds of analysis and numerical methods. Imports nothing heavy."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Entry:
    """One kind of analysis: its name in scenes, its function in ``chaosdrill.analysis``, and a line about it."""

    kind: str
    function: str
    summary: str


_ENTRIES = (
    Entry("trajectory", "trajectory", "states over time, with every event"),
    Entry("poincare-section", "poincare_section", "states at every strobe or event, period and multipliers"),
    Entry("lyapunov-spectrum", "lyapunov_spectrum", "Lyapunov exponents with error bars, -inf where rank is lost"),
    Entry("bifurcation-diagram", "bifurcation_diagram", "section, period, exponents and outcome along a parameter"),
    Entry("parameter-chart", "parameter_chart", "period, exponents, rates, outcome and attractors over two parameters"),
    Entry("basins", "basins", "which attractor each initial state of a grid leads to, and the part that does"),
    Entry("periodic-orbit", "periodic_orbit", "an orbit, stable or not, or all up to a period; multipliers and events"),
    Entry(
        "continuation",
        "continue_orbit",
        "branches of orbits along a parameter with what happens on them; curves in two",
    ),
    Entry("work-precision", "work_precision", "errors against time over methods and tolerances, with a recommendation"),
)

ANALYSES = {entry.kind: entry for entry in _ENTRIES}

METHODS = {
    "taylor": "adaptive Taylor series of variable order; events are roots of the guards' polynomials",
    "dop853": "adaptive Runge-Kutta of order 8, for right-hand sides that are not analytic; events as for taylor",
    "rk4": "fixed-step Runge-Kutta of order 4 with bisection, the method of the paper",
}

FIXED_STEP = ("rk4",)
"""Methods that are told how many steps a period has."""
