"""A tripling map whose stretching is all saltation.

    rising:  x' = 1/2,  s' = 1  until s = 1 + x
    falling: x' = -1/2, s' = 1  until s = 5;   then x := (x + 1/2) mod 1, s := 0

The return map is x -> 3 x mod 1 in time 5, so the exponents are ln(3)/5 and 0 exactly, and a code without saltation
prints 0, 0. Made for testing; on piecewise-smooth flows see di Bernardo et al. 2008,
doi:10.1007/978-1-84628-708-4.
"""

from chaosdrill.declared import event

NAME = "tilted-switch"
SUMMARY = "tripling map from a tilted switching line"
GROUP = "maps for tests"
STATES = {"x": "position", "s": "clock"}
PARAMETERS: dict[str, tuple[float, str]] = {}
EQUATIONS = {
    "modes": {"rising": {"x": "1/2", "s": "1"}, "falling": {"x": "-1/2", "s": "1"}},
    "transitions": [
        event("switch", "rising", "falling", guard="s - 1 - x", direction=+1),
        event("return", "falling", "rising", "s - 5", direction=+1, reset={"x": "Mod(x + 1/2, 1)", "s": "0"}),
    ],
    "initial": {"mode": "rising", "x": 0.2718281828459045, "s": 0.0},
}
