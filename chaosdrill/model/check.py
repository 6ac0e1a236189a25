"""What makes a system impossible to compile, said before anything is compiled."""

import random
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import sympy

from chaosdrill.declared import unfit
from chaosdrill.errors import ModelError
from chaosdrill.model.derive import frozen_states
from chaosdrill.model.reading import NAMES, is_name
from chaosdrill.model.special import SPECIAL
from chaosdrill.model.text import has_doubles
from chaosdrill.names import remedy

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem

MOST_CODES = 127


class PlacedError(ModelError):
    """What is wrong with a system, and the keys of its definition that are at fault.

    Parameters
    ----------
    message : str
        What is wrong.
    place : tuple of str
        As ``("quadratures", "work")``.
    """

    def __init__(self, message: str, place: tuple[str, ...] = ()) -> None:
        super().__init__(message)
        self.place = place


def check_system(system: "HybridSystem") -> None:
    """Raise ModelError with the reason if the system cannot be compiled."""
    names = [*system.state_names, *system.parameters, *system.quadratures]
    if system.time is not None:
        names.append(system.time.name)
    for name in names:
        if names.count(name) > 1:
            raise ModelError(f"{system.name}: {name!r} is named twice among states, parameters, quadratures and time")
    _check_names(system)
    if not system.states:
        raise ModelError(f"{system.name}: there is no state")
    if not system.modes:
        raise ModelError(f"{system.name}: there is no mode")
    known = {sympy.Symbol(p, real=True) for p in system.parameters}
    if system.period is not None:
        _symbols(system, "period", system.period, known, "parameters")
    known = known | set(system.states) | ({system.time} if system.time is not None else set())
    for what, count in (("modes", len(system.modes)), ("transitions", len(system.transitions))):
        if count > MOST_CODES:
            raise ModelError(
                f"{system.name}: there are {count} {what}; at most {MOST_CODES} fit, since archives hold their codes "
                "in one byte"
            )
    for mode, field in system.modes.items():
        for state in system.states:
            if state not in field:
                raise ModelError(f"{system.name}: mode {mode!r} gives no derivative for state {state.name!r}")
        for state, rate in field.items():
            if state not in system.states:
                raise ModelError(f"{system.name}: mode {mode!r} gives a derivative for {state}, which is no state")
            _symbols(system, f"mode {mode!r}, d{state}/dt", rate, known)
    for name, integrand in system.quadratures.items():
        _symbols(system, f"quadrature {name!r}", integrand, known)
    for transition in system.transitions:
        if [t.name for t in system.transitions].count(transition.name) > 1:
            raise ModelError(f"{system.name}: two transitions are named {transition.name!r}; every name may stand once")
        _check_transition(system, transition, known)
    _check_outcomes(system)
    if system.period is not None:
        period = value_of(system.period, system.parameters)
        if not 0 < period < float("inf"):
            named = {p.name: system.parameters[p.name] for p in system.period.free_symbols}
            raise PlacedError(
                f"{system.name}: the period {system.period} is not a positive number"
                + (f" at {named}" if named else "")
                + "; leave it out if nothing depends on time",
                ("period",),
            )
        if system.time is not None:
            _check_periodic(system, system.period, period)


def value_of(expression: Any, parameters: Mapping[str, float]) -> float:
    """The number that an expression of parameters has; NaN if it is none."""
    try:
        return float(expression.subs({p: parameters[p.name] for p in expression.free_symbols}))
    except (TypeError, OverflowError):
        return float("nan")


def _check_names(system: "HybridSystem") -> None:
    for what, names in (
        ("state", system.state_names),
        ("parameter", system.parameters),
        ("quadrature", system.quadratures),
    ):
        for name in names:
            if not is_name(name):
                raise ModelError(f"{system.name}: {what} is named {name!r:.60}; {NAMES}")
    if "mode" in system.state_names:
        raise ModelError(f"{system.name}: a state is named 'mode', which is reserved for the initial mode; rename it")
    for name in system.quadratures:
        if reason := unfit(name):
            raise PlacedError(
                f"{system.name}: quadrature {name!r:.60} has a name that {reason}; rename it, as in 'the_integral'",
                ("quadratures", name),
            )
    labelled = [*system.state_names, *system.parameters, *system.quadratures]
    labelled += [] if system.time is None else [system.time.name]
    for name in system.labels:
        if name not in labelled:
            raise PlacedError(
                f"{system.name}: a label is given to {name!r:.60}, which is no state, parameter, quadrature or time; "
                + remedy(str(name), labelled),
                ("labels", name),
            )


def _check_transition(system: "HybridSystem", transition: Any, known: set[Any]) -> None:
    where = f"transition {transition.name!r}"
    for mode in (*transition.source, transition.target):
        if mode not in system.modes:
            raise ModelError(f"{system.name}: {where} names mode {mode!r}; modes are {list(system.modes)}")
    _symbols(system, f"{where}, guard", transition.guard, known)
    moving = set(system.states) | {system.time}
    if not transition.guard.free_symbols & moving:
        raise ModelError(f"{system.name}: {where}: the guard {transition.guard} depends on no state and not on time")
    for state, value in transition.reset.items():
        if state not in system.states:
            raise ModelError(
                f"{system.name}: {where} resets {state}, which is no state; states are {system.state_names}"
            )
        _symbols(system, f"{where}, reset of {state}", value, known)
    if transition.condition is not None:
        if not isinstance(transition.condition, (sympy.logic.boolalg.Boolean, bool)):
            raise ModelError(f"{system.name}: {where}: condition {transition.condition} is no relation such as v > 1")
        _symbols(system, f"{where}, condition", transition.condition, known)
    if transition.completes is not None:
        _check_completes(system, transition)


def _check_outcomes(system: "HybridSystem") -> None:
    """Every outcome of an event must be one that can be taken."""
    first: dict[tuple[str, Any, int], str] = {}
    hidden: dict[int, list[str]] = {}
    for i, transition in enumerate(system.transitions):
        # one that completes another is taken in its place, wherever it stands
        if transition.completes is not None:
            continue
        for mode in transition.source:
            event = mode, transition.guard, transition.direction
            if event in first:
                hidden.setdefault(i, []).append(first[event])
            elif transition.condition is None:
                first[event] = transition.name
    for i, before in hidden.items():
        transition = system.transitions[i]
        if len(before) == len(transition.source):
            raise PlacedError(
                f"{system.name}: transition {transition.name!r} is never taken, since {before[0]!r} is another outcome "
                f"of the same event, stands before it and has no condition; give {before[0]!r} a condition, or put it "
                "last",
                ("transitions", transition.name),
            )


def _check_completes(system: "HybridSystem", transition: Any) -> None:
    where = f"{system.name}: transition {transition.name!r} completes {transition.completes!r}"
    found = [t for t in system.transitions if t.name == transition.completes]
    if not found:
        raise ModelError(f"{where}, which is no transition; there are {[t.name for t in system.transitions]}")
    rebound = found[0]
    rivals = [t for t in system.transitions if t.completes == transition.completes and t is not transition]
    if any(set(t.source) & set(transition.source) for t in rivals) or rebound.completes is not None:
        raise ModelError(f"{where}: one transition completes a rebound, and is none itself; leave one out")
    if (rebound.guard, rebound.direction) != (transition.guard, transition.direction) or rebound.direction == 0:
        raise ModelError(f"{where}: both must have the same guard and the same direction, +1 or -1")
    if not set(transition.source) <= set(rebound.source):
        raise ModelError(f"{where}: that one must start from the mode {transition.source[0]!r} too")
    if transition.target in transition.source:
        raise ModelError(f"{where}: its target must be another mode, one that holds the contact")


def _symbols(system: "HybridSystem", where: str, expression: Any, known: set[Any], what: str = "") -> None:
    unknown = sorted(s.name for s in expression.free_symbols - known)
    if unknown:
        allowed = what or "states, parameters and time"
        names = sorted(s.name for s in known)
        raise ModelError(f"{system.name}: {where}: unknown symbol {unknown[0]!r}; allowed are {allowed}: {names}")
    if expression.has(sympy.zoo, sympy.nan, sympy.oo):
        raise ModelError(f"{system.name}: {where}: {expression} is not finite")
    if not has_doubles(expression):
        raise ModelError(f"{system.name}: {where} holds a number that is larger than any double")


def _check_periodic(system: "HybridSystem", declared: Any, period: float) -> None:
    """The declared period must be a period of every expression that names time.

    One that also names a state which never changes (a parameter among the states) is left to the run, which knows it.
    """
    frozen = set(frozen_states(system))
    rng = random.Random(1)
    expressions = [f for field in system.modes.values() for f in field.values()]
    expressions += system.quadratures.values()
    for transition in system.transitions:
        expressions += [transition.guard, *transition.reset.values()]
        if transition.condition is not None:
            relations = transition.condition.atoms(sympy.core.relational.Relational)
            expressions += [relation.lhs - relation.rhs for relation in relations]
    values = {sympy.Symbol(p, real=True): v for p, v in system.parameters.items()}
    for expression in expressions:
        if system.time not in expression.free_symbols or frozen & expression.free_symbols:
            continue
        # a special function repeats if its arguments do, and has no value in sympy
        expression = expression.replace(
            lambda part: type(part).__name__ in SPECIAL,
            lambda part: sum((place + 2) * argument for place, argument in enumerate(part.args)),
        )
        here = {**values, **{s: rng.uniform(0.1, 0.9) for s in system.states}}
        instant = rng.uniform(0, period)
        try:
            before, after = (
                complex(expression.subs({**here, system.time: u}).evalf()) for u in (instant, instant + period)
            )
        except OverflowError:
            # no doubles there; a run looks again, at more places
            continue
        if abs(after - before) > 1e-9 * (1 + abs(before)):
            raise PlacedError(
                f"{system.name}: {expression} does not repeat after the declared period {declared} = {period:.6g}; "
                "mend the period or leave it out",
                ("period",),
            )
