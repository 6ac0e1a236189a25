"""One commit's package measures a case at every line that comes in; started by ``commits.py``.

    python worker.py < cases > answers

A case is a line of JSON, an answer a number: microseconds of processor time a forcing period (of a point).
"""

import json
import math
import sys
import time
from functools import cache
from typing import Any

import numpy as np

import chaosdrill as cd
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.engine.structure import examine

SETTLE = 300
"""Forcing periods before a single run is measured, and of a chart's transient."""


def run(eta: float, tangents: int, tolerance: float, periods: int) -> float:
    """A single run of the drill from rest, settled."""
    system = cd.drill(eta=eta)
    one = Run(
        system,
        2 * math.pi / eta,
        Numerics(tolerance=tolerance),
        tangents=np.eye(3)[:tangents],
        deficient=examine(system).deficient,
    )
    one.advance(SETTLE)
    begin = time.process_time()
    outcome, _ = one.advance(periods)
    spent = time.process_time() - begin
    if outcome != cd.Outcome.OK:
        raise SystemExit(f"the run at eta {eta} ended with {outcome.name}")
    return spent / periods * 1e6


@cache
def chart_system() -> Any:
    """The drill, with its kernels."""
    system = cd.drill()
    examine(system)
    return system


def chart(eta: float, side: int, width: float, tolerance: float, periods: int) -> float:
    """A chart of the drill over eta and the load, all that belongs to it but the writing of its equations."""
    system = chart_system()
    middles = {"eta": eta, "b": system.parameters["b"]}
    sweep = {name: np.linspace(value - width / 2, value + width / 2, side) for name, value in middles.items()}
    begin = time.process_time()
    cd.parameter_chart(
        system, sweep, transient=SETTLE, periods=periods, exponents=2, max_extension=0, tolerance=tolerance
    )
    return (time.process_time() - begin) / (side**2 * (SETTLE + periods)) * 1e6


def main() -> None:
    """Answer until the input ends."""
    kinds: dict[str, Any] = {"run": run, "chart": chart}
    for line in sys.stdin:
        case = json.loads(line)
        print(kinds[case.pop("kind")](**case), flush=True)


if __name__ == "__main__":
    main()
