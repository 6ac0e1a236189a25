"""The core of the suite with the lowest and the newest versions of what the package computes with.

    python3 studies/run.py versions [PYTHON ...] [--only lowest|newest] [--part K/N]

The lowest versions, those that ``pyproject.toml`` names, are installed beside the oldest Python, the newest ones beside
the newest that is found; or both beside each interpreter that is given. Each set is an environment of its own in
``.venv-versions``, made once while ``pyproject.toml`` stays the same. Any warning is an error. The exit code is that of
the first set that fails.

Where a command may take only some minutes, the run divides: ``--only`` takes one set, and ``--part K/N`` the K-th of N
parts of the tests, ``--part 0/N`` none. The environments and the compiled engine stay for the next command.
"""

import argparse
import hashlib
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from shutil import which

ROOT = Path(__file__).resolve().parents[2]
HOME = ROOT / ".venv-versions"
OLDEST, NEWEST = (3, 11), (3, 20)

VARIED = ("numpy", "numba", "llvmlite", "xarray", "pandas", "scipy", "sympy")

CORE = (
    "tests/test_environments.py",
    "tests/model/test_copies.py",
    "tests/model/test_text.py",
    "tests/dataset/test_words.py",
    "tests/engine/test_front_end.py",
    "tests/engine/test_without_inner_parts.py",
    "tests/engine/test_radau.py",
    "tests/known_answers/test_flows.py",
    "tests/known_answers/test_hits_and_sticking.py",
    "tests/analysis/test_called_wrongly.py",
    "tests/analysis/test_trajectory.py",
    "tests/analysis/test_diagram.py",
    "tests/archive/test_described.py",
)
"""What meets every part of these libraries that the package uses: code, numbers, tables, files, pictures."""

_SHOW = "from importlib.metadata import version; import sys; print(*(f'{n} {version(n)}' for n in sys.argv[1:]))"


def lowest(dependencies):
    """Requirements that pin what is varied to the lowest version allowed."""
    bounds = (re.match(r"([\w-]+)>=([\d.]+)", one) for one in dependencies)
    return [f"{found[1]}=={found[2]}.*" for found in bounds if found and found[1] in VARIED]


def interpreters():
    """The oldest and the newest Python that run here."""
    found = []
    for minor in range(OLDEST[1], NEWEST[1]):
        name = f"python3.{minor}"
        places = [which(name), *sorted(map(str, Path.home().glob(f".pyenv/versions/3.{minor}.*/bin/python")))]
        works = [place for place in filter(None, places) if _runs(place)]
        found += works[:1]
    return found[:1] + found[-1:] if found else [sys.executable] * 2


def _runs(interpreter):
    """Whether it is a Python, and no name of one that is not installed."""
    return subprocess.run([interpreter, "-c", "import venv"], capture_output=True, check=False).returncode == 0


def environment(name, interpreter, requirements):
    """The Python of an environment that holds the package and these requirements; None if it cannot be made."""
    folder = HOME / name
    python = folder / "bin/python"
    wanted = hashlib.sha256((ROOT / "pyproject.toml").read_bytes() + repr((interpreter, requirements)).encode())
    stamp = folder / ".installed"
    if stamp.is_file() and stamp.read_text() == wanted.hexdigest():
        return python
    print(f"{name}: installing into {folder}", flush=True)
    pip = [str(python), "-m", "pip", "install", "--disable-pip-version-check", "--quiet"]
    tests = ["pytest>=8.2", "hypothesis>=6.100"]
    if subprocess.call([interpreter, "-m", "venv", "--clear", str(folder)]):
        return None
    if subprocess.call([*pip, "--editable", str(ROOT), *tests, *requirements]):
        return None
    stamp.write_text(wanted.hexdigest())
    return python


def part(text):
    """The test files of the K-th of N parts, for the text ``K/N``; no files for K = 0."""
    found = re.fullmatch(r"(\d{1,3})/(\d{1,3})", text)
    k, n = map(int, found.groups()) if found else (1, 0)
    if not k <= n <= len(CORE) or n == 0:
        raise argparse.ArgumentTypeError(f"expected K/N with 0 <= K <= N and 1 <= N <= {len(CORE)}, received {text!r}")
    return CORE[k - 1 :: n] if k else ()


def main(arguments):
    """Run the core of the suite with every set of versions."""
    parser = argparse.ArgumentParser(prog="studies/run.py versions", description=__doc__.partition("\n")[0])
    parser.add_argument("interpreters", nargs="*", metavar="PYTHON", help="the oldest and the newest found, if none")
    parser.add_argument("--only", choices=("lowest", "newest"), help="this set of versions alone")
    parser.add_argument("--part", type=part, default=CORE, metavar="K/N", help="the K-th of N parts of the tests")
    given = parser.parse_args(arguments)
    with (ROOT / "pyproject.toml").open("rb") as file:
        pinned = lowest(tomllib.load(file)["project"]["dependencies"])
    if given.interpreters:
        sets = [(f"{kind}-{i}", one, r) for i, one in enumerate(given.interpreters) for kind, r in _both(pinned)]
    else:
        sets = [(kind, one, r) for (kind, r), one in zip(_both(pinned), interpreters(), strict=True)]
    for name, interpreter, requirements in sets:
        if given.only and name.partition("-")[0] != given.only:
            continue
        python = environment(name, interpreter, requirements)
        if python is None:
            print(f"{name}: the environment cannot be made; the message is above")
            return 1
        caches = {"CHAOSDRILL_CACHE_DIR": str(HOME / name / "cache"), "MPLBACKEND": "Agg"}
        subprocess.call([str(python), "--version"])
        subprocess.call([str(python), "-c", _SHOW, *VARIED])
        command = [str(python), "-m", "pytest", "-q", "-p", "no:cacheprovider", *given.part]
        if not given.part:  # pytest without files would take the whole suite
            command = [str(python), "-m", "chaosdrill", "warm"]
        if code := subprocess.call(command, cwd=ROOT, env={**os.environ, **caches}):
            print(f"{name}: the core of the suite fails")
            return code
    return 0


def _both(pinned):
    return ("lowest", pinned), ("newest", [])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
