"""Spoked wheel without a rim that rolls down a slope, an inverted pendulum from spoke to spoke.

    th'' = sin th;   at th = gamma + alpha: th := gamma - alpha, om := cos(2 alpha) om, and the mirror image uphill

Half the angle between spokes is alpha, the slope gamma; lengths and gravity are 1. The rolling gait has the multipliers
1 and cos^2(2 alpha) exactly. Source: McGeer 1990, doi:10.1177/027836499000900206.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

NAME = "rimless-wheel"
SUMMARY = "spoked wheel that rolls down a slope"
GROUP = "walkers"
CITES = ("mcgeer1990",)
STATES = ("th", "om")
PARAMETERS = {"alpha": 0.3, "gamma": 0.15}
LABELS = {
    "th": "angle of the stance spoke from the vertical",
    "om": "angular velocity",
    "alpha": "half the angle between spokes",
    "gamma": "slope",
}


def system() -> "HybridSystem":
    """The rimless wheel with default parameters, started on its rolling gait's side."""
    import sympy

    from chaosdrill.model import HybridSystem, Transition

    th, om, alpha, gamma = sympy.symbols("th om alpha gamma", real=True)
    loss = {om: sympy.cos(2 * alpha) * om}
    return HybridSystem(
        name=NAME,
        states=(th, om),
        parameters=PARAMETERS,
        modes={"stance": {th: om, om: sympy.sin(th)}},
        transitions=[
            Transition(
                "step",
                source="stance",
                target="stance",
                guard=th - gamma - alpha,
                direction=+1,
                reset={th: gamma - alpha, **loss},
                kind="impact",
            ),
            Transition(
                "step-back",
                source="stance",
                target="stance",
                guard=th - gamma + alpha,
                direction=-1,
                reset={th: gamma + alpha, **loss},
                kind="impact",
            ),
        ],
        initial={"mode": "stance", th: 0.0, om: 0.5},
        description=SUMMARY,
        labels=LABELS,
    )
