"""The work of other programs, in an environment of its own: reads a line of JSON a task, prints one a result.

A task is ``{"program": NAME, "work": NAME, "setting": NUMBER}``; a result ``{"seconds": NUMBER, "values": [...]}``, of
a run that is warm: each work is done once before it is timed.
"""

import json
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

LORENZ = [10.0, 28.0, 8.0 / 3.0]
START = [1.0, 1.0, 20.0]
HENON = [1.4, 0.3]


def lorenz_by_heyoka(until: float) -> Callable[[float], Any]:
    """States at a time, by tolerance."""
    import heyoka as hy

    x, y, z = hy.make_vars("x", "y", "z")
    sigma, rho, beta = LORENZ
    rates = [(x, sigma * (y - x)), (y, x * (rho - z) - y), (z, x * y - beta * z)]
    made: dict[float, Any] = {}

    def run(tolerance: float) -> Any:
        if tolerance not in made:
            made[tolerance] = hy.taylor_adaptive(rates, START, tol=tolerance)
        one = made[tolerance]
        one.time, one.state[:] = 0.0, START
        one.propagate_until(until)
        return one.state.tolist()

    return run


def lorenz_by_pynamicalsys(until: float, work: str) -> Callable[[float], Any]:
    """The state at a time, or the exponents, by fixed steps of Runge and Kutta's method."""
    from pynamicalsys import ContinuousDynamicalSystem

    one = ContinuousDynamicalSystem(model="lorenz system")

    def run(step: float) -> Any:
        one.integrator("rk4", time_step=step)
        if work == "state":
            return one.trajectory(START, until, parameters=LORENZ)[-1, 1:].tolist()
        return one.lyapunov(START, until, parameters=LORENZ, transient_time=50.0).tolist()

    return run


def henon_by_pynamicalsys(count: int, work: str) -> Callable[[float], Any]:
    """Exponents of Henon's map, or the smallest angle between its covariant vectors."""
    from pynamicalsys import DiscreteDynamicalSystem

    one = DiscreteDynamicalSystem(model="henon map")
    given = {"parameters": HENON, "transient_time": 500}

    def run(_: float) -> Any:
        if work == "spectrum":
            return one.lyapunov([0.1, 0.05], count, **given).tolist()
        vectors, _ = one.CLV([0.1, 0.05], count, **given, warmup_time=500, tail_time=500)
        across = np.abs((vectors[:, :, 0] * vectors[:, :, 1]).sum(axis=1))
        return [float(np.arccos(min(1.0, across.max())))]

    return run


def dimension_by_nolds(count: int) -> Callable[[float], Any]:
    """The correlation dimension of points of Henon's map, from one coordinate and its predecessor."""
    from importlib import resources, util
    from pathlib import Path

    if sys.version_info < (3, 12):
        # nolds 0.6.3 asks for the files beside a module, which older Pythons know of packages alone
        found = util.find_spec("nolds")
        folder = Path(str(found.origin)).parent if found else Path()
        resources.files = lambda _: folder  # type: ignore[assignment]
    import nolds

    def run(_: float) -> Any:
        x, y = 0.1, 0.05
        path = []
        for _ in range(500 + count):
            x, y = 1.0 - HENON[0] * x * x + y, HENON[1] * x
            path.append(x)
        return [float(nolds.corr_dim(np.array(path[500:]), 2, fit="poly"))]

    return run


def neighbours_by_scipy(count: int, work: str) -> Callable[[float], Any]:
    """A k-d tree of points of Henon's map, or by it their correlation dimension, from the pairs of 8,192 with all."""
    from scipy.spatial import cKDTree

    points = np.empty((500 + count, 2))
    x, y = 0.1, 0.05
    for k in range(len(points)):
        x, y = 1.0 - HENON[0] * x * x + y, HENON[1] * x
        points[k] = x, y
    points = points[500:] / points[500:].std(axis=0)
    some, distances = points[:: -(-count // 8192)], 2.0 ** np.arange(-12.0, -2.0, 0.5)

    def run(_: float) -> Any:
        tree = cKDTree(points)
        if work == "tree":
            return points[-1].tolist()
        # a point is no neighbour of its own
        counts = cKDTree(some).count_neighbors(tree, distances, p=np.inf) - len(some)
        return [float(np.polyfit(np.log(distances), np.log(counts), 1)[0])]

    return run


WORKS: dict[tuple[str, str], Callable[[float], Callable[[float], Any]]] = {
    ("heyoka", "state"): lorenz_by_heyoka,
    ("pynamicalsys", "state"): lambda until: lorenz_by_pynamicalsys(until, "state"),
    ("pynamicalsys", "spectrum"): lambda until: lorenz_by_pynamicalsys(until, "spectrum"),
    ("pynamicalsys", "map"): lambda count: henon_by_pynamicalsys(int(count), "spectrum"),
    ("pynamicalsys", "vectors"): lambda count: henon_by_pynamicalsys(int(count), "vectors"),
    ("nolds", "dimension"): lambda count: dimension_by_nolds(int(count)),
    ("scipy", "tree"): lambda count: neighbours_by_scipy(int(count), "tree"),
    ("scipy", "dimension"): lambda count: neighbours_by_scipy(int(count), "dimension"),
}


def main() -> None:
    """Answer tasks until there are no more."""
    made: dict[tuple[str, str, float], Callable[[float], Any]] = {}
    for line in sys.stdin:
        task = json.loads(line)
        key = task["program"], task["work"], task["length"]
        try:
            if key not in made:
                made[key] = WORKS[key[:2]](task["length"])
            if task.get("warm", True):
                made[key](task["setting"])
            begin = time.process_time()
            values = made[key](task["setting"])
            told: dict[str, Any] = {"seconds": time.process_time() - begin, "values": values}
        except Exception as error:
            told = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(told), flush=True)


if __name__ == "__main__":
    main()
