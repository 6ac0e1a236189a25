"""From an equation to its number: what a user waits for, in units of the imports that nobody escapes.

    python3 studies/run.py start [--masses 1 4 16 64] [--repeats 3]

A chain of Duffing masses that hits a stop, of a size that no cache has seen, in processes of their own: the time to a
first spectrum of 20 periods less that of the same run once more, a first diagram in the same way, and a second object
of the same equations. The unit is ``import numba, sympy, xarray`` in the same process, so that a busy machine slows
both. The engine's own code is taken from the cache: a first process sees to that.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile

CHAIN = """
import json, sys, time

began = time.perf_counter()
import numba, sympy, xarray
imported = time.perf_counter()
import chaosdrill as cd
import numpy as np

masses, exponents, salt = (int(argument) for argument in sys.argv[1:4])
t = sympy.Symbol("t", real=True)
x, v = (sympy.symbols(f"{letter}0:{masses}", real=True) for letter in "xv")
k, c, w, f, r = sympy.symbols("k c w f r", real=True)


def chain(load):
    rates = {}
    for i in range(masses):
        rates[x[i]] = v[i]
        push = -c * v[i] - x[i] ** 3 - k * (x[i] - (x[i - 1] if i else 0))
        # no two processes have the same equations
        push += c * v[i] * x[i] if (salt >> (i % 16)) & 1 else 0
        rates[v[i]] = push + (k * (x[i + 1] - x[i]) if i < masses - 1 else f * sympy.cos(w * t))
    stop = cd.Transition("hit", "free", "free", guard=x[-1] - 1, direction=+1, reset={v[-1]: -r * v[-1]})
    numbers = {"k": 1.0, "c": 0.1, "w": 1.2, "f": load, "r": 0.7}
    return cd.HybridSystem(name=f"chain {salt}", states=(*x, *v), time=t, parameters=numbers, modes={"free": rates},
                           transitions=[stop], period=2 * sympy.pi / w)


def spectrum(load):
    system = chain(load)
    cd.lyapunov_spectrum(system, periods=20, transient=0, exponents=exponents)


def diagram(load):
    values = {"f": np.linspace(load, load + 0.5, 8)}
    cd.bifurcation_diagram(chain(load), values, transient=10, periods=10, workers=1)


def seconds(call, load):
    start = time.perf_counter()
    call(load)
    return time.perf_counter() - start


unit = imported - began
first, second, again = (seconds(spectrum, load) for load in (1.5, 1.6, 1.5))
drawn, redrawn = seconds(diagram, 1.5), seconds(diagram, 1.5)
print(json.dumps({"unit": unit, "spectrum": (first - again) / unit, "second": max(0.0, second - again),
                  "run": again, "diagram": (drawn - redrawn) / unit}))
"""


def measure(masses, exponents, salt, folder):
    """One process; its figures by name."""
    environment = {**os.environ, "CHAOSDRILL_CACHE_DIR": folder}
    command = [sys.executable, "-c", CHAIN, str(masses), str(exponents), str(salt)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--masses", type=int, nargs="+", default=[1, 4, 16, 64])
    parser.add_argument("--repeats", type=int, default=3)
    given = parser.parse_args()
    print("| masses (states) | first spectrum, imports | first diagram, imports | a second object, ms | the run, s |")
    print("|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        measure(1, 2, 0, folder)
        for masses in given.masses:
            exponents = min(2 * masses, 8)
            salts = range(1, given.repeats + 1)
            runs = [measure(masses, exponents, salt, folder) for salt in salts]
            least = {name: min(run[name] for run in runs) for name in runs[0]}
            print(
                f"| {masses} ({2 * masses}) | {least['spectrum']:.1f} | {least['diagram']:.1f} | "
                f"{1e3 * least['second']:.0f} | {least['run']:.2f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
