"""What the orbits of a branch shrink onto: a Hopf point, a centre, or a point where an event has no speed."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.codegen.layout import UNIT
from chaosdrill.dataset.branches import Criticality, Special
from chaosdrill.engine import shooting as at
from chaosdrill.engine.layout import DONE
from chaosdrill.orbits.curve import shares_of
from chaosdrill.orbits.points import Point
from chaosdrill.orbits.results import NO_FORM, NormalForm
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.equilibrium.curve import Curve as Equilibria
    from chaosdrill.equilibrium.points import Equilibrium
    from chaosdrill.orbits.curve import Curve


@dataclass(frozen=True)
class Rest:
    """Where a branch ends on an equilibrium."""

    value: float  # of the parameter
    error: float
    text: str
    point: Point | None = None  # the orbit of no extent, at a Hopf point
    form: NormalForm = NO_FORM


def rounds(curve: "Curve", points: list[Point]) -> np.ndarray:
    """States along orbits of one segment at equal parts of their periods, shape (P, 32, d)."""
    ends = np.array([p.orbit.durations.sum() for p in points])[:, np.newaxis]
    found: np.ndarray = curve.problem.at([p.orbit for p in points], ends * np.linspace(0, 1, 33)[:-1])[0]
    return found


def shrinks(curve: "Curve", before: Point, last: Point, reach: float) -> bool:
    """Whether orbits shrink onto an equilibrium within ``reach``, a part of the parameter's range.

    Squares of amplitudes go to zero as the distance from a Hopf point, or as a power of it where the pair crosses with
    no speed. Planes across the flow need not contain the equilibrium, so that orbits, while they shrink, leave each of
    them long before they are points.
    """
    spreads = (rounds(curve, [before, last]) / curve.problem.sizes).var(axis=1)
    wide, small = (float(one.sum()) for one in spreads)
    values = [float(curve.values(p.orbit)[0]) for p in (before, last)]
    if not small < wide or values[0] == values[1]:
        return False
    left = (values[1] - values[0]) * small / (wide - small)
    if abs(left) > reach * float(curve.spans[0]):
        return False
    rest = rest_behind(curve, last)
    if rest is None:
        return False
    (low, high), left = curve.limits[0], rest.value - values[1]
    if rest.point is None and (not low <= rest.value <= high or abs(left) > TUNING.beside_centre * (high - low)):
        return False
    away = left / (values[1] - values[0])
    if not away > 0:
        return False
    power = np.log(wide / small) / np.log1p(1 / away)
    return bool(abs(power - max(round(power), 1)) <= TUNING.same_power)


def collapsed(curve: "Curve", points: Sequence[Point], home: Point) -> bool:
    """Whether orbits have shrunk onto a point where an event has no speed, within the range of the parameter.

    Their durations vanish there. On shorter ones rounding hides the parameter, and with it the branch.
    """
    lasting = [float(p.orbit.durations.sum()) for p in (home, *points[-3:])]
    shorter = len(points) > 2 and lasting[1] > lasting[2] > lasting[3]
    planar = points[-1].orbit.segments[0, at.SEGMENT_END] == at.PLANE
    if planar or not shorter or lasting[-1] > TUNING.collapsed * lasting[0]:
        return False
    value, _ = _at_no_duration(curve, points)
    (low, high), near = curve.limits[0], TUNING.same_limit * float(curve.spans[0])
    return bool(low - near <= value <= high + near)


def _at_no_duration(curve: "Curve", points: Sequence[Point]) -> tuple[float, float]:
    """The parameter where durations vanish, and its error: through orbits that last ever twice as long."""
    lasting = np.array([p.orbit.durations.sum() for p in points])
    nodes = np.unique([max(np.flatnonzero(lasting >= many * lasting[-1]), default=0) for many in (8, 4, 2, 1)])
    values = np.array([curve.values(points[k].orbit)[0] for k in nodes])
    shares, fewer = (shares_of(lasting[nodes[k:]], 0.0, 0) for k in (0, 1))
    value, rounding = float(shares @ values), UNIT * lasting.max() / lasting[-1]
    return value, float(abs(value - fewer @ values[1:]) + rounding * (np.abs(shares) @ np.abs(values)))


def point_behind(curve: "Curve", points: Sequence[Point]) -> Rest:
    """The point that orbits have shrunk to, as `collapsed` tells."""
    problem, last = curve.problem, points[-1].orbit
    value, error = _at_no_duration(curve, points)
    names = problem.plain.state_names
    states = ", ".join(f"{x} = {v:.6g}" for x, v in zip(names, last.starts[0, : problem.states], strict=True))
    events = " and ".join(dict.fromkeys(last.events(problem.plain)))
    return Rest(value, error, f"it shrinks onto a point at rest where {events} has no speed, near {states}")


def rest_behind(curve: "Curve", last: Point) -> Rest | None:
    """The Hopf point that an orbit has shrunk to, or the centre of its family; None where there is none near by."""
    return _hopf_behind(curve, last) or _centre_behind(curve, last)


def _centre_behind(curve: "Curve", last: Point) -> Rest | None:
    """The equilibrium that a family shrinks to, in a system that is drawn to a level, where its term has no value."""
    import sympy

    from chaosdrill.equilibrium.fields import NoFieldError, field_of
    from chaosdrill.equilibrium.points import equilibrium, polished
    from chaosdrill.model.levels import undrawn, value_at
    from chaosdrill.model.places import parameter

    problem, orbit, name = curve.problem, last.orbit, curve.problem.free[0]
    mode = problem.plain.mode_names[orbit.segments[0, at.SEGMENT_MODE]]
    found = undrawn(problem.plain, mode, name)
    if found is None:
        return None
    system, conserved = found
    parameters = {**system.parameters, name: float(curve.values(orbit)[0])}
    try:
        field = field_of(system, mode)
        zero = polished(field, field.numbers(rounds(curve, [last])[0].mean(axis=0), list(parameters.values())))
    except NoFieldError:
        return None
    if zero is None:
        return None
    one, omega = equilibrium(field, zero), 2 * np.pi / float(orbit.durations.sum())
    if np.abs(one.spectrum.values - 1j * omega).min() > TUNING.same_frequency * omega:
        return None
    place = {parameter(key): value for key, value in parameters.items()}
    place |= dict(zip(system.states, map(float, one.states), strict=True))
    value = value_at(conserved, place).real
    states = ", ".join(f"{x} = {v:.9g}" for x, v in zip(system.state_names, one.states, strict=True))
    # the quantity is stationary at the equilibrium
    error = UNIT * (abs(value) + sum(abs(value_at(term, place)) for term in sympy.Add.make_args(conserved)))
    return Rest(value, error, f"it shrinks onto the equilibrium {states}: a centre of mode {mode!r}")


def _hopf_behind(curve: "Curve", last: Point) -> Rest | None:
    from chaosdrill.equilibrium.curve import Curve as Equilibria
    from chaosdrill.equilibrium.curve import LostError
    from chaosdrill.equilibrium.fields import NoFieldError, field_of
    from chaosdrill.equilibrium.forms import hopf_form

    problem, orbit = curve.problem, last.orbit
    system = problem.plain
    mode = system.mode_names[orbit.segments[0, at.SEGMENT_MODE]]
    duration = float(orbit.durations.sum())
    middle = rounds(curve, [last])[0].mean(axis=0)
    value, span = float(curve.values(orbit)[0]), float(curve.spans[0])
    try:
        field = field_of(system, mode)
        which = list(system.parameters).index(problem.free[0])
        bounds = np.tile([-np.inf, np.inf], (problem.states, 1))
        sizes = problem.sizes[list(field.free)]
        rests = Equilibria(field, which, (value - span, value + span), sizes, bounds, TUNING.first_step)
        numbers = field.numbers(middle, list(system.parameters.values()))
        numbers[rests.places[-1]] = value
        found = _hopf(rests, numbers, 2 * np.pi / duration)
        if found is None:
            return None
        one, omega, error = found
        point = rests.first(one)
        step = TUNING.beside_special * TUNING.first_step
        before, after = (rests.after(way, step) for way in (point.turned(), point))
        form = hopf_form(rests, before, point, after, omega, error)
    except (NoFieldError, LostError):
        return None
    kind = form.criticality
    told = "" if kind == Criticality.UNDECIDED else f"a {kind.meaning} "
    states = ", ".join(f"{name} = {x:.9g}" for name, x in zip(system.state_names, one.states, strict=True))
    text = f"it shrinks onto the equilibrium {states}: {told}Hopf point of mode {mode!r}"
    end = _still(curve, last, one, rests.value(one), 2 * np.pi / omega)
    return None if end is None else Rest(rests.value(one), error, text, end, replace(NO_FORM, criticality=kind))


def _hopf(rests: "Equilibria", numbers: np.ndarray, omega: float) -> "tuple[Equilibrium, float, float] | None":
    """The equilibrium where a pair crosses the imaginary axis, its frequency, and the error of the parameter."""
    from chaosdrill.equilibrium.curve import LostError
    from chaosdrill.equilibrium.points import equilibrium, polished, undecided

    place = rests.places[-1]

    def at_value(value: float, near: np.ndarray) -> "tuple[Equilibrium, complex, float] | None":
        there = near.copy()
        there[place] = value
        zero = polished(rests.field, there)
        if zero is None:
            return None
        one = equilibrium(rests.field, zero)
        k = int(np.abs(one.spectrum.values - 1j * omega).argmin())
        return one, complex(one.spectrum.values[k]), float(one.spectrum.errors[k])

    span = rests.limits[1] - rests.limits[0]
    first = at_value(float(numbers[place]), numbers)
    beside = None if first is None else at_value(float(numbers[place]) + TUNING.beside_special * span, numbers)
    for _ in range(TUNING.newton_steps):
        if first is None or beside is None:
            return None
        (one, pair, error), (other, next_, _) = first, beside
        slope = (next_.real - pair.real) / (rests.value(other) - rests.value(one))
        if slope == 0 or abs(pair.imag - omega) > TUNING.same_frequency * omega:
            return None
        if abs(pair.real) <= error:

            def there(value: float, near: np.ndarray = one.numbers) -> tuple[float, float, float]:
                found = at_value(value, near)
                if found is None:
                    raise LostError("the equilibrium ends beside its Hopf point")
                return value, found[1].real, found[2]

            zero = rests.value(one)
            off = max(abs(value - zero) for value in undecided(there, zero, rests.limits))
            return one, pair.imag, off + UNIT * abs(zero)
        value = rests.value(one) - pair.real / slope
        if not rests.limits[0] <= value <= rests.limits[1] or value == rests.value(one):
            return None
        first, beside = at_value(value, one.numbers), first
    return None


def _still(curve: "Curve", last: Point, one: "Equilibrium", value: float, period: float) -> Point | None:
    """The orbit of no extent as the last point of a branch."""
    orbit, d = last.orbit, curve.problem.states
    starts = orbit.starts.copy()
    starts[0, :d], starts[0, d:] = one.states, value
    end = replace(orbit, starts=starts, durations=np.array([period]))
    shot = curve.problem.shoot(end, False, last.section)
    if shot.outcome != DONE or not np.isfinite(shot.monodromy).all():
        return None
    length = curve.gap(orbit, end, last.weights)
    return replace(last, orbit=end, shot=shot.bare(), arclength=last.arclength + length, special=Special.HOPF)
