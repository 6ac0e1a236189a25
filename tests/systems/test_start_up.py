"""Naming systems costs nothing: no symbolic or compiled library is loaded before one is built."""

import subprocess
import sys

PROBE = """
import sys
from chaosdrill import systems
for name in systems.REGISTRY:
    systems.parameters(name), systems.states(name)
heavy = {"sympy", "numba", "numpy", "xarray", "scipy"} & set(sys.modules)
sys.exit(", ".join(sorted(heavy)) or 0)
"""


def test_registry_and_tables_load_nothing_heavy():
    run = subprocess.run([sys.executable, "-c", PROBE], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
