"""Events in one instant: the orders in which they may come, and the tangent map of each order."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

from chaosdrill.analysis.tuning import TIES
from chaosdrill.errors import SettingsError
from chaosdrill.names import shown
from chaosdrill.settings import positive, real
from chaosdrill.typed import refuse

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    from chaosdrill.model import HybridSystem


@dataclass(frozen=True)
class _Order:
    """Events in the order in which they came, and what became of the motion and of a deviation d from it."""

    mode: str
    state: "np.ndarray"  # (n,)
    matrix: "np.ndarray"  # (n, n): of d before all of them
    events: tuple[str, ...] = ()
    crossed: tuple[int, ...] = ()  # surfaces
    delays: "tuple[np.ndarray, ...]" = ()
    """(n,) each: by how much later another event comes, by d; above zero as long as the order holds"""
    last: "np.ndarray | None" = None  # (n,): when the last event came, by d
    declared: bool = True


def event_orders(
    system: "HybridSystem",
    state: "Mapping[str, float] | Sequence[float] | np.ndarray | xr.Dataset",
    *,
    mode: str | None = None,
    time: float = 0.0,
    duration: float | None = None,
) -> "xr.Dataset":
    """The orders in which guards that are met in one instant may come, with the tangent map of each and its cone.

    A motion beside one that meets two guards at once meets them one after the other, in an order that depends on the
    side on which it is. If all orders lead to the same state and mode, the motion has a derivative that is piecewise
    linear: on each cone of deviations the product of the saltation matrices in the order that holds there (Burden,
    Sastry, Koditschek and Revzen 2016, doi:10.1137/15M1016588). All other analyses take the one order that priority
    and declaration give. If the orders lead to different states, the motion itself jumps from one side to the other.
    Orders that hold only on the edges of cones are left out. From a deviation in no cone a reset carries the state
    across another guard, whose event then follows at once.

    Parameters
    ----------
    system : HybridSystem
        System with its parameters.
    state : mapping of state to number, or array_like of shape (n,), or Dataset
        On the guards, before the events. A result of `periodic_orbit` stands for the first state on the orbit in which
        two events happen in one instant, with the other arguments.
    mode : str, optional
        Mode before the events; default: the initial one.
    time : float, default 0
        Time of the events, where the system depends on it.
    duration : float, optional
        Time after which the motion is back in that state and mode: the orbit is periodic, and each order has
        multipliers. At other ties on the way the declared order is taken.

    Returns
    -------
    xarray.Dataset
        ``event`` (order, position), names of transitions; ``matrix`` (order, state, state_before), the tangent map;
        ``cone`` (order, condition, state_before), rows whose products with a deviation are positive where the order
        holds: times by which an event comes later than another one, per unit of the deviation; NaN where an order has
        fewer; ``state_after`` (order, state), ``mode_after`` (order); ``declared`` (order), whether a run takes it.
        The attribute ``continuous`` is 1 where all orders lead to one state and mode. With ``duration``
        ``multiplier_real`` and ``multiplier_imag`` (order, multiplier), by falling modulus, and
        ``multiplier_in_cone``, whether a deviation along its eigenvector meets the events in that order.

    Raises
    ------
    SettingsError
        An argument that cannot be used, a state on no guard, more than 12 events, or a motion that does not lead back.
    """
    import numpy as np
    import xarray as xr

    from chaosdrill.model.system import SYSTEM

    refuse(SettingsError, "system", system, SYSTEM)
    names = list(system.state_names)
    if isinstance(state, xr.Dataset):
        state, mode, time, duration = _tie_on(system, state)
    at, begun = _state(system, state), system.initial["mode"] if mode is None else mode
    if not isinstance(begun, str) or begun not in system.mode_names:
        raise SettingsError(f"mode is {shown(begun):.60}; expected one of {list(system.mode_names)}")
    if not np.isfinite(real(time)):
        raise SettingsError(f"time is {shown(time):.60}; expected a finite number")
    time = real(time)
    if duration is not None:
        duration = positive("duration", duration)
    orders = [one for one in _orders(system, _Order(begun, at, np.eye(len(at))), time) if _holds(one.delays)]
    if not orders[0].events:
        raise SettingsError(f"no guard of mode {begun!r} is met in this state; give one in which two are")
    longest, conditions = max(len(o.events) for o in orders), max(len(o.delays) for o in orders)
    cone = np.full((len(orders), conditions, len(at)), np.nan)
    for i, one in enumerate(orders):
        cone[i, : len(one.delays)] = np.reshape(one.delays, (-1, len(at)))
    over = ("order", "state", "state_before")
    found = xr.Dataset(
        {
            "event": (("order", "position"), [[*o.events, *[""] * (longest - len(o.events))] for o in orders]),
            "matrix": (over, np.array([o.matrix for o in orders]), {"long_name": "tangent map of the order"}),
            "cone": (("order", "condition", "state_before"), cone, {"long_name": "delays of events by deviations"}),
            "state_after": (("order", "state"), np.array([o.state for o in orders]), {"long_name": "state after all"}),
            "mode_after": ("order", [o.mode for o in orders], {"long_name": "mode after all"}),
            "declared": ("order", [o.declared for o in orders], {"long_name": "order that a run takes"}),
        },
        coords={"state": names, "state_before": names, "order": np.arange(1, len(orders) + 1)},
    )
    sizes = np.maximum(np.abs(found["state_after"].values).max(axis=0), np.abs(at))
    apart = np.abs(found["state_after"].values - orders[0].state) > TIES.same * sizes
    one_mode = len({o.mode for o in orders}) == 1
    found.attrs = {"continuous": int(one_mode and not apart.any()), "time": time, "mode": begun}
    return found if duration is None else _multipliers(found, system, orders, begun, time, duration, at)


def _orders(system: "HybridSystem", way: _Order, time: float) -> list[_Order]:
    """All orders in which events may go on from there."""
    import numpy as np

    met = _met(system, way, time)
    if not met:
        return [way]
    if len(way.events) == TIES.most:
        raise SettingsError(
            f"more than {TIES.most} events follow each other in this instant: {', '.join(way.events)}, .."
        )
    found = []
    for event, (number, surface, normal, speed) in enumerate(met):
        transition = system.transitions[number]
        at = -(normal @ way.matrix) / speed
        others = [-(other @ way.matrix) / pace for k, (_, _, other, pace) in enumerate(met) if k != event]
        rows = [row - at for row in others] + ([] if way.last is None else [at - way.last])
        image, saltation = _formula(system, f"across {number} {way.mode}", number, way.mode)(
            time, *way.state, *system.parameters.values()
        )
        after = _Order(
            transition.target,
            np.array(image, dtype=float),
            np.array(saltation, dtype=float) @ way.matrix,
            (*way.events, transition.name),
            (*way.crossed, surface),
            _distinct((*way.delays, *rows)),
            at,
            way.declared and event == 0,
        )
        found += _orders(system, after, time)
    return found


def _met(system: "HybridSystem", way: _Order, time: float) -> "list[tuple[int, int, np.ndarray, float]]":
    """Transitions that happen in this instant, the declared one first, with surface, gradient and rate of the guard."""
    import numpy as np

    from chaosdrill.codegen.events import mode_events
    from chaosdrill.codegen.formulas import function_of

    values, placed = (time, *way.state, *system.parameters.values()), system.placed
    rates = np.array(
        function_of(system, f"rates {way.mode}", lambda p: [p.modes[way.mode][x] for x in p.states])(*values),
        dtype=float,
    )
    moving = (rates != 0) & (way.state != 0)
    unit = system.forcing_period() or float(np.max(np.abs(way.state[moving] / rates[moving]), initial=0.0)) or 1.0
    found = []
    for event in mode_events(placed, way.mode):
        name, derive = f"guard {event.key}", partial(_guard, guard=event.guard)
        guard, *gradient = function_of(system, name, derive)(*values)
        normal = np.array(gradient[:-1], dtype=float)
        speed = float(normal @ rates + gradient[-1])
        if speed == 0 or abs(guard) > TIES.instant * unit * abs(speed) or speed * event.direction < 0:
            continue
        if event.direction == 0 and event.surface in way.crossed:
            continue
        for number in event.outcomes:
            condition = placed.transitions[number].conditions.get(way.mode)
            name = f"whether {number} {way.mode}"
            if condition is None or function_of(system, name, partial(_as_it_is, condition))(*values):
                found.append((number, event.surface, normal, speed))
                break
    return found


def _as_it_is(expression: Any, placed: "HybridSystem") -> Any:
    return expression


def _guard(placed: "HybridSystem", guard: Any) -> list[Any]:
    from chaosdrill.model.derive import guard_gradient

    return [guard, *guard_gradient(placed, guard)]


def _formula(system: "HybridSystem", name: str, number: int, mode: str) -> Any:
    """Image and saltation matrix of a transition from a mode, as a function of numbers."""
    from chaosdrill.codegen.formulas import function_of

    def derive(placed: "HybridSystem") -> list[Any]:
        from chaosdrill.model.derive import reset_map, saltation

        transition = placed.transitions[number]
        return [reset_map(placed, transition), saltation(placed, transition, mode).tolist()]

    return function_of(system, name, derive)


def _distinct(rows: "Sequence[np.ndarray]") -> "tuple[np.ndarray, ...]":
    """Rows without those that say nothing, and of those that say the same the first."""
    import numpy as np

    kept: list[np.ndarray] = []
    largest = max((float(np.abs(row).max()) for row in rows), default=0.0)
    for row in rows:
        size = float(np.abs(row).max())
        if size <= TIES.same * largest:
            continue
        if all(np.abs(row / size - other / np.abs(other).max()).max() > TIES.same for other in kept):
            kept.append(row)
    return tuple(kept)


def _holds(rows: "Sequence[np.ndarray]") -> bool:
    """Whether the cone on which all rows are positive has an interior."""
    import numpy as np
    from scipy.optimize import linprog

    if not rows:
        return True
    matrix = np.array(rows) / np.abs(rows).max(axis=1, keepdims=True)
    matrix = matrix / np.maximum(np.abs(matrix).max(axis=0), np.finfo(float).tiny)
    n = matrix.shape[1]
    found = linprog(
        np.append(np.zeros(n), -1.0), A_ub=np.column_stack([-matrix, np.ones(len(matrix))]), b_ub=np.zeros(len(matrix)),
        bounds=[*[(-1.0, 1.0)] * n, (None, 1.0)],
    )  # fmt: skip
    return bool(found.x[-1] > TIES.same)


def _multipliers(
    found: "xr.Dataset",
    system: "HybridSystem",
    orders: Sequence[_Order],
    mode: str,
    time: float,
    duration: float,
    state: "np.ndarray",
) -> "xr.Dataset":
    """The dataset with the multipliers of each order on an orbit that is back after this time."""
    import numpy as np

    if not found.attrs["continuous"]:
        raise SettingsError("duration is given, but the orders do not lead to one state and mode")
    came, end, flow, sizes = _round(system, orders[0], time, duration)
    n = len(state)
    if came != mode or not (np.abs(end - state) <= TIES.back * np.maximum(sizes, np.abs(state))).all():
        told = f"{end.tolist()} in mode {came!r}, not back in the one given"
        raise SettingsError(f"after the duration {duration:g} the state is {told}")
    multipliers, inside = np.zeros((len(orders), n), dtype=complex), np.zeros((len(orders), n), dtype=bool)
    for i, one in enumerate(orders):
        values, vectors = np.linalg.eig(flow @ one.matrix)
        order = np.argsort(-np.abs(values), kind="stable")
        multipliers[i] = values[order]
        for k, vector in enumerate(vectors[:, order].T):
            sides = np.reshape(one.delays, (-1, n)) @ vector.real
            inside[i, k] = not vector.imag.any() and bool((sides >= 0).all() or (sides <= 0).all())
    return found.assign(
        multiplier_real=(("order", "multiplier"), multipliers.real, {"long_name": "multiplier, real part"}),
        multiplier_imag=(("order", "multiplier"), multipliers.imag, {"long_name": "multiplier, imaginary part"}),
        multiplier_in_cone=(("order", "multiplier"), inside, {"long_name": "whether its direction keeps the order"}),
    )


def _round(
    system: "HybridSystem", order: _Order, time: float, duration: float
) -> "tuple[str, np.ndarray, np.ndarray, np.ndarray]":
    """Mode and state, (n,), of the motion from an order after this time, its tangent map, (n, n), and sizes of states.

    Events are met up to the middle between the last one before that time and that time itself, from where the mode is
    followed without them: the guards met at its end do not belong to this motion.
    """
    import numpy as np

    from chaosdrill.dataset import Outcome
    from chaosdrill.engine import shooting as at
    from chaosdrill.engine.layout import EVENT_COLUMNS, EVENT_STROBES, EVENT_TIME
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.place import Place
    from chaosdrill.orbits.problem import Problem

    n, problem = len(order.state), Problem(system)
    initial = dict(zip(system.state_names, order.state.tolist(), strict=True))
    place = Place(system.with_initial(**initial, mode=order.mode), time)

    def run(length: float) -> "tuple[Any, np.ndarray]":
        going = place.run(length, problem.numerics, tangents=np.eye(n), orthonormalise=False)
        going.fix_step(length / problem.numerics.steps_a_period)
        events = np.zeros((TIES.most_on_the_way, EVENT_COLUMNS + 2 * n))
        outcome, full = going.advance(1, events=events)
        if outcome != Outcome.OK or full:
            told = outcome.advice if outcome != Outcome.OK else f"it meets more than {TIES.most_on_the_way} events"
            raise SettingsError(f"the motion does not last for the duration {duration:g}: {told}")
        rows = events[: going.filled()[1]]
        return going, rows[:, EVENT_STROBES] * length + rows[:, EVENT_TIME]

    _, times = run(duration)
    last = max((t for t in times.tolist() if t < duration * (1 - TIES.back)), default=0.0)
    begun = (last + duration) / 2
    going, _ = run(begun)
    if not problem.forced:
        problem.set_unit(duration)
    segments = np.array([[system.mode_names.index(going.mode), at.PLANE, 0]])
    rest = Orbit(segments, 1, going.x[np.newaxis].copy(), time + begun, np.array([duration - begun]))
    end = problem.at([rest], np.array([[duration - begun]]))[0][0, 0]
    there = replace(
        rest, segments=np.repeat(segments, 2, axis=0), starts=np.array([going.x, end]),
        durations=np.array([duration - begun, 0.0]),
    )  # fmt: skip
    flow = problem.shoot(there, watched=False).sensitivity[1, :n, :n] @ going.vectors.T
    return going.mode, end, flow, problem.sizes


def _tie_on(system: "HybridSystem", orbit: "xr.Dataset") -> "tuple[Any, str, float, float]":
    """The first state of an orbit in which two events are met in one instant, its mode and time, and the period."""
    import numpy as np

    if not {"event_time", "event_state_before", "period_time"} <= set(orbit) or orbit["event_time"].dims != ("event",):
        raise SettingsError("state is a dataset without events of one orbit; give a result of periodic_orbit")
    times, period = orbit["event_time"].values, float(orbit["period_time"])
    kinds = orbit["event_kind"].values
    gaps = np.abs(np.diff(times)) <= TIES.instant * period
    if not gaps.any():
        raise SettingsError("state is an orbit on which no two events happen in one instant")
    first = int(gaps.argmax())
    mode = system.transitions[int(kinds[first - 1])].target
    return orbit["event_state_before"].values[first], mode, float(times[first]), period


def _state(system: "HybridSystem", given: Any) -> "np.ndarray":
    """The state as numbers in order."""
    import numpy as np

    names = list(system.state_names)
    if isinstance(given, Mapping):
        unknown = [name for name in given if name not in names]
        missing = [name for name in names if name not in given]
        if unknown or missing:
            told = f"has no state {unknown[0]!r}" if unknown else f"leaves out {missing[0]!r}"
            raise SettingsError(f"state {told}; expected numbers for {names}")
        given = [given[name] for name in names]
    try:
        state = np.array([real(one) for one in given])
    except TypeError:
        raise SettingsError(f"state is {shown(given):.60}; expected numbers for {names}") from None
    if state.shape != (len(names),) or not np.isfinite(state).all():
        raise SettingsError(f"state is {shown(given):.60}; expected {len(names)} finite numbers, for {names}")
    return state
