"""Nothing is loaded that is not needed: naming systems is free, and a spectrum takes what it computes with."""

import subprocess
import sys

import pytest

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
unasked = {"dask", "distributed", "scipy.linalg", "scipy.optimize", "scipy.fft", "matplotlib", "netCDF4", "jinja2"}
unasked |= {"chaosdrill.orbits", "chaosdrill.plots", "chaosdrill.archive", "chaosdrill.analysis.sections"}
loaded = sorted(unasked & {name for name, module in sys.modules.items() if module is not None})
sys.exit(f"loaded: {loaded}" if loaded else 0)
"""

CHUNKED = """
import chaosdrill as cd
found = cd.trajectory(cd.build("lorenz"), duration=2.0, samples=10)
import dask
import dask.array
import xarray as xr
chunked = found.chunk(time=5)
assert chunked.chunks["time"] == (5, 5, 1), chunked.chunks
assert isinstance(chunked["states"].data, dask.array.Array)
assert dask.is_dask_collection(chunked)
assert xr.Dataset({"a": ("t", dask.array.ones(6, chunks=3))}).chunks["t"] == (3, 3)
assert chunked.compute().identical(found)
"""


def run(script):
    return subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)


def test_a_spectrum_loads_what_it_needs():
    done = run(SPECTRUM)
    assert done.returncode == 0, done.stderr


def test_who_imports_dask_later_has_all_of_it():
    pytest.importorskip("dask.array")
    done = run(CHUNKED)
    assert done.returncode == 0, done.stderr
