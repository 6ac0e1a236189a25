"""Grazing points held against direct simulation: one period of the orbits on both sides of each of them.

A branch that meets a guard at no speed goes on with an event more or an event less; the parameter may turn back there,
so that the two sides are sides along the branch. On each side orbits next to the grazing point are found by themselves
(``periodic_orbit`` from a guess) and run for one period. The run counts the events, and where the event is missing it
shows how far the guard stays from being met; where it is there, at what speed the guard is met. Both go to zero at the
grazing point, which gives its place a second time, from simulations alone.
"""

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
import sympy
import xarray as xr
from reading import Special, parameter, start, system_of, table
from scipy.interpolate import BarycentricInterpolator

import chaosdrill as cd
from chaosdrill.dataset.outcomes import flag_names

OFFSETS = (1e-5, 1e-6, 1e-7, 1e-8)
"""Distances in the parameter at which orbits are looked for; nearer ones where folds leave none farther away."""

STEPS = np.array([1.0, 2.0, 3.0])
"""Orbits are run at these multiples of the distance."""

SAMPLES = 4000
CLOSE = 1e-8
"""Difference between the two places of a grazing point that is allowed."""


@dataclass(frozen=True)
class Touch:
    """Runs on the two sides of a grazing point.

    Parameters
    ----------
    offset : float
        Distance of the nearest runs in the parameter.
    events : tuple of str
        Names of the events that one side has and the other has not.
    without, with_ : tuple of int
        Events in one period, on the side without them and on the other.
    turns : bool
        Whether both sides are at the same side of the parameter.
    gap : float
        Smallest distance from the guard at the first offset on the side without.
    speed : float
        Smallest speed at which the guard is met at the first offset on the other.
    off : float
        Difference between the place at which the distance is zero, by the runs, and the grazing point of the branch.
    as_told : bool
        Whether every run met the events that the branch names on that side.
    """

    offset: float
    events: tuple[str, ...]
    without: int
    with_: int
    turns: bool
    gap: float
    speed: float
    off: float
    as_told: bool

    @property
    def agrees(self) -> bool:
        """Whether the simulations show the grazing point where the branch has it."""
        return self.as_told and self.gap > 0 and self.speed > 0 and self.off < CLOSE


def touch(special: Special, offsets: Iterable[float] = OFFSETS) -> Touch | None:
    """Return what simulations on both sides of a grazing point show; None if there are no orbits to run."""
    found = None
    for offset in offsets:
        found = _touch(special, offset) or found
        if found is not None and found.agrees:
            break
    return found


def _touch(special: Special, offset: float) -> Touch | None:
    near = {way: special.along(way)[1] for way in (-1, 1)}
    names = {way: _told(special, point) for way, point in near.items()}
    more = max(near, key=lambda way: sum(names[way].values()))
    extra = tuple((names[more] - names[-more]).elements())
    values = special.branches[parameter(special.branches)].values
    sides = {way: float(np.sign(values[point] - special.value)) for way, point in near.items()}
    told, runs = True, {}
    for way in near:
        places = special.value + sides[way] * offset * STEPS
        systems = [system_of(special.branches, value) for value in places]
        runs[way] = [_one_period(special, system, way) for system in systems]
        if any(run is None for run in runs[way]):
            return None
        told &= all(_events(run) == names[way] for run in runs[way])
        if way != more:
            gaps = [smallest_distance(system, run, extra) for system, run in zip(systems, runs[way], strict=True)]
    if not np.isfinite(gaps).all():
        return None
    away = sides[-more] * offset * STEPS
    off = float(np.polynomial.polynomial.polyfit(gaps, away, len(away) - 1)[0])
    return Touch(
        offset=offset,
        events=extra,
        without=sum(_events(runs[-more][0]).values()),
        with_=sum(_events(runs[more][0]).values()),
        turns=sides[1] == sides[-1],
        gap=gaps[0],
        speed=_slowest(runs[more][0], extra),
        off=abs(off),
        as_told=told,
    )


def _told(special: Special, point: int) -> Counter[str]:
    """Events of one period by the branch."""
    sequence = int(special.branches["sequence"].values[point])
    return Counter(str(special.branches["event_sequence"].values[sequence]).split())


def _events(run: xr.Dataset) -> Counter[str]:
    names = flag_names(run["event_kind"])
    return Counter(names[int(kind)] for kind in run["event_kind"].values)


def _one_period(special: Special, system: "cd.HybridSystem", way: int) -> xr.Dataset | None:
    """Run of one period from the orbit of a system on one side of the grazing point; or None."""
    guess = _between(special, system.parameters[parameter(special.branches)], way)
    if guess is None:
        return None
    orbit = cd.periodic_orbit(system.with_initial(**guess), period=special.period, start="guess")
    if not np.isfinite(orbit["orbit_state"].values).all():
        return None
    found = start(system, orbit["orbit_state"].values, flag_names(orbit["mode"])[int(orbit["mode"])])
    return cd.trajectory(system.with_initial(**found), periods=special.period, samples=SAMPLES)


def _between(special: Special, value: float, way: int) -> dict[str, float | str] | None:
    """State at a value by the cubic through the nearest points of the branch; None beyond a fold."""
    points = special.stretch(way)
    values = special.branches[parameter(special.branches)].values[points]
    after = int(np.searchsorted(np.abs(values - special.value), abs(value - special.value)))
    if after == len(points):
        return None
    first = max(min(after - 2, len(points) - 4), 0)
    nearest = points[first : first + 4]
    beyond, mode = special.orbit(points[after])
    # the first strobe of an orbit may be another one of its strobes where the events change
    turned = [[np.roll(special.orbit(point)[0], -k, axis=0) for k in range(special.period)] for point in nearest]
    states = [min(turns, key=lambda orbit: float(np.abs(orbit - beyond).max()))[0] for turns in turned]
    guess = BarycentricInterpolator(values[first : first + 4] - special.value, states)(value - special.value)
    return start(system_of(special.branches, value), guess, mode)


def _slowest(run: xr.Dataset, names: Iterable[str]) -> float:
    kinds = flag_names(run["event_kind"])
    wanted = [kinds[int(kind)] in names for kind in run["event_kind"].values]
    return float(np.abs(run["event_speed"].values[wanted]).min())


def smallest_distance(system: "cd.HybridSystem", run: xr.Dataset, names: Iterable[str]) -> float:
    """Return how near a run comes to a guard of one of these events without meeting it.

    The extrema of a guard between two samples are those of the cubic through its values and rates there.
    """
    modes = flag_names(run["mode"])
    kept = np.array([modes[int(code)] for code in run["mode"].values])
    time, states = run["time"].values, run["states"].values
    bounds = np.searchsorted(run["event_time"].values, time)
    smallest = np.inf
    for transition in system.transitions:
        if transition.name not in names:
            continue
        for mode in transition.source:
            value, rate = _guard(system, transition.guard, mode)
            sign = -transition.direction
            g, dg = sign * value(time, states), sign * rate(time, states)
            inside = (kept[:-1] == mode) & (kept[1:] == mode) & (bounds[:-1] == bounds[1:])
            for i in np.flatnonzero(inside & (dg[:-1] < 0) & (dg[1:] >= 0)):
                smallest = min(smallest, _minimum(time[i + 1] - time[i], g[i : i + 2], dg[i : i + 2]))
    return smallest


def _minimum(h: float, g: np.ndarray, dg: np.ndarray) -> float:
    """Minimum of the cubic with these values and rates at 0 and h."""
    slope = (g[1] - g[0]) / h
    cubic = np.polynomial.Polynomial(
        [g[0], dg[0], (3 * slope - 2 * dg[0] - dg[1]) / h, (dg[0] + dg[1] - 2 * slope) / h**2]
    )
    roots = cubic.deriv().roots()
    real = np.real(roots[np.abs(np.imag(roots)) < 1e-12 * h])
    inside = real[(real >= 0) & (real <= h)]
    return float(cubic(inside).min()) if len(inside) else float(g.min())


Along = Callable[[np.ndarray, np.ndarray], np.ndarray]


def _guard(system: "cd.HybridSystem", guard: sympy.Expr, mode: str) -> tuple[Along, Along]:
    """Value of a guard and its rate of change in a mode, over times and states."""
    values = system.parameters
    numbers = {symbol: values[symbol.name] for symbol in _symbols(system) if symbol.name in values}
    field = system.modes[mode]
    rate = sum(sympy.diff(guard, x) * field[x] for x in system.states) + sympy.diff(guard, system.time)
    functions = []
    for expression in (guard, rate):
        given = sympy.lambdify([system.time, *system.states], sympy.sympify(expression).subs(numbers), "numpy")
        functions.append(lambda t, x, f=given: np.broadcast_to(f(t, *x.T), t.shape))
    return functions[0], functions[1]


def _symbols(system: "cd.HybridSystem") -> set[sympy.Symbol]:
    found = set()
    for field in system.modes.values():
        found |= set().union(*(sympy.sympify(rate).free_symbols for rate in field.values()))
    return found | set().union(*(sympy.sympify(t.guard).free_symbols for t in system.transitions))


def tables(checked: Iterable[tuple[str, Special, Touch | None]]) -> str:
    """Return the table: a line a grazing point."""
    head = ["orbit", "grazing at", "run at distance", "event", "sides of the parameter", "events without / with"]
    head += ["nearest without", "speed with", "place by simulation off by", ""]
    return table(head, ([name, f"{special.value:.12f}", *_cells(found)] for name, special, found in checked))


def _cells(found: Touch | None) -> list[str]:
    if found is None:
        return ["no orbits to run", *[""] * 6, "disagree"]
    return [
        f"{found.offset:.0e}",
        " ".join(found.events),
        "the same" if found.turns else "opposite",
        f"{found.without} / {found.with_}",
        f"{found.gap:.1e}",
        f"{found.speed:.1e}",
        f"{found.off:.0e}",
        "agree" if found.agrees else "disagree",
    ]
