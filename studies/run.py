"""Run a study, or the tests, on a machine that has only Python 3.11 or newer.

    python3 studies/run.py paper          the paper's figures, table of regimes and bifurcation diagram
    python3 studies/run.py silent_error   the error of the exponents when tangents ignore events
    python3 studies/run.py hard_cases     fourteen cases on which hybrid-system codes fail
    python3 studies/run.py accuracy       accuracy versus run time, with other programs and the method of the paper
    python3 studies/run.py throughput     speed of charts: other programs, two workers, number of points, memory
    python3 studies/run.py speed          commits of the package in turn, and beside programs for the drill alone
    python3 studies/run.py rivals         exponents, vectors and dimensions of smooth systems beside programs of PyPI
    python3 studies/run.py charts         charts of the drill, slow and fast drilling, basins; does chaos drill faster?
    python3 studies/run.py orbits         branches, cascades and grazing of the drill, validated by simulations
    python3 studies/run.py procedure      the best rate of penetration along stable orbits with a bound on the force
    python3 studies/run.py chaos          how chaotic the drill is: angles, windows, transients, shares, one per cent
    python3 studies/run.py words          how often a motion is misclassified: 6,870 records whose nature is known
    python3 studies/run.py archives       runs every scene of the studies and verifies its archive
    python3 studies/run.py start          the time to the first spectrum and diagram of a new system
    python3 studies/run.py fuzz           corrupted scenes, archives and parts; runs that are killed and resumed
    python3 studies/run.py hostile        archives built to do harm to those who open them
    python3 studies/run.py docs           builds the documentation into docs/_build/html and runs every example in it
    python3 studies/run.py tests          the test suite
    python3 studies/run.py coverage       the test suite with coverage, which takes a third longer
    python3 studies/run.py versions       its core, with the lowest and the newest of numpy, numba, xarray, ...
    python3 studies/run.py lines          coverage of the engine's lines by short runs in plain Python, uncompiled

The first run creates ``.venv`` next to ``pyproject.toml`` and installs the package into it. Further arguments are
passed on to the study (or to pytest).
"""

import hashlib
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ENVIRONMENT = ROOT / ".venv"
PYTHON = ENVIRONMENT / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
OLDEST = (3, 11)

# coverage sees no compiled lines; what the engine does to be compiled is not run here
LINES = (
    *("-m", "pytest", "tests/engine/test_uncompiled.py"),
    *("--cov", "--cov-config", "tests/lines.coveragerc", "--cov-report", "term-missing", "--cov-fail-under", "90"),
)

SUITE = ("-m", "pytest", "-n", "2", "--dist", "worksteal")

# job -> (extra that pip installs for it, arguments of the environment's Python)
JOBS = {
    "paper": ("", ["studies/paper/make.py"]),
    "silent_error": ("", ["studies/silent_error/make.py"]),
    "hard_cases": ("", ["studies/hard_cases/make.py"]),
    "accuracy": ("", ["studies/accuracy/make.py"]),
    "throughput": ("", ["studies/throughput/make.py"]),
    "speed": ("", ["studies/speed/commits.py"]),
    "rivals": ("", ["studies/rivals/make.py"]),
    "charts": ("", ["studies/charts/make.py"]),
    "orbits": ("", ["studies/orbits/make.py"]),
    "procedure": ("", ["studies/procedure/make.py"]),
    "chaos": ("", ["studies/chaos/make.py"]),
    "words": ("", ["studies/words/make.py"]),
    "archives": ("", ["studies/archives/make.py"]),
    "start": ("", ["studies/start/make.py"]),
    "fuzz": ("", ["studies/fuzz/make.py"]),
    "hostile": ("", ["studies/fuzz/hostile.py"]),
    "docs": ("[docs]", ["-m", "sphinx", "-W", "--keep-going", "-b", "html", "docs", "docs/_build/html"]),
    "tests": ("[test]", [*SUITE]),
    "coverage": ("[test]", [*SUITE, "--cov", "--cov-report", "term", "--cov-fail-under", "90"]),
    "versions": ("", ["studies/versions/make.py"]),
    "lines": ("[test]", [*LINES]),
}


def say(text):
    print(f"[studies/run.py] {text}", file=sys.stderr, flush=True)


def main(arguments):
    """Install what the job needs, run it, and return its exit code."""
    if sys.version_info < OLDEST:
        say(f"Python {OLDEST[0]}.{OLDEST[1]} or newer is needed; this is {sys.version.split()[0]}.")
        return 2
    if not arguments or arguments[0] not in JOBS:
        print(__doc__.strip(), file=sys.stderr)
        return 0 if arguments in (["-h"], ["--help"]) else 2
    extra, command = JOBS[arguments[0]]
    code = install(extra)
    if code:
        return code
    environment = job_environment()
    if arguments[0] == "lines":
        environment["NUMBA_DISABLE_JIT"] = "1"
    return subprocess.call([str(PYTHON), *command, *arguments[1:]], cwd=ROOT, env=environment)


def install(extra):
    """Make the environment and install the package; nothing is done while ``pyproject.toml`` stays the same."""
    wanted = hashlib.sha256((ROOT / "pyproject.toml").read_bytes()).hexdigest()
    stamp = ENVIRONMENT / f".installed{extra}"
    if stamp.is_file() and stamp.read_text() == wanted:
        return 0
    started = time.monotonic()
    if not PYTHON.is_file():
        say(f"creating {ENVIRONMENT}")
        if subprocess.call([sys.executable, "-m", "venv", str(ENVIRONMENT)]):
            say("the venv module could not create the environment; on Debian and Ubuntu, install python3-venv.")
            return 1
    say("installing chaosdrill and its dependencies (once, about a minute)")
    pip = [str(PYTHON), "-m", "pip", "install", "--disable-pip-version-check", "--quiet"]
    if subprocess.call([*pip, "--editable", f"{ROOT}{extra}"]):
        say("pip failed; its message is above.")
        return 1
    stamp.write_text(wanted)
    say(f"installed in {time.monotonic() - started:.0f} s")
    return 0


def job_environment():
    """Return the job's environment variables; caches move beside the environment where the home cannot be written."""
    environment = dict(os.environ, PYTHONUNBUFFERED="1")
    try:
        with tempfile.TemporaryFile(dir=Path.home()):
            pass
    except (OSError, RuntimeError):
        caches = ENVIRONMENT / "cache"
        environment.setdefault("XDG_CACHE_HOME", str(caches))
        environment.setdefault("MPLCONFIGDIR", str(caches / "matplotlib"))
    return environment


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)
