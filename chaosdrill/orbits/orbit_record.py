"""What a Python function of an orbit is given: times, states and events of one round, and its multipliers."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.polynomial import chebyshev

from chaosdrill.engine import shooting as at
from chaosdrill.orbits.multipliers import all_multipliers, free_multipliers
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.problem import Problem

PYTHON = "Python function "


class PythonFunction(str):
    """The name of a Python function of an orbit, as settings and archives have it, with the function itself."""

    function: Callable[["OrbitRecord"], float]

    def __new__(cls, function: Callable[["OrbitRecord"], float]) -> "PythonFunction":
        """The name of a function."""
        made = super().__new__(cls, PYTHON + getattr(function, "__qualname__", type(function).__name__))
        made.function = function
        return made


@dataclass(frozen=True)
class OrbitRecord:
    """One round of an orbit, K instants from its start to its end; states at an event stand before and after it.

    Attributes
    ----------
    times : ndarray, shape (K,)
        Rising; the first is the phase of the forcing at which the orbit starts.
    states : mapping of a state to ndarray, shape (K,)
    modes : ndarray of str, shape (K,)
    weights : ndarray, shape (K,)
        Of Clenshaw-Curtis quadrature: ``weights @ values`` is an integral over the round.
    period : float
        Duration of the round.
    parameters : mapping of a parameter to float
    events : list of str
        Names of the E events, in order.
    event_times : ndarray, shape (E,)
    event_states : mapping of a state to ndarray, shape (E,)
        Before the events.
    """

    times: np.ndarray
    states: Mapping[str, np.ndarray]
    modes: np.ndarray
    weights: np.ndarray
    period: float
    parameters: Mapping[str, float]
    events: Sequence[str]
    event_times: np.ndarray
    event_states: Mapping[str, np.ndarray]
    _spectrum: Callable[[], np.ndarray]
    _piece: int  # instants of a piece on which all is smooth

    @cached_property
    def multipliers(self) -> np.ndarray:
        """Multipliers that structure leaves free, complex, shape (m,), by falling modulus."""
        return self._spectrum()

    def total(self, values: np.ndarray) -> float:
        """Integral over the round of values at the instants, shape (K,)."""
        return float(self.weights @ values)

    def mean(self, values: np.ndarray) -> float:
        """Their mean over the round."""
        return self.total(values) / self.period

    def maximum(self, values: np.ndarray) -> float:
        """Their largest value, also between the instants, from the polynomials through them."""
        rows = np.broadcast_to(np.asarray(values, dtype=float), self.times.shape).reshape(-1, self._piece)
        best = float(rows.max())
        # between its values a polynomial rises by less than neighbours are apart
        near = rows.max(axis=1) + np.abs(np.diff(rows, axis=1)).max(axis=1) >= best
        for row in rows[near]:
            series = chebyshev.chebfit(_NODES, row, self._piece - 1)
            slope = chebyshev.chebtrim(chebyshev.chebder(series), 1e-15 * np.abs(series).max())
            roots = chebyshev.chebroots(slope)
            inside = roots.real[(np.abs(roots.imag) < 1e-6) & (np.abs(roots.real) <= 1)]
            best = max([best, *chebyshev.chebval(inside, series).tolist()])
        return best

    def minimum(self, values: np.ndarray) -> float:
        """Their smallest value, also between the instants."""
        return -self.maximum(-np.asarray(values, dtype=float))


def value_of(
    function: Callable[[OrbitRecord], float], problem: "Problem", orbit: "Orbit", accuracy: float
) -> tuple[float, float]:
    """A Python function of an orbit, and its error: of what is between the instants, and of the orbit.

    ``accuracy``: error of the orbit, relative to the sizes of its states.
    """
    record = _record(problem, orbit, 1)
    value, off, pieces = _number(function(record)), np.inf, 2
    while pieces <= TUNING.function_pieces and np.isfinite(value) and not off <= TUNING.function_error * abs(value):
        record = _record(problem, orbit, pieces)
        value, before = _number(function(record)), value
        off, pieces = abs(value - before), 2 * pieces
    error, part = off + np.finfo(float).eps * abs(value), TUNING.function_shift
    for beside in _beside(problem, record):
        error += accuracy * abs(_number(function(beside)) - value) / part
    return value, error


def _number(value: Any) -> float:
    if np.ndim(value) or isinstance(value, complex | np.complexfloating):
        raise TypeError(f"it gives {value!r:.60}, which is no number")
    return float(value)


def _beside(problem: "Problem", record: OrbitRecord) -> Iterator[OrbitRecord]:
    """The record with each state changed by a small part, of its size and of itself, and so with all multipliers."""
    part = TUNING.function_shift
    for size, (name, values) in zip(problem.sizes, record.states.items(), strict=True):
        by, before = part * max(float(size), float(np.abs(values).max())), record.event_states[name]
        for now, then in ((values + by, before + by), (values * (1 + part), before * (1 + part))):
            yield replace(record, states={**record.states, name: now}, event_states={**record.event_states, name: then})
    if "multipliers" in vars(record):
        moved = record.multipliers + part * max(1.0, float(np.abs(record.multipliers).max(initial=0)))
        yield replace(record, _spectrum=lambda: moved)


def _record(problem: "Problem", orbit: "Orbit", pieces: int) -> OrbitRecord:
    """One round with ``pieces`` pieces on every segment."""
    d, plain = problem.states, problem.plain
    parts = ((np.arange(pieces)[:, np.newaxis] + (_NODES + 1) / 2) / pieces).ravel()
    shares = np.tile(_WEIGHTS, pieces) / (2 * pieces)
    times, states, modes, weights, begin = [], [], [], [], orbit.phase
    events, instants, met = [], [], []
    for one, before in problem.segment_by_segment(orbit):
        length = float(one.durations[0])
        times.append(begin + length * parts)
        states.append(problem.at([one], (length * parts)[np.newaxis])[0][0])
        modes += [plain.mode_names[one.segments[0, at.SEGMENT_MODE]]] * len(parts)
        weights.append(length * shares)
        begin += length
        if one.segments[0, at.SEGMENT_END] >= 0:
            events.append(plain.transitions[one.segments[0, at.SEGMENT_OUTCOME]].name)
            instants.append(begin)
            met.append(before)
    named = dict(zip(plain.state_names, np.concatenate(states).T, strict=True))
    at_events = dict(zip(plain.state_names, np.array(met).reshape(-1, d).T, strict=True))
    free = dict(zip(problem.free, orbit.starts[0, d:].tolist(), strict=True))

    def spectrum() -> np.ndarray:
        return free_multipliers(all_multipliers(problem, orbit, problem.shoot(orbit, False)), problem.neutral.count)

    return OrbitRecord(
        np.concatenate(times),
        named,
        np.array(modes),
        np.concatenate(weights),
        float(orbit.durations.sum()),
        {**plain.parameters, **free},
        events,
        np.array(instants),
        at_events,
        spectrum,
        len(_NODES),
    )


def _clenshaw_curtis(last: int) -> tuple[np.ndarray, np.ndarray]:
    """Chebyshev points, -1 and 1 among them, and their weights (Trefethen 2008, doi:10.1137/060659831)."""
    nodes = -np.cos(np.pi * np.arange(last + 1) / last)
    moments = np.zeros(last + 1)
    moments[::2] = 2 / (1 - np.arange(0, last + 1, 2.0) ** 2)
    return nodes, np.linalg.solve(chebyshev.chebvander(nodes, last).T, moments)


_NODES, _WEIGHTS = _clenshaw_curtis(16)
