"""Help comes at once, since nothing heavy is imported for it."""

import subprocess
import sys

import pytest

HEAVY = ("numba", "xarray", "matplotlib", "sympy", "netCDF4", "pydantic", "numpy", "dask", "scipy", "jinja2")

SHOW_IMPORTS = f"""
import sys
from chaosdrill.cli import main
code = main(sys.argv[1:])
print([name for name in {HEAVY!r} if name in sys.modules], file=sys.stderr)
sys.exit(code)
"""


def imported(*arguments):
    command = [sys.executable, "-c", SHOW_IMPORTS, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    return done.stderr.strip()


@pytest.mark.parametrize(
    "arguments",
    [
        "--help",
        "--version",
        "run --help",
        "verify --help",
        "plot --help",
        "report --help",
        "list systems",
        "list effects",
        "list analyses",
        "list methods",
    ],
)
def test_nothing_heavy_is_imported(arguments):
    assert imported(*arguments.split()) == "[]"


def test_check_imports_no_compiler_and_no_arrays(scene):
    assert imported("check", str(scene)) == "['sympy']"
