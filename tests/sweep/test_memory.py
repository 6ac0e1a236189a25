"""A chart of a million points is computed and written in bounded memory."""

import subprocess
import sys

CHART = """
import resource, sys
from dataclasses import dataclass
import netCDF4, numpy as np, xarray as xr
from chaosdrill.archive import save
from chaosdrill.sweep import execute

SIDE = 1000
COLUMNS = {"period": ("i2", ()), "outcome": ("i1", ())}
COLUMNS |= {"lyapunov_exponent": ("f8", (3,)), "lyapunov_error": ("f8", (3,))}
COLUMNS |= {f"rate {k}": ("f8", ()) for k in range(5)}

def peak():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024

@dataclass(frozen=True)
class Chart:
    units: int = SIDE * SIDE
    points_per_unit: int = 1
    total: int = SIDE * SIDE

    def columns(self):
        return COLUMNS

    def run(self, first, count):
        random = np.random.default_rng(first)
        return {name: (100 * random.random((count, *shape))).astype(dtype) for name, (dtype, shape) in COLUMNS.items()}

    def counts(self, arrays):
        return {"done": len(arrays["outcome"])}

    def fingerprint(self):
        return {}

KIND = {"kind": "parameter-chart"}
# the libraries load parts of themselves with the first file
save(xr.Dataset({"x": ("a", np.zeros(1000))}, attrs=KIND), sys.argv[2])
before = peak()
found = execute(Chart(), store=sys.argv[1])
computed = peak()
shape = {name: ("a", "b", *("c" for _ in array.shape[1:])) for name, array in found.items()}
chart = {n: (shape[n], a.reshape(SIDE, SIDE, *a.shape[1:])) for n, a in found.items()}
save(xr.Dataset(chart, attrs=KIND), sys.argv[2])
print(computed - before, peak() - before)
"""


def test_memory_of_a_million_points(tmp_path):
    command = [sys.executable, "-c", CHART, str(tmp_path / "parts"), str(tmp_path / "out.nc")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    computing, writing = map(float, done.stdout.split())
    # in MB; the results are 91 MB, of which none need be in memory before they are written
    assert computing < 40
    assert writing < 200
