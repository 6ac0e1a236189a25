"""Short scenes of the impact oscillator, on a cycle of period 2: an analysis of every kind, by name."""

HEAD = """\
title = "Small"
[system]
model = "impact-oscillator"
[system.parameters]
omega = 3.3
"""

_TABLES = """\
[analysis.motion]
kind = "trajectory"
periods = 3
samples = 10
[analysis.section]
kind = "poincare-section"
transient = 100
periods = 8
[analysis.spectrum]
kind = "lyapunov-spectrum"
transient = 50
periods = 128
blocks = 16
[analysis.test]
kind = "zero-one-test"
transient = 50
periods = 64
[analysis.regular]
kind = "regularity"
transient = 50
periods = 64
plane = ["v", "x"]
[analysis.dimensions]
kind = "dimensions"
transient = 50
periods = 64
orders = [2]
[analysis.windows]
kind = "finite-time-exponents"
transient = 50
periods = 64
windows = [1, 8]
bins = 4
[analysis.vectors]
kind = "covariant-vectors"
transient = 50
periods = 16
interval = 0.5
forward = 20
backward = 20
bins = 4
[analysis.transients]
kind = "transient-chaos"
periods = 20
random = { count = 5, seed = 1, x = [-0.3, 0.2] }
until = "impact"
[analysis.diagram]
kind = "bifurcation-diagram"
sweep.omega = { start = 3.3, stop = 3.4, num = 4 }
transient = 50
periods = 32
max_period = 8
[analysis.chart]
kind = "parameter-chart"
sweep.omega = { start = 3.3, stop = 3.4, num = 3 }
sweep.e = { start = 0.7, stop = 0.8, num = 2 }
transient = 50
periods = 32
max_period = 8
[analysis.basins]
kind = "basins"
grid.x = { start = -0.3, stop = 0.2, num = 3 }
grid.v = { start = -0.5, stop = 0.5, num = 3 }
transient = 50
periods = 32
max_period = 8
[analysis.attractors]
kind = "attractors"
sweep.omega = { start = 3.3, stop = 3.4, num = 3 }
random = { count = 6, seed = 1, x = [-0.3, 0.2], v = [-0.5, 0.5] }
transient = 50
periods = 32
max_period = 8
[analysis.measures]
kind = "basin-measures"
grid.x = { start = -0.3, stop = 0.2, num = 8 }
grid.v = { start = -0.5, stop = 0.5, num = 8 }
box = 2
transient = 50
periods = 32
max_period = 8
[analysis.edges]
kind = "edge-states"
random = { count = 4, seed = 1, x = [-0.3, 0.2] }
transient = 50
periods = 32
max_period = 8
rounds = 3
[analysis.orbit]
kind = "periodic-orbit"
start = "search"
max_period = 1
[analysis.branch]
kind = "continuation"
sweep.omega = { start = 3.3, stop = 3.4 }
doublings = 0
transient = 300
[analysis.curves]
kind = "manifolds"
period = 2
orbit = { x = -0.5823, v = -0.4341 }
region.x = [-1.0, 0.3]
region.v = [-1.0, 1.0]
length = 0.3
spacing = 0.05
[analysis.precision]
kind = "work-precision"
methods = ["taylor", "dop853"]
tolerances = [1e-6, 1e-10]
periods = 20
repeats = 2
"""

ANALYSES = {one.partition("]")[0]: f"[analysis.{one}" for one in _TABLES.split("[analysis.")[1:]}


def small_scene(*names):
    """The text of a scene with some of the analyses; all of them by default."""
    return HEAD + "".join(ANALYSES[name] for name in names or ANALYSES)
