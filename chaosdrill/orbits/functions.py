"""A user's own functions of an orbit: means, totals and extremes of an expression along it, or at its events.

They are taken on the segments of an orbit, so that those of an unstable one are as exact as it is: totals by
Gauss-Legendre quadrature, extremes by a grid on every segment that narrows about the largest values.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.codegen.formulas import function_of
from chaosdrill.orbits.orbit_record import PythonFunction, value_of
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.problem import Problem, Shot

NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)


@dataclass(frozen=True)
class OrbitFunction:
    """A number that every orbit has."""

    name: str
    of: Callable[..., Any] | None
    """Function of `chaosdrill.orbits.orbit_record.OrbitRecord`, of which nothing is taken; None for an expression of
    states, time, parameters and quadratures, each of which stands for its rate."""
    text: str  # expression, or name of the function
    take: str  # {"mean", "total", "maximum", "minimum"}: over one period of the orbit, or the events in it; or "value"
    at: str | None = None  # name or kind of the events before which it is taken; None: all along the orbit
    modes: tuple[str, ...] | None = None  # where it counts; elsewhere it is zero for a total and left out of an extreme
    units: str = "1"

    @property
    def words(self) -> str:
        """What it is, as in "maximum of x before impact"."""
        if self.of is not None:
            return self.text
        where = "" if self.at is None else f" before {self.at}"
        within = "" if self.modes is None else f" in {', '.join(self.modes)}"
        return f"{self.take} of {self.text}{where}{within}"


def read_function(system: "HybridSystem", name: str, table: Mapping[str, Any]) -> OrbitFunction:
    """The function that a table of settings describes.

    Raises `ExpressionError` for an expression that cannot be read.
    """
    if isinstance(table["of"], PythonFunction):
        return OrbitFunction(name, table["of"].function, table["of"], "value", units=table.get("units", "1"))
    if not any(_name(table["of"], mode) in system.shared.get("formulas", ()) for mode in system.modes):
        # one that no orbit asks for, for want of its event, is known to be sound by its formula as well
        _code(system, table["of"], next(iter(system.modes)))
    modes = table.get("modes")
    return OrbitFunction(
        name,
        None,
        table["of"],
        table.get("take", "mean"),
        table.get("at"),
        None if modes is None else tuple(modes),
        table.get("units", "1"),
    )


def _name(text: str, mode: str) -> str:
    """Under which the formula of an expression in a mode is kept, once the expression was found to be sound."""
    return f"function of an orbit in {mode}: {text}"


def _read(system: "HybridSystem", text: str) -> Any:
    """The expression of a text, of the symbols of the system and of symbols that stand for rates of quadratures."""
    import sympy

    from chaosdrill.model.places import parameter
    from chaosdrill.model.text import read_text

    moving = (*system.states, *(() if system.time is None else (system.time,)))
    names = {symbol.name: symbol for symbol in moving} | {one: parameter(one) for one in system.parameters}
    return read_text(text, {one: sympy.Symbol(one, real=True) for one in system.quadratures} | names)


@dataclass(frozen=True)
class _Stretch:
    """One segment of orbits that have the same ones."""

    mode: str
    transition: int  # that ends it; -1 for none
    orbits: list["Orbit"]  # each with this segment only
    durations: np.ndarray  # (P,)


@dataclass(frozen=True)
class _Lap:
    """Orbits that have the same segments."""

    problem: "Problem"
    orbits: Sequence["Orbit"]
    parameters: list[np.ndarray]  # (P, 1) each: all parameters of the system
    sizes: np.ndarray  # (d,): of the states
    errors: np.ndarray  # (P, 1): of the states, relative to their sizes

    def stretches(self) -> Iterator[_Stretch]:
        """The segments, in order."""
        problem, first = self.problem, self.orbits[0]
        values = np.array([o.starts[0, problem.states :] for o in self.orbits])
        periods = problem.periods_at(values) if problem.forced else None
        clocks = np.array([o.phase for o in self.orbits])
        for i, (mode, end, transition) in enumerate(first.segments.tolist()):
            parts = [
                replace(
                    o,
                    segments=o.segments[i : i + 1],
                    starts=o.starts[i : i + 1],
                    phase=float(clock),
                    durations=o.durations[i : i + 1],
                )
                for o, clock in zip(self.orbits, clocks, strict=True)
            ]
            durations = np.array([o.durations[i] for o in self.orbits])
            yield _Stretch(problem.plain.mode_names[mode], transition if end >= 0 else -1, parts, durations)
            clocks = clocks + durations if periods is None else (clocks + durations) % periods


class Functions:
    """Functions of the orbits of one system.

    ``system``: whose modes, events and quadratures they name.
    """

    def __init__(self, system: "HybridSystem", functions: Sequence[OrbitFunction]) -> None:
        self.system, self.functions = system, tuple(functions)
        self._codes: dict[tuple[int, str], Any] = {}
        self.failures: dict[str, None] = {}
        """What Python functions raised, in words, once each."""

    def __len__(self) -> int:
        return len(self.functions)

    @property
    def names(self) -> list[str]:
        """Their names, in order."""
        return [one.name for one in self.functions]

    def __call__(
        self, problem: "Problem", orbits: Sequence["Orbit"], shots: Sequence["Shot"]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Values and errors on orbits of the same segments, both of shape (P, functions).

        NaN where an orbit has no such event, or is in no such mode. ``shots`` say how well the orbits are known.
        """
        lap = self._lap(problem, orbits, [_error(problem, shot) for shot in shots])
        found = [self._taken(index, lap) for index in range(len(self))]
        values, errors = (np.array(part).reshape(len(self), len(orbits)).T for part in zip(*found, strict=True))
        return values, errors

    def at(self, index: int, problem: "Problem", orbit: "Orbit") -> float:
        """The value of one of them on one orbit."""
        return float(self._taken(index, self._lap(problem, [orbit], [problem.accuracy]))[0][0])

    def _lap(self, problem: "Problem", orbits: Sequence["Orbit"], errors: list[float]) -> _Lap:
        free = np.array([o.starts[0, problem.states :] for o in orbits])
        known = {name: np.full((len(orbits), 1), value) for name, value in problem.plain.parameters.items()}
        known |= {name: free[:, k : k + 1] for k, name in enumerate(problem.free)}
        starts = np.array([o.starts[:, : problem.states] for o in orbits])
        sizes = np.maximum(problem.sizes, np.abs(starts).max(axis=(0, 1)))
        return _Lap(problem, orbits, [known[name] for name in self.system.parameters], sizes, np.array(errors)[:, None])

    def _of_records(self, name: str, of: Callable[..., Any], lap: _Lap) -> tuple[np.ndarray, np.ndarray]:
        """A Python function on every orbit; NaN where it raises an exception."""
        found = np.full((2, len(lap.orbits)), np.nan)
        for k, (orbit, error) in enumerate(zip(lap.orbits, lap.errors[:, 0].tolist(), strict=True)):
            try:
                found[:, k] = value_of(of, lap.problem, orbit, error)
            except Exception as failure:
                self.failures[f"{name} raised {failure!r:.100}"] = None
        return found[0], found[1]

    def _taken(self, index: int, lap: _Lap) -> tuple[np.ndarray, np.ndarray]:
        function, transitions = self.functions[index], self.system.transitions
        if function.of is not None:
            return self._of_records(function.name, function.of, lap)
        within = [s for s in lap.stretches() if function.modes is None or s.mode in function.modes]
        if function.at is not None:
            named = {i for i, t in enumerate(transitions) if function.at in (t.name, t.kind)}
            within = [s for s in within if s.transition in named]
        if not within:
            empty = np.full(len(lap.orbits), 0.0 if function.take == "total" else np.nan)
            return empty, np.abs(empty)
        if function.at is not None:
            return self._over_events(index, lap, within)
        if function.take in ("mean", "total"):
            return self._over_time(index, lap, within)
        return self._extreme(index, lap, within)

    def _over_events(self, index: int, lap: _Lap, ends: list[_Stretch]) -> tuple[np.ndarray, np.ndarray]:
        """Over the states before the events that end these segments."""
        take = self.functions[index].take
        found = [self._known(index, lap, stretch, np.ones(1)) for stretch in ends]
        values, errors = (np.array(part)[:, :, 0] for part in zip(*found, strict=True))
        if take in ("mean", "total"):
            count = len(ends) if take == "mean" else 1
            return values.sum(axis=0) / count, errors.sum(axis=0) / count
        chosen = (values if take == "maximum" else -values).argmax(axis=0)[np.newaxis]
        return np.take_along_axis(values, chosen, 0)[0], np.take_along_axis(errors, chosen, 0)[0]

    def _over_time(self, index: int, lap: _Lap, stretches: list[_Stretch]) -> tuple[np.ndarray, np.ndarray]:
        """The integral along these segments, or its mean over the whole orbit."""
        total, error = np.zeros(len(lap.orbits)), np.zeros(len(lap.orbits))
        for stretch in stretches:
            pieces, found, off = 1, np.full(len(lap.orbits), np.inf), np.zeros(0)
            while pieces <= TUNING.function_pieces:
                parts = ((np.arange(pieces)[:, np.newaxis] + (NODES + 1) / 2) / pieces).ravel()
                shares = np.tile(WEIGHTS, pieces) / (2 * pieces)
                values = self._values(index, lap, stretch, parts)[2]
                found, before, sizes = values @ shares, found, np.abs(values) @ shares
                off = np.abs(found - before)
                pieces *= 2
                if not (off > TUNING.function_error * sizes).any():
                    break
            errors = self._known(index, lap, stretch, parts)[1]
            total += stretch.durations * found
            error += stretch.durations * (errors @ shares + off + lap.problem.accuracy * sizes)
        if self.functions[index].take == "total":
            return total, error
        whole = np.array([o.durations.sum() for o in lap.orbits])
        return total / whole, error / whole

    def _extreme(self, index: int, lap: _Lap, stretches: list[_Stretch]) -> tuple[np.ndarray, np.ndarray]:
        """The extreme over all instants of these segments, their ends included."""
        sign = 1.0 if self.functions[index].take == "maximum" else -1.0
        best, error = np.full(len(lap.orbits), -np.inf), np.zeros(len(lap.orbits))
        for stretch in stretches:
            parts = np.linspace(0.0, 1.0, TUNING.function_grid + 1)
            values, errors = self._known(index, lap, stretch, parts)
            top = self._top(index, lap, stretch, sign * values, sign)
            error = np.where(top > best, errors.max(axis=1), error)
            best = np.maximum(best, top)
        return sign * best, error

    def _top(self, index: int, lap: _Lap, stretch: _Stretch, values: np.ndarray, sign: float) -> np.ndarray:
        """The greatest value of every orbit, times ``sign``, given those on a grid of the segment."""
        rows, last = np.arange(len(values)), values.shape[1] - 1
        left, middle, right = values[:, :-2], values[:, 1:-1], values[:, 2:]
        # the parabola through three neighbours tells which of several tops is the highest
        bend = 2 * middle - left - right
        with np.errstate(divide="ignore", invalid="ignore"):
            rise = np.where(
                (middle >= left) & (middle >= right) & (bend > 0), (right - left) / (8 * bend) * (right - left), 0.0
            )
        centre, width, best = (1 + (middle + rise).argmax(axis=1)) / last, 1.0 / last, values.max(axis=1)
        while width > TUNING.function_narrowest:
            near = np.clip(centre[:, np.newaxis] + width * np.linspace(-1, 1, 9), 0.0, 1.0)
            found = sign * self._values(index, lap, stretch, near)[2]
            place = found.argmax(axis=1)
            best = np.maximum(best, found[rows, place])
            centre, width = near[rows, place], width / 4
        return np.asarray(best)

    def _known(self, index: int, lap: _Lap, stretch: _Stretch, parts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values at parts of a segment, and how far the error of the orbit may change them; both (P, K)."""
        times, states, values = self._values(index, lap, stretch, parts)
        errors = np.finfo(float).eps * np.abs(values)
        for i, size in enumerate(lap.sizes):
            moved = states.copy()
            moved[:, :, i] += TUNING.function_shift * size
            beside = self._computed(index, lap, stretch.mode, times, moved)
            with np.errstate(invalid="ignore"):
                errors = errors + lap.errors * np.abs(beside - values) / TUNING.function_shift
        return values, np.asarray(errors)

    def _values(
        self, index: int, lap: _Lap, stretch: _Stretch, parts: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Times (P, K), states (P, K, d) and values (P, K) at rising parts of a segment, shape (K,) or (P, K)."""
        instants = stretch.durations[:, np.newaxis] * parts
        states = lap.problem.at(stretch.orbits, instants)[0]
        times = np.array([o.phase for o in stretch.orbits])[:, np.newaxis] + instants
        return times, states, self._computed(index, lap, stretch.mode, times, states)

    def _computed(self, index: int, lap: _Lap, mode: str, times: np.ndarray, states: np.ndarray) -> np.ndarray:
        code = self._codes.get((index, mode))
        if code is None:
            code = self._codes[index, mode] = _code(self.system, self.functions[index].text, mode)
        with np.errstate(all="ignore"):
            found = code(times, *np.moveaxis(states, -1, 0), *lap.parameters)
        return np.broadcast_to(np.asarray(found, dtype=float), times.shape)


def _error(problem: "Problem", shot: "Shot") -> float:
    """Error of an orbit relative to its size: what its residual becomes as it closes, that of the method beside."""
    singular = np.linalg.svd(shot.monodromy - np.eye(len(shot.monodromy)), compute_uv=False)
    kept = singular[: len(singular) - problem.neutral.count]
    residual = max(shot.residual, TUNING.step_error)
    # at a fold it is known to the root
    grown = residual / max(float(kept[-1]), residual**0.5) if len(kept) and np.isfinite(kept).all() else residual
    return problem.accuracy + grown


def _code(system: "HybridSystem", text: str, mode: str) -> Callable[..., Any]:
    """An expression of time, states and parameters as a function of arrays; quadratures stand for their rates."""

    def derive(placed: "HybridSystem") -> Any:
        import sympy

        from chaosdrill.model.places import places_of

        rates = {sympy.Symbol(name, real=True): by.get(mode, 0) for name, by in system.quadratures.items()}
        return _read(system, text).xreplace(rates).xreplace(places_of(system))

    found: Callable[..., Any] = function_of(system, _name(text, mode), derive, arrays=True)
    return found


@dataclass(frozen=True)
class Wanted:
    """Functions of the orbits, and what of them makes a point special."""

    functions: Functions
    levels: Mapping[str, Sequence[float]] = field(default_factory=dict)  # values that they are to take
    optima: Sequence[str] = ()  # those whose largest and smallest values are
