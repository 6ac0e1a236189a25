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
kinds = "chaosdrill.analysis.kinds."
loaded += [name for name in sys.modules if name.startswith(kinds) and name != kinds + "lyapunov_spectrum"]
sys.exit(f"loaded: {loaded}" if loaded else 0)
"""


def run(script):
    return subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)


def test_a_spectrum_loads_what_it_needs():
    done = run(SPECTRUM)
    assert done.returncode == 0, done.stderr


PICTURE = """
import sys
import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
before = set(sys.modules)
import chaosdrill as cd
diagram = {"transient": 1, "periods": 4, "max_extension": 0, "workers": 1}
cd.plot(cd.lyapunov_spectrum(cd.build("lorenz"), duration=2.0))
cd.plot(cd.trajectory(cd.build("lorenz").with_parameters(rho=30.0), duration=10.0))
cd.plot(cd.bifurcation_diagram(cd.build("duffing"), {"delta": [0.2, 0.25]}, **diagram))
plt.savefig("diagram.png")
unasked = {"dask", "scipy", "sympy", "numba", "netCDF4", "jinja2"}
loaded = sorted(unasked & ({name for name, module in sys.modules.items() if module is not None} - before))
sys.exit(f"loaded: {loaded}" if loaded else 0)
"""


def test_the_first_picture_loads_what_it_needs(tmp_path):
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", PICTURE], capture_output=True, text=True, cwd=tmp_path, check=False
        )
    assert done.returncode == 0, done.stderr
