"""From an equation to its number: what a user waits for, in units of the imports that nobody escapes.

    python3 studies/run.py start [PART ...] [--masses 1 4 16 64 128] [--repeats 3] [--heyoka PYTHON] [--keep]

A chain of Duffing masses that hits a stop, which no cache has seen, in processes of their own. Times are processor
times, the least of the repeats, so that other work on the machine counts less. The processes do without dask, as a
plain installation does: where it is there, xarray imports it. Each part is a table, ``PART.md``, in
``studies/start/out/``; ``--keep`` writes beside this script, too.

    start      a first spectrum of 20 periods and a first diagram of 8 points, each less the same run once more, in
               units of ``import numba, sympy, xarray`` in the same process; a second object of the same equations.
               The engine's own code is cached beside its modules: first processes see to that.
    compile    the functions of the chain, from its equations to machine code, beside heyoka's compact mode for the same
               chain with its variational equations; ``PYTHON`` is an interpreter that can import heyoka
               (``pip install heyoka``)
    first      the first number and the first picture of a process whose caches are warm: a spectrum of a system of the
               library in units of ``import numpy, xarray``, its picture and that of a diagram in units of what
               matplotlib takes for a line; medians of rounds in turn, whole processes
    cost       what a step costs, from 2 to 256 states: its time over the operations of a series, and that of a tangent
               over the entries of the Jacobian
"""

import argparse
import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path
from statistics import median

HERE = Path(__file__).resolve().parent

CHAIN = """
import json, sys, time

sys.modules["dask"] = None
began = time.process_time()
import numba, sympy, xarray
imported = time.process_time()
import chaosdrill as cd
import numpy as np

masses, exponents = (int(argument) for argument in sys.argv[1:3])
t = sympy.Symbol("t", real=True)
x, v = (sympy.symbols(f"{letter}0:{masses}", real=True) for letter in "xv")
k, c, w, f, r = sympy.symbols("k c w f r", real=True)


def chain(load):
    rates = {}
    for i in range(masses):
        rates[x[i]] = v[i]
        push = -c * v[i] - x[i] ** 3 - k * (x[i] - (x[i - 1] if i else 0))
        rates[v[i]] = push + (k * (x[i + 1] - x[i]) if i < masses - 1 else f * sympy.cos(w * t))
    stop = cd.Transition("hit", "free", "free", guard=x[-1] - 1, direction=+1, reset={v[-1]: -r * v[-1]})
    numbers = {"k": 1.0, "c": 0.1, "w": 1.2, "f": load, "r": 0.7}
    return cd.HybridSystem(name="chain", states=(*x, *v), time=t, parameters=numbers, modes={"free": rates},
                           transitions=[stop], period=2 * sympy.pi / w)
"""

SPECTRUM = (
    CHAIN
    + """
def spectrum(load):
    start = time.process_time()
    cd.lyapunov_spectrum(chain(load), periods=20, transient=0, exponents=exponents)
    return time.process_time() - start


first, second, again = (spectrum(load) for load in (1.5, 1.6, 1.5))
unit = imported - began
print(json.dumps({"spectrum": (first - again) / unit, "second": max(0.0, second - again), "run": again}))
"""
)

DIAGRAM = (
    CHAIN
    + """
def diagram():
    start = time.process_time()
    values = {"f": np.linspace(1.5, 2.0, 8)}
    more = {"exponents": exponents, "max_extension": 0, "workers": 1}
    cd.bifurcation_diagram(chain(1.5), values, transient=5, periods=10, **more)
    return time.process_time() - start


print(json.dumps({"diagram": (diagram() - diagram()) / (imported - began)}))
"""
)

COMPILATION = (
    CHAIN
    + """
from chaosdrill.codegen import kernels_of

system = chain(1.5)
start = time.process_time()
kernels_of(system)
print(json.dumps({"ours": time.process_time() - start}))
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
mode = write(system.placed).modes[0].mode
nodes = [mode.tape.nodes[i] for i in mode.in_jet | mode.in_jacobian]
operations = sum(max(1, len(node.args)) for node in nodes)
found = {"operations": operations, "edges": len(mode.linear) + len(mode.products)}
for tangents in (0, exponents):
    frame = examine(system).tangents(tangents)[0] if tangents else None
    run = Run(system, float(2 * np.pi / 1.2), Numerics("taylor", 1e-12, None, None, 50), tangents=frame)
    run.advance(2)
    times = []
    for _ in range(5):
        steps, start = int(run.standing["steps"]), time.process_time()
        run.advance(2 + 2000 // masses)
        times.append((time.process_time() - start) / (int(run.standing["steps"]) - steps))
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
start = time.process_time()
system = hy.var_ode_sys(rates, hy.var_args.vars, order=1)
hy.taylor_adaptive(system, state=[0.1] * (2 * masses), pars=[1.0, 0.1, 1.2, 1.5], tol=1e-12, compact_mode=True)
print(time.process_time() - start)
"""

READY = "import chaosdrill as cd, numpy as np; "
RUN = READY + "ds = cd.lyapunov_spectrum(cd.build({!r}), {}, transient=20); "
SWEPT = READY + "ds = cd.bifurcation_diagram(cd.build('duffing'), {'delta': np.linspace(0.2, 0.3, 32)}, transient=50, "
SWEPT += "periods=64, max_extension=0, workers=1); "
SAVED = "import matplotlib; matplotlib.use('Agg'); "
LINE = SAVED + "import matplotlib.pyplot as plt; plt.plot([1, 2, 3]); plt.savefig('line.png')"

PROCESSES = {
    "numpy, xarray": "import numpy, xarray",
    "spectrum of lorenz": RUN.format("lorenz", "duration=200"),
    "spectrum of impact-oscillator": RUN.format("impact-oscillator", "periods=100"),
    "spectrum of percussive-drill": RUN.format("percussive-drill", "periods=100"),
    "diagram of duffing": SWEPT,
    "matplotlib": LINE,
    "spectrum, picture": SAVED + RUN.format("lorenz", "duration=200") + "cd.plot(ds); "
    "import matplotlib.pyplot as plt; plt.savefig('spectrum.png')",
    "trajectory, picture": SAVED + READY + "ds = cd.trajectory(cd.build('lorenz'), duration=10); cd.plot(ds); "
    "import matplotlib.pyplot as plt; plt.savefig('trajectory.png')",
    "diagram, picture": SAVED + SWEPT + "cd.plot(ds); import matplotlib.pyplot as plt; plt.savefig('diagram.png')",
}
"""What a process does, by its name."""

PICTURES = ("spectrum, picture", "trajectory, picture", "diagram, picture")
"""Processes that compute and draw."""

ROUNDS = 7

LONGEST_S = 300
"""Seconds that one compilation of heyoka's may take."""


def measure(script, masses):
    """One process that finds no system in its cache; its figures by name."""
    command = [sys.executable, "-c", script, str(masses), str(min(8, 2 * masses))]
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "CHAOSDRILL_CACHE_DIR": folder}
        done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


def least(script, masses, repeats):
    """The least of each figure."""
    runs = [measure(script, masses) for _ in range(repeats)]
    return {name: min(run[name] for run in runs) for name in runs[0]}


def start_rows(given):
    """What a user waits for."""
    yield "masses (states)", "first spectrum, imports", "first diagram, imports", "a second object, ms", "the run, s"
    for script in (SPECTRUM, DIAGRAM):
        measure(script, 1)
    for masses in given.masses:
        found = least(SPECTRUM, masses, given.repeats) | least(DIAGRAM, masses, given.repeats)
        yield (
            f"{masses} ({2 * masses})",
            f"{found['spectrum']:.1f}",
            f"{found['diagram']:.1f}",
            f"{1e3 * found['second']:.0f}",
            f"{found['run']:.2f}",
        )


def compile_rows(given):
    """What compilation costs."""
    yield "masses (states)", "compilation, s", "heyoka's, s"
    for masses in given.masses:
        own = least(COMPILATION, masses, given.repeats)["ours"]
        others = heyoka(given.heyoka, masses, given.repeats) if given.heyoka else ""
        yield f"{masses} ({2 * masses})", f"{own:.2f}", others


def heyoka(interpreter, masses, repeats):
    """Seconds that heyoka takes for the same chain, or why it has no time."""
    command, found = [interpreter, "-c", HEYOKA, str(masses)], []
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as folder:
            environment = {**os.environ, "XDG_CACHE_HOME": folder}
            try:
                done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=LONGEST_S)
            except subprocess.TimeoutExpired:
                return f"over {LONGEST_S}"
        if done.returncode:
            return done.stderr.splitlines()[-1]
        found.append(float(done.stdout))
    return f"{min(found):.2f}"


def processor_time(script, folder):
    """Seconds of processor time of one process, its start and its end included."""
    # modules are compiled beforehand, as `pip install` leaves them
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-c", script]
    subprocess.run(command, cwd=folder, env=environment, check=True, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def first_rows(given):
    """What the first number and the first picture of a process cost."""
    yield "process", "processor time, s", "in units of", "units"
    with tempfile.TemporaryDirectory() as folder:
        for script in PROCESSES.values():
            processor_time(script, folder)
        rounds = [{name: processor_time(s, folder) for name, s in PROCESSES.items()} for _ in range(ROUNDS)]
    took = {name: median(one[name] for one in rounds) for name in PROCESSES}
    for name, seconds in took.items():
        unit = "matplotlib" if name in PICTURES else "numpy, xarray"
        yield name, f"{seconds:.2f}", unit, f"{seconds / took[unit]:.2f}"


def cost_rows(given):
    """What a step costs."""
    yield "states", "operations", "entries", "step, µs", "by operation, ns", "a tangent, µs", "by entry, ns"
    for masses in (1, 2, 4, 8, 16, 32, 64, 128):
        found = least(COST, masses, given.repeats)
        most = min(8, 2 * masses)
        plain, operations, entries = found["with 0"], found["operations"], found["edges"]
        each = (found[f"with {most}"] - plain) / most
        yield (
            2 * masses,
            operations,
            entries,
            f"{1e6 * plain:.1f}",
            f"{1e9 * plain / operations:.0f}",
            f"{1e6 * each:.2f}",
            f"{1e9 * each / entries:.0f}",
        )


PARTS = {"start": start_rows, "compile": compile_rows, "first": first_rows, "cost": cost_rows}


def table(rows):
    """Markdown, shown line by line as it comes."""
    lines = []
    for row in rows:
        lines.append("| " + " | ".join(map(str, row)) + " |")
        if len(lines) == 1:
            lines.append("| --- " * len(row) + "|")
        print(lines[-1] if len(lines) > 2 else "\n".join(lines), flush=True)
    return "\n".join(lines)


def machine():
    """A line that names what was measured on."""
    versions = ", ".join(f"{name} {version(name)}" for name in ("chaosdrill", "numba", "sympy", "xarray"))
    return f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}, {versions}."


def main():
    """Print and keep the tables that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", choices=[*PARTS, []], metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--masses", type=int, nargs="+", default=[1, 4, 16, 64, 128])
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--heyoka", metavar="PYTHON", help="an interpreter that can import heyoka")
    parser.add_argument("--keep", action="store_true", help="write the tables beside this script, too")
    given = parser.parse_args()
    (HERE / "out").mkdir(exist_ok=True)
    for part in given.parts or PARTS:
        text = f"{table(PARTS[part](given))}\n\n{machine()}\n"
        print()
        for place in (HERE / "out", *([HERE] if given.keep else [])):
            (place / f"{part}.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
