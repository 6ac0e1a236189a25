"""What can be asked of a system: one class a kind of analysis, with the keywords of its function.

A keyword that the scene leaves out is not passed on, so that its default stands in one place: the function.
"""

from chaosdrill.scene.kinds.base import Analysis
from chaosdrill.scene.kinds.orbits import Continuation, PeriodicOrbit
from chaosdrill.scene.kinds.points import Basins, BifurcationDiagram, ParameterChart
from chaosdrill.scene.kinds.runs import LyapunovSpectrum, PoincareSection, Trajectory, WorkPrecision

__all__ = ["KINDS", "Analysis"]

KINDS: dict[str, type[Analysis]] = {
    "trajectory": Trajectory,
    "poincare-section": PoincareSection,
    "lyapunov-spectrum": LyapunovSpectrum,
    "bifurcation-diagram": BifurcationDiagram,
    "parameter-chart": ParameterChart,
    "basins": Basins,
    "periodic-orbit": PeriodicOrbit,
    "continuation": Continuation,
    "work-precision": WorkPrecision,
}
