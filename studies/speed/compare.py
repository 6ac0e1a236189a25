"""Time of the drill with two tangents, in turn with another program that does the same; ratios of medians.

    python studies/speed/compare.py --against "PROGRAM {eta} {periods} {tolerance} --lyap"

The other program prints one line of JSON with ``us_per_period``, microseconds a forcing period without start-up. Each
round runs both one after the other, so that a change of the machine's speed meets both.
"""

import argparse
import json
import shlex
import subprocess
import time
from statistics import median

import numpy as np

import chaosdrill as cd
from chaosdrill.engine.run import Numerics, Run
from chaosdrill.engine.structure import examine


def own_time(eta: float, periods: int, tolerance: float, tangents: int) -> float:
    """Microseconds a forcing period after a transient of 300 periods."""
    system = cd.drill(eta=eta)
    period = system.forcing_period()
    assert period is not None
    run = Run(
        system,
        period,
        Numerics(tolerance=tolerance),
        tangents=np.eye(3)[:tangents],
        deficient=examine(system).deficient,
    )
    run.advance(300)
    begin = time.perf_counter()
    run.advance(periods)
    return (time.perf_counter() - begin) / periods * 1e6


def other_time(command: str, **values: float) -> float:
    """What the other program reports."""
    words = [word.format(**values) for word in shlex.split(command)]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    return float(json.loads(done.stdout.strip().splitlines()[-1])["us_per_period"])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--against", required=True, help="command with {eta}, {periods} and {tolerance}")
    parser.add_argument("--periods", type=int, default=50_000)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--tolerance", type=float, default=1e-12)
    parser.add_argument("--tangents", type=int, default=2)
    given = parser.parse_args()
    for eta in (0.448, 0.63):
        pairs = []
        for _ in range(given.rounds):
            own = own_time(eta, given.periods, given.tolerance, given.tangents)
            other = other_time(given.against, eta=eta, periods=given.periods, tolerance=given.tolerance)
            pairs.append((own, other, own / other))
        own, other, ratio = (median(column) for column in zip(*pairs, strict=True))
        low, high = min(p[2] for p in pairs), max(p[2] for p in pairs)
        print(f"eta {eta}: {own:.2f} us a period, other {other:.2f}, ratio {ratio:.2f} ({low:.2f} to {high:.2f})")


if __name__ == "__main__":
    main()
