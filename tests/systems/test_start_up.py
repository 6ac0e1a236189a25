"""Nothing is loaded that is not needed: naming systems is free, and a spectrum takes what it computes with."""

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


SPECTRUM = """
import sys
import chaosdrill as cd
found = cd.lyapunov_spectrum(cd.build("lorenz"), duration=2.0)
unasked = {"dask", "scipy.fft", "scipy.special", "scipy.optimize", "scipy.linalg", "matplotlib", "netCDF4"}
unasked |= {"chaosdrill.orbits", "chaosdrill.plots", "chaosdrill.archive", "chaosdrill.analysis.sections"}
loaded = sorted(unasked & {name for name, module in sys.modules.items() if module is not None})
sys.exit(f"loaded: {loaded}" if loaded else 0)
"""


def run(script):
    return subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)


def test_a_spectrum_loads_what_it_needs():
    done = run(SPECTRUM)
    assert done.returncode == 0, done.stderr
