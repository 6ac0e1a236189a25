"""From an equation to its number: what a user waits for, in units of the imports that nobody escapes.

    python3 studies/run.py start [--masses 1 4 16 64 128] [--repeats 3] [--heyoka PYTHON]

A chain of Duffing masses that hits a stop, of a size that no cache has seen, in processes of their own: the time to a
first spectrum of 20 periods less that of the same run once more, a first diagram in the same way, and a second object
of the same equations. The unit is ``import numba, sympy, xarray`` in the same process, so that a busy machine slows
both. The engine's own code is taken from the cache: a first process sees to that. ``PYTHON`` is an interpreter that can
from chaosdrill.codegen import kernels_of
import heyoka (``pip install heyoka``), whose compact mode compiles the same chain with its variational equations.

A second table shows what a step costs, from 2 to 256 states: its time over the operations of a series, and over these
times the tangents.
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
"""

FIRST = (
    CHAIN
    + """

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
alone = seconds(lambda load: kernels_of(chain(load)), 1.5)
first, second, again = (seconds(spectrum, load) for load in (1.5, 1.6, 1.5))
drawn, redrawn = seconds(diagram, 1.5), seconds(diagram, 1.5)
print(json.dumps({"unit": unit, "compile": alone, "spectrum": (alone + first - again) / unit,
                  "second": max(0.0, second - again), "run": again, "diagram": (drawn - redrawn) / unit}))
"""
)

COST = (
    CHAIN
    + """
from chaosdrill.codegen.kernels import write
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.engine.structure import examine

system = chain(1.5)
(mode,) = write(system.placed).modes
nodes = [mode.tape.nodes[i] for i in mode.in_jet | mode.in_jacobian]
operations = sum(max(1, len(node.args)) for node in nodes)
found = {"operations": operations, "edges": len(mode.linear) + len(mode.products)}
for tangents in (0, exponents):
    frame = examine(system).tangents(tangents)[0] if tangents else None
    run = Run(system, float(2 * np.pi / 1.2), Numerics("taylor", 1e-12, None, None, 50), tangents=frame)
    run.advance(2)
    times = []
    for _ in range(5):
        steps, start = int(run.standing["steps"]), time.perf_counter()
        run.advance(2)
        times.append((time.perf_counter() - start) / (int(run.standing["steps"]) - steps))
    found[f"with {tangents}"] = min(times)
print(json.dumps(found))
"""
)

HEYOKA = """
import sys, time
import heyoka as hy

masses = int(sys.argv[1])
x, v = ([hy.make_vars(f"{letter}{i}") for i in range(masses)] for letter in "xv")
k, c, w, f = (hy.par[i] for i in range(4))
rates = list(zip(x, v))
for i in range(masses):
    push = -c * v[i] - x[i] ** 3 - k * (x[i] - (x[i - 1] if i else 0.0))
    rates.append((v[i], push + (k * (x[i + 1] - x[i]) if i < masses - 1 else f * hy.cos(w * hy.time))))
start = time.perf_counter()
system = hy.var_ode_sys(rates, hy.var_args.vars, order=1)
hy.taylor_adaptive(system, state=[0.1] * (2 * masses), pars=[1.0, 0.1, 1.2, 1.5], tol=1e-12, compact_mode=True)
print(time.perf_counter() - start)
"""


LONGEST_S = 300
"""Seconds that one compilation of heyoka's may take."""


def measure(script, masses, exponents, salt, folder):
    """One process; its figures by name."""
    environment = {**os.environ, "CHAOSDRILL_CACHE_DIR": folder}
    command = [sys.executable, "-c", script, str(masses), str(exponents), str(salt)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


def start_table(given, folder):
    """What a user waits for."""
    print(
        "| masses (states) | first spectrum, imports | first diagram, imports | a second object, ms | the run, s |",
        end="",
    )
    print(" compilation, s | heyoka's, s |" if given.heyoka else " compilation, s |")
    print("|---" * (7 if given.heyoka else 6) + "|")
    measure(FIRST, 1, 2, 0, folder)
    for masses in given.masses:
        exponents = min(2 * masses, 8)
        runs = [measure(FIRST, masses, exponents, salt, folder) for salt in range(1, given.repeats + 1)]
        least = {name: min(run[name] for run in runs) for name in runs[0]}
        print(
            f"| {masses} ({2 * masses}) | {least['spectrum']:.1f} | {least['diagram']:.1f} | "
            f"{1e3 * least['second']:.0f} | {least['run']:.2f} | {least['compile']:.2f} |",
            f"{heyoka(given.heyoka, masses)} |" if given.heyoka else "",
            flush=True,
        )


def heyoka(interpreter, masses):
    """Seconds that heyoka takes for the same chain, or why there are none."""
    try:
        done = subprocess.run(
            [interpreter, "-c", HEYOKA, str(masses)], capture_output=True, text=True, timeout=LONGEST_S
        )
    except subprocess.TimeoutExpired:
        return f"over {LONGEST_S}"
    return f"{float(done.stdout):.2f}" if done.returncode == 0 else done.stderr.splitlines()[-1]


def cost_table(folder):
    """What a step costs."""
    print("\n| states | operations, entries | step, us | by operation, ns | each of 8 tangents, us | by entry, ns |")
    print("|---|---|---|---|---|---|")
    for masses in (1, 2, 4, 8, 16, 32, 64, 128):
        most = min(8, 2 * masses)
        found = measure(COST, masses, most, 0, folder)
        plain = found["with 0"]
        each = (found[f"with {most}"] - plain) / most
        print(
            f"| {2 * masses} | {found['operations']}, {found['edges']} | {1e6 * plain:.1f} | "
            f"{1e9 * plain / found['operations']:.0f} | {1e6 * each:.1f} | {1e9 * each / found['edges']:.0f} |",
            flush=True,
        )


def main():
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--masses", type=int, nargs="+", default=[1, 4, 16, 64, 128])
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--heyoka", metavar="PYTHON", help="an interpreter that can import heyoka")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        if given.repeats:
            start_table(given, folder)
        cost_table(folder)


if __name__ == "__main__":
    main()
