"""Saddle flow that is sent back with a tripling.

    x' = x,  y' = -y,  z' = -0.7 z;   at x = 1: x := 3 y mod 1, y := 1, z := z + sin(3 y)/2

Started at y = 1 the return map is x -> 3 x mod 1 in time -ln x, of mean 1: the exponents are ln 3, 0 and -0.7 per unit
time. Three, because doubling collapses in binary floating point. Made for testing.
"""

from chaosdrill.declared import event

NAME = "saddle-reset"
SUMMARY = "saddle flow with a tripling reset"
GROUP = "maps for tests"
STATES = {"x": "unstable coordinate", "y": "stable coordinate", "z": "driven coordinate"}
PARAMETERS = {
    "decay": (0.7, "decay rate of the driven coordinate"),
}
reset = {"x": "Mod(3*y, 1)", "y": "1", "z": "z + sin(3*y)/2"}
EQUATIONS = {
    "modes": {"saddle": {"x": "x", "y": "-y", "z": "-decay*z"}},
    "transitions": [event("return", "saddle", "saddle", guard="x - 1", direction=+1, reset=reset)],
    "initial": {"mode": "saddle", "x": 0.3141592653589793, "y": 1.0, "z": 0.0},
}
