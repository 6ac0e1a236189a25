"""Kuramoto's rotors in their mean field, 50 of them.

    x_k' = w_k + K/N sum_j sin(x_j - x_k),  w_k evenly between -1 and 1

A sum of angles only turns. Locked, the exponents sum to K (1 - N r^2) with the order parameter r. Source: Kuramoto
1984, doi:10.1007/978-3-642-69689-3.
"""

NAME = "kuramoto"
SUMMARY = "50 rotors of Kuramoto in their mean field"
GROUP = "smooth flows"
N = 50
STATES = {f"x{k}": f"angle of rotor {k}" for k in range(N)}
PARAMETERS = {"K": (3.0, "coupling")}
_sines, _cosines = (" + ".join(f"{f}({angle})" for angle in STATES) for f in ("sin", "cos"))
_RATES = {
    angle: f"{2 * k / (N - 1) - 1!r} + K*(({_sines})*cos({angle}) - ({_cosines})*sin({angle}))/{N}"
    for k, angle in enumerate(STATES)
}
EQUATIONS = {
    "modes": {"flow": _RATES},
    "initial": {"mode": "flow", **{angle: 2.4 * k for k, angle in enumerate(STATES)}},
}
"""The rotors with default parameters, which lock."""
