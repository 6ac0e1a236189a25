"""Errors of one method at one tolerance, quantity by quantity."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from chaosdrill.analysis.precision.start import TIGHT, TIGHT_METHODS, Mapped, Place, Survey, find_cycle, run_map
from chaosdrill.analysis.tuning import PRECISION
from chaosdrill.codegen import kernels_of
from chaosdrill.dataset import Outcome
from chaosdrill.engine.methods import METHODS
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.errors import SettingsError
from chaosdrill.model import HybridSystem

QUANTITIES = ("strobe", "event_time", "tangent", "multiplier", "flow_direction", "exponent")


@dataclass
class Errors:
    """Errors by quantity, NaN for those that could not be measured; the horizon; and how the runs ended."""

    outcome: Outcome = Outcome.OK
    values: dict[str, float] = field(default_factory=lambda: dict.fromkeys(QUANTITIES, float("nan")))
    exponent_spread: float = float("nan")
    horizon: float = float("nan")


@dataclass
class Yardstick:
    """Reference of every method: the truth, and where it is unknown another method at the tightest tolerance.

    ``place``: start and truth. ``found``: for the restarts. ``most``: units over which a trajectory is followed; 0: no
    horizon is looked for.
    """

    place: Place
    found: Survey
    most: int = 0
    _rates: dict[str, np.ndarray] = field(default_factory=dict)
    _ends: dict[str, bool] = field(default_factory=dict)
    _paths: dict[str, tuple[list[HybridSystem], np.ndarray]] = field(default_factory=dict)

    def numerics(self, method: str) -> Numerics:
        """A method at the tightest tolerance that it reaches."""
        return replace(self.found.numerics, method=method, tolerance=METHODS[method].tightest)

    def rates_by(self, method: str) -> np.ndarray:
        """Growth over the restarts, shape (restarts,)."""
        if method not in self._rates:
            self._rates[method] = growth(self.found, self.place.unit, self.numerics(method))
        return self._rates[method]

    def references(self) -> Iterator[str]:
        """Methods of which all restarts come to the end, first those that agree with the truth, if there is one."""
        others = []
        for method in TIGHT_METHODS:
            if not self._agrees(method):
                others.append(method)
            elif np.isfinite(self.rates_by(method)).all():
                yield method
        yield from (method for method in others if np.isfinite(self.rates_by(method)).all())

    def reference(self, judged: str) -> str | None:
        """The method that one is held against: another one."""
        return next((method for method in self.references() if method != judged), None)

    def _agrees(self, method: str) -> bool:
        """Whether a method ends the stretch where the truth does."""
        place = self.place
        if place.truth is None:
            return True
        if method not in self._ends:
            mapped = run_map(place.system, place.unit, place.count, self.numerics(method))
            self._ends[method] = (
                mapped.outcome == Outcome.OK
                and _largest(mapped.state / place.sizes, place.truth.state) <= PRECISION.target
            )
        return self._ends[method]

    def paths(self, method: str) -> tuple[list[HybridSystem], np.ndarray]:
        """Starts and strobe points, as `true_paths` gives them."""
        if method not in self._paths:
            self._paths[method] = true_paths(self.found, self.place.unit, self.numerics(method), self.most)
        return self._paths[method]

    def exponent(self) -> tuple[float, float]:
        """Leading exponent and its statistical error, which is 0 where the multipliers of a cycle tell it."""
        place = self.place
        if place.truth is None or not place.period:
            return self.found.exponent
        largest = float(np.abs(place.truth.multipliers).max())
        return float(np.log(largest) / (place.period * place.unit)) if largest > 0 else -np.inf, 0.0


def measure(yardstick: Yardstick, numerics: Numerics) -> Errors:
    """All errors of one method at one tolerance.

    ``numerics``: method and tolerance.
    """
    errors, place, found = Errors(), yardstick.place, yardstick.found
    try:
        system, mapped = place.system, run_map(place.system, place.unit, place.count, numerics)
        errors.outcome = mapped.outcome
        if place.period and mapped.outcome == Outcome.OK:
            system, own = find_cycle(place.system, place.unit, place.period, numerics, PRECISION.cycle_steps)
            errors.outcome = Outcome.FAILED if own is None else own.outcome
            mapped = own or mapped
        if errors.outcome != Outcome.OK:
            return errors
        _against_truth(errors.values, place, system, mapped)
        errors.values["flow_direction"] = flow_direction_error(place, numerics)
        rates, other = growth(found, place.unit, numerics), yardstick.reference(numerics.method)
        if other is None:
            return errors
        if np.isfinite(rates).all():
            errors.values["exponent"], errors.exponent_spread = _mean_difference(rates, yardstick.rates_by(other))
        if yardstick.most and numerics.tolerance > TIGHT:
            errors.horizon = trusted_time(*yardstick.paths(other), place.sizes, place.unit, numerics)
    except (SettingsError, np.linalg.LinAlgError):
        errors.outcome = Outcome.FAILED
    return errors


def _against_truth(values: dict[str, float], place: Place, system: HybridSystem, mapped: Mapped) -> None:
    truth = place.truth
    if truth is None:
        return
    # on a cycle the method's own fixed point is compared with the true one, else the ends of the two runs
    state = np.array(system.initial_values) if place.period else mapped.state
    goal, sizes = truth.start if place.period else truth.state, place.sizes
    values["strobe"] = _largest(state / sizes, goal)
    if truth.times:
        same = mapped.found.transitions.tolist() == truth.transitions
        values["event_time"] = _largest(mapped.found.times, truth.times) / place.unit if same else float("inf")
    entries = [truth.tangent[i, j] for i in range(len(goal)) for j in range(len(goal))]
    size = max(1.0, *(abs(float(entry)) for entry in entries))
    values["tangent"] = _largest((mapped.tangent * sizes / sizes[:, np.newaxis]).ravel(), entries) / size
    if place.period:
        values["multiplier"] = multiplier_error(np.linalg.eigvals(mapped.tangent), truth.multipliers)


def _largest(found: np.ndarray, exact: list[Any]) -> float:
    """Largest difference, taken before the exact numbers are rounded."""
    return float(max(abs(a - float(b)) for a, b in zip(exact, found, strict=True)))


def multiplier_error(found: np.ndarray, exact: np.ndarray) -> float:
    """Largest distance of multipliers that belong together, relative to the largest if that is above 1."""
    left = list(np.asarray(found, dtype=complex))
    worst = 0.0
    for value in sorted(exact, key=lambda value: -abs(value)):
        nearest = min(range(len(left)), key=lambda i: abs(left[i] - value))
        worst = max(worst, abs(left.pop(nearest) - value))
    return worst / max(1.0, float(np.abs(exact).max()))


def flow_direction_error(place: Place, numerics: Numerics) -> float:
    """How far the tangent map leads F at the start away from F at the end, relative to F, in the system with time.

    States are counted in their sizes, and time in units.
    """
    system, unit = place.system, place.unit
    sizes = np.append(place.sizes, unit)
    if not system.autonomous:
        if "with time" not in system.shared:
            system.shared["with time"] = system.augmented(time=True)
        timed = system.shared["with time"].with_parameters(**system.parameters)
        system = timed.with_initial(**{**system.initial, system.time.name: 0.0})
    size = len(system.state_names) + len(system.quadratures)
    before, after = np.empty(size), np.empty(size)
    c = kernels_of(system).constants(system.parameters)
    field_of = kernels_of(system).functions.field
    start = np.array(system.initial_values)
    n = len(start)
    field_of(system.initial_mode, 0.0, c, start, before)
    run = Run(system, unit, numerics, tangents=before[np.newaxis, :n], orthonormalise=False)
    outcome, _ = run.advance(place.count)
    if outcome != Outcome.OK:
        return float("nan")
    field_of(system.mode_names.index(run.mode), run.elapsed, c, run.x, after)
    size_of_field = (np.abs(after[:n]) / sizes[:n]).max()
    off = (np.abs(run.vectors[0] - after[:n]) / sizes[:n]).max()
    return float(off / size_of_field) if size_of_field > 0 else float("nan")


def growth(found: Survey, unit: float, numerics: Numerics) -> np.ndarray:
    """Growth rate of the leading tangent over each restarted unit, shape (restarts,); NaN where a run ended early.

    Its length is that in the sizes of the states.
    """
    rates = []
    for i in found.restarts():
        run = Run(found.start(i), unit, numerics, tangents=found.tangents[i : i + 1])
        outcome, _ = run.advance(1)
        before, after = (np.linalg.norm(tangent / found.sizes) for tangent in (found.tangents[i], run.vectors[0]))
        sound = outcome == Outcome.OK and not run.lost[0]
        rates.append((run.logs[0] + np.log(after / before)) / unit if sound else np.nan)
    return np.array(rates)


def _mean_difference(rates: np.ndarray, exact: np.ndarray) -> tuple[float, float]:
    """Mean difference of two sets of growth rates from the same starts, in modulus, and its standard error."""
    apart = rates - exact
    spread = float(apart.std(ddof=1) / np.sqrt(len(apart))) if len(apart) > 1 else float("nan")
    return float(abs(apart.mean())), spread


def true_paths(found: Survey, unit: float, numerics: Numerics, most: int) -> tuple[list[HybridSystem], np.ndarray]:
    """Starts and strobe points by a method, shape (starts, units, n); NaN after an early end."""
    chosen = found.restarts()[:: max(1, len(found.restarts()) // PRECISION.horizon_starts)][: PRECISION.horizon_starts]
    starts = [found.start(i) for i in chosen]
    return starts, np.array([_path(start, unit, numerics, most) for start in starts])


def _path(start: HybridSystem, unit: float, numerics: Numerics, most: int) -> np.ndarray:
    run = Run(start, unit, numerics)
    path = np.full((most, len(start.state_names)), np.nan)
    for point in path:
        if run.advance(1)[0] != Outcome.OK:
            break
        point[:] = run.x
    return path


def trusted_time(
    starts: list[HybridSystem], paths: np.ndarray, sizes: np.ndarray, unit: float, numerics: Numerics
) -> float:
    """Median time up to which a trajectory stays within the target of the true one; inf if it does to the end.

    Distances are counted in the sizes of the states.
    """
    times = []
    for start, path in zip(starts, paths, strict=True):
        run, parted = Run(start, unit, numerics), float("inf")
        for k, point in enumerate(path, start=1):
            if run.advance(1)[0] != Outcome.OK or not (np.abs(run.x - point) / sizes).max() <= PRECISION.target:
                parted = k * unit
                break
        times.append(parted)
    return float(np.median(times))
