"""Kuramoto's rotors in their mean field, 50 of them.

    x_k' = w_k + K/N sum_j sin(x_j - x_k),  w_k evenly between -1 and 1

A sum of angles only turns. Locked, the exponents sum to K (1 - N r^2) with the order parameter r. Source: Kuramoto
1984, doi:10.1007/978-3-642-69689-3.
"""

from typing import Any

NAME = "kuramoto"
SUMMARY = "50 rotors of Kuramoto in their mean field"
GROUP = "smooth flows"
N = 50
STATES = {f"x{k}": f"angle of rotor {k}" for k in range(N)}
PARAMETERS = {"K": (3.0, "coupling")}


def equations() -> dict[str, Any]:
    """The rotors with default parameters, which lock."""

    def speed(k: int) -> float:
        return 2 * k / (N - 1) - 1

    x = tuple(STATES)
    sines, cosines = (" + ".join(f"{f}({angle})" for angle in x) for f in ("sin", "cos"))
    return {
        "modes": {
            "flow": {x[k]: f"{speed(k)!r} + K*(({sines})*cos({x[k]}) - ({cosines})*sin({x[k]}))/{N}" for k in range(N)},
        },
        "initial": {"mode": "flow", **{x[k]: 2.4 * k for k in range(N)}},
    }
