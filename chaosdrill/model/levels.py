"""A conservative system whose conserved quantity is a parameter: families of orbits become branches over it."""

import math
from collections.abc import Mapping
from typing import Any

import sympy

from chaosdrill.errors import ModelError
from chaosdrill.model.crossings import crossings
from chaosdrill.model.derive import image_of, rate_by_states
from chaosdrill.model.held import Trial, kept_apart
from chaosdrill.model.parts import is_name, read_of_states, read_table
from chaosdrill.model.places import parameter
from chaosdrill.model.system import SYSTEM, HybridSystem
from chaosdrill.model.tuning import TUNING
from chaosdrill.names import remedy, shown
from chaosdrill.typed import NUMBER, TEXT, expecting


@expecting(ModelError, system=SYSTEM, name=TEXT, rate=NUMBER)
def on_level(system: "HybridSystem", conserved: Any, *, name: str = "level", rate: float = 1.0) -> "HybridSystem":
    """The system drawn to a level of a quantity H that it conserves; the level is one of its parameters.

    In a conservative system every periodic orbit is one of a family at the same parameters. Here the term
    ``rate*(level - H) W grad H / (grad H . W grad H)`` is added to the rates, so that H decays to the level as
    ``exp(-rate*t)``; W holds squares of the sizes of the states, as H shows them at the initial state. An orbit can
    close only where H is the level; there the term is zero, and the orbit is one of the system. So `continue_orbit`
    follows the family over the level as any other branch, with its folds, doublings and crossings. Of the multipliers
    one that was 1 is ``exp(-rate*T)`` after a period T; the others are those of the system.

    Parameters
    ----------
    system : HybridSystem
        A system without forcing. It is not changed.
    conserved : expression, or mapping of mode to expression
        The quantity, in states and parameters: of all modes, or of each one. That rates and resets conserve it is
        checked.
    name : str
        Name of the parameter. Its value is that of the initial state.
    rate : float
        Positive, in 1 / time; about the inverse of a period.

    Returns
    -------
    HybridSystem
        `with_initial` does not change its level.

    Raises
    ------
    ModelError
        If the quantity is not conserved: which mode or transition changes it.

    References
    ----------
    F. J. Munoz-Almaraz, E. Freire, J. Galan, E. Doedel, A. Vanderbauwhede, "Continuation of periodic orbits in
    conservative and Hamiltonian systems", Physica D 181 (2003) 1-38, doi:10.1016/S0167-2789(03)00097-6: the gradient
    as the term that unfolds a family.
    """
    system = system.built
    if system.discrete or not system.autonomous:
        what = "is a map" if system.discrete else "depends on time"
        raise ModelError(f"{system.name} {what}: it has no levels; give a system without forcing")
    if system.noise or system.sources:
        what = "is noisy" if system.noise else "has Python functions"
        raise ModelError(f"{system.name} {what}: that it conserves a quantity is checked in expressions without noise")
    taken = {*system.parameters, *system.state_names, *system.quadratures}
    if not is_name(name) or name in taken:
        raise ModelError(f"name is {shown(name):.60}; give a name that nothing in {system.name} has")
    if not 0 < rate < math.inf:
        raise ModelError(f"rate is {rate!r}; it must be positive and finite")
    given = _read(system, conserved)
    _check(system, given)
    start = {x: system.initial[x.name] for x in system.states}
    here = {**start, **{parameter(key): value for key, value in system.parameters.items()}}
    begun = value_at(given[system.initial["mode"]], here)
    if begun.imag or not math.isfinite(begun.real):
        told = f"in the initial state it is {begun:.6g}, not a number; begin where it has a value"
        raise ModelError(f"{system.name}: conserved: {told}")
    level, weights, modes = parameter(name), _weights(system, given, here, abs(begun)), {}
    for mode, rates in system.modes.items():
        slopes = {x: sympy.diff(given[mode], x) for x in system.states}
        pull = rate * (level - given[mode]) / sum(weights[x] * slope**2 for x, slope in slopes.items())
        modes[mode] = {
            x: rates[x] + weights[x] * pull * slopes[x] if slopes[x] != 0 else rates[x] for x in system.states
        }
    found = system.remade(
        name=f"{system.name} on a level",
        parameters={**system.parameters, name: begun.real},
        modes=modes,
        period=None,
        initial=system.initial,
    )
    return found.limited(system.limits)


def _weights(system: "HybridSystem", given: Mapping[str, Any], here: Mapping[Any, Any], size: float) -> dict[Any, Any]:
    """Squares of the sizes of states relative to that of the first, as powers of two: units turn no gradient."""

    def largest(x: Any, order: int) -> float:
        values = [abs(value_at(sympy.diff(one, x, order), here)) for one in given.values()]
        return max(filter(math.isfinite, values), default=0.0)

    slopes, bends = ({x: largest(x, order) for x in system.states} for order in (1, 2))
    size = max([slopes[x] ** 2 / bends[x] for x in system.states if bends[x]], default=size) or 1.0
    found = [1 / bends[x] if bends[x] else size / slopes[x] ** 2 if slopes[x] else 1.0 for x in system.states]
    powers = [round(max(-1000.0, min(math.log2(one / found[0]), 1000.0))) for one in found]
    return {
        x: sympy.Float(2.0**power) if power else sympy.Integer(1)
        for x, power in zip(system.states, powers, strict=True)
    }


def value_at(expression: Any, point: Mapping[Any, Any]) -> complex:
    """Value of an expression where its symbols have these values, NaN where it has none."""
    try:
        return complex(sympy.sympify(expression.xreplace(point)).evalf(TUNING.digits))
    except (TypeError, ValueError, ArithmeticError):
        return complex("nan")


def undrawn(system: "HybridSystem", mode: str, name: str) -> "tuple[HybridSystem, Any] | None":
    """The system with the rates of a mode as they were before `on_level`, and the quantity; None if it is not drawn."""
    from chaosdrill.model.system import HybridSystem

    level = parameter(name)
    parts = {x: sympy.sympify(rate).as_independent(level, as_Add=True) for x, rate in system.modes[mode].items()}
    pulls = {x: pull for x, (_, pull) in parts.items() if pull != 0}
    if not pulls or system.sources:
        return None
    rates, (x, pull) = {y: own for y, (own, _) in parts.items()}, next(iter(pulls.items()))
    conserved = level - pull / sympy.diff(pull, level)
    slopes = {y: sympy.diff(conserved, y) for y in pulls}
    if conserved.has(level) or not slopes[x]:
        return None
    # the term moves the quantity at the same rate everywhere: at its equilibria it has no value
    pace, trial = sum(sympy.diff(one, level) * slopes[y] for y, one in pulls.items()), Trial(system, near=True)
    moved = (sympy.diff(pace, x) for x in (*system.states, *map(parameter, system.parameters)))
    if not all(trial.zero(one, ()) for one in (kept_apart(slopes[y] * rates[y] for y in pulls), *moved)):
        return None
    plain = HybridSystem(
        name=system.name,
        states=system.states,
        time=system.time,
        parameters=system.parameters,
        modes={mode: rates},
        initial={**system.initial, "mode": mode},
    )
    return plain, conserved


def _read(system: "HybridSystem", conserved: Any) -> dict[str, Any]:
    """The quantity in every mode."""
    where = f"{system.name}: conserved"
    given = dict.fromkeys(system.modes, conserved)
    if isinstance(conserved, Mapping):
        given = read_table(where, conserved)
        if strange := [mode for mode in given if mode not in system.modes]:
            raise ModelError(f"{where}: unknown mode {strange[0]!r:.60}; {remedy(strange[0], system.modes)}")
        if missing := [mode for mode in system.modes if mode not in given]:
            raise ModelError(f"{where}: mode {missing[0]!r:.60} is missing; give the quantity in every mode")
    found = {mode: read_of_states(f"{where}: {mode}", one, system) for mode, one in given.items()}
    for mode, one in found.items():
        if not one.free_symbols & set(system.states):
            raise ModelError(f"{where}: in mode {mode!r:.60} it is {one!s:.60}, which holds no state")
    return found


def _check(system: "HybridSystem", given: Mapping[str, Any]) -> None:
    """Refuse a quantity that a mode or a transition changes, as numbers at random places tell."""
    trial = Trial(system, near=True)

    def refuse_unless_kept(change: Any, surface: tuple[Any, ...], what: str, remedy: str) -> None:
        if trial.zero(change, surface):
            return
        if not trial.has_values(change, surface):
            remedy = "has no value at states of sizes from 0.1 to 1.5 and others drawn at random; rescale the states"
        else:
            remedy = f"changes it; {remedy}"
        raise ModelError(f"{system.name}: conserved: {what} {remedy}")

    for mode, one in given.items():
        change = kept_apart(rate_by_states(system, mode, one))
        refuse_unless_kept(change, (), f"mode {mode!r:.60}", "it is no conserved quantity")
    surfaces = [(surface,) for surface, _ in crossings(system.transitions)]
    for t, surface in zip(system.transitions, surfaces, strict=True):
        if t.marks_only():
            continue
        if trial.points(surface)[1].shape[1] < TUNING.fewest_samples:
            told = f"no state on the guard of {t.name!r:.60} was found, where it is to be the same after the reset"
            raise ModelError(f"{system.name}: conserved: {told}; write the guard so that it is near a straight line")
        after = given[t.target].xreplace(image_of(system, t))
        for source in t.source:
            change = kept_apart([after, -given[source]])
            refuse_unless_kept(change, surface, f"transition {t.name!r:.60}", "its reset must not")
