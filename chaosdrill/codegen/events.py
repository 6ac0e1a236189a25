"""Events of each mode of a system."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy

from chaosdrill.codegen.layout import Watched
from chaosdrill.codegen.steep import steep_operations
from chaosdrill.model.crossings import INCREASING, Crossing, crossings, sign_of
from chaosdrill.model.derive import differentiate, guard_gradient, rate, rate_by_states
from chaosdrill.model.held import Trial, kept_apart
from chaosdrill.model.python import opaque
from chaosdrill.model.special import SPECIAL
from chaosdrill.model.touching import exact
from chaosdrill.model.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem

_FINITE = (
    *(sympy.Add, sympy.Mul, sympy.Pow, sympy.exp, sympy.sin, sympy.cos),
    *(sympy.sinh, sympy.cosh, sympy.tanh, sympy.atan, sympy.asinh, sympy.erf),
)
"""Operations that make finite values of finite ones, but for powers."""


@dataclass(frozen=True)
class Event:
    """A surface that one mode watches, as `Watched`, and the expression of it."""

    guard: Any
    """What is zero on it, whatever the way in which guards are written"""
    direction: int
    outcomes: tuple[int, ...]
    affine: bool
    steep: bool
    timed: bool
    still: bool
    key: int
    surface: int

    def watched(self) -> Watched:
        """All of it but its guard."""
        return Watched(*(getattr(self, name) for name in Watched._fields))


def mode_events(system: "HybridSystem", mode: str) -> tuple[Event, ...]:
    """The events that a mode watches, larger priority first, then in order of declaration."""
    groups: dict[Crossing, list[int]] = {}
    for index, crossing in enumerate(crossings(system.transitions)):
        if mode in system.transitions[index].source:
            groups.setdefault(crossing, []).append(index)
    moving = {*system.states, system.time}
    keys, trial = guard_keys(system), Trial(system)
    surfaces = list(dict.fromkeys(surface for surface, _ in keys))
    events = [
        Event(
            guard,
            direction,
            tuple(found),
            affine=not any(g.free_symbols & moving for g in guard_gradient(system, guard)),
            still=(still := _is_still(system, mode, guard, trial)),
            steep=not still and bool(steep_operations([guard], moving)),
            timed=not guard.free_symbols & set(system.states),
            key=keys.index(Crossing(guard, direction)),
            surface=surfaces.index(guard),
        )
        for (guard, direction), found in groups.items()
    ]
    return tuple(sorted(events, key=lambda e: -max(system.transitions[i].priority for i in e.outcomes)))


def _is_still(system: "HybridSystem", mode: str, guard: Any, trial: Trial) -> bool:
    """Whether no motion of a mode leads a guard to zero: all of them keep its value or its sign, or it has no zero."""
    if sign_of(guard):
        return True
    terms = [term for along in rate_by_states(system, mode, guard) for term in sympy.Add.make_args(along)]
    total = sympy.Add(*terms)
    # one term alone cancels with nothing
    if total == 0 or (len(terms) > 1 and trial.zero(kept_apart(terms), ())):
        return True
    return _keeps_sign(guard, total, {*system.states, system.time}, trial)


def _keeps_sign(guard: Any, slope: Any, moving: set[Any], trial: Trial) -> bool:
    """Whether the rate of a guard is the guard times a factor that has no pole: then no motion leads to zero.

    To a pole of it, as in ``x' = -sqrt(x)``, motions lead in finite time. Where a symbol enters the guard linearly, and
    the rate is zero where the guard is, the factor is a mean of the rate's derivatives by it.
    """
    guard, slope = exact(guard), exact(slope)
    by = {x: differentiate(guard, x) for x in sorted(guard.free_symbols & moving, key=str)}
    linear = {x: guard / factor for x, factor in by.items() if not factor.free_symbols & moving}
    # a rate free of such a symbol cannot depend on the guard
    if not slope.free_symbols >= linear.keys() or opaque(slope) or not trial.zero(slope, (guard,)):
        return False
    try:
        if linear:
            zero = any(sympy.cancel(slope.xreplace({x: x - off})) == 0 for x, off in linear.items())
            return zero and any(_is_finite(differentiate(slope, x), moving) for x in linear)
        above, below = sympy.fraction(sympy.cancel(slope / guard))
    except sympy.PolynomialError:
        return False
    whole = sign_of(below) != 0 or not below.free_symbols & moving
    return whole and _is_finite(above, moving) and _is_finite(below, moving)


def _is_finite(e: Any, moving: set[Any]) -> bool:
    """Whether an expression has a finite value wherever what moves has one."""
    if not e.free_symbols & moving or e in moving:
        return True
    if e.is_Pow and e.base.free_symbols & moving:
        known = e.exp.is_positive if e.exp.is_number else False
        return bool(known or sign_of(e.base)) and _is_finite(e.base, moving) and _is_finite(e.exp, moving)
    return isinstance(e, _FINITE) and all(_is_finite(a, moving) for a in e.args)


def guard_keys(system: "HybridSystem") -> list[Crossing]:
    """The surfaces of a system's guards with the ways in which they are crossed, each once."""
    return list(dict.fromkeys(crossings(system.transitions)))


def returns(system: "HybridSystem", events: Sequence[Sequence[Event]]) -> list[list[int]]:
    """Where what a transition throws off its surface meets that again: guards of its target mode, -1 for none.

    Two for each transition: the guard that is met from above the surface, and the one that is met from below.
    """
    modes, known, found = list(system.modes), _series(system), []
    for k, transition in enumerate(system.transitions):
        senses = known.get(k, {})
        there = [(j, e) for j, e in enumerate(events[modes.index(transition.target)]) if e.guard in senses]
        ways = ([j for j, e in there if e.direction in (0, way * senses[e.guard])] for way in (-1, 1))
        found.append([next(iter(way), -1) for way in ways])
    return found


def in_series(system: "HybridSystem") -> set[int]:
    """Transitions that may be one of a series of rebounds, all on one surface, that another one completes."""
    return set(_series(system))


def _series(system: "HybridSystem") -> dict[int, dict[Any, int]]:
    """The guards that transitions in series of rebounds may meet next, with the sense in which each grows: 1 or -1.

    Guards are those that the target mode watches on the surface of the transition, however they are written.
    """
    surfaces = [surface for surface, _ in crossings(system.transitions)]
    usual = {k: t for k, t in enumerate(system.transitions) if t.completes is None and not t.marks_only()}
    completed = {t.completes for t in system.transitions}
    trial = Trial(system)
    found: dict[int, dict[Any, int]] = {}
    waiting = [k for k, t in usual.items() if t.name in completed]
    while waiting:
        k = waiting.pop()
        target = system.transitions[k].target
        there = {i: surfaces[i] for i, t in usual.items() if target in t.source}
        senses = {other: _sense(system, trial, target, surfaces[k], other) for other in dict.fromkeys(there.values())}
        found[k] = {other: sense for other, sense in senses.items() if sense}
        waiting += [i for i, other in there.items() if other in found[k] and i not in found and i not in waiting]
    return found


def _sense(system: "HybridSystem", trial: Trial, mode: str, surface: Any, other: Any) -> int:
    """Whether a guard vanishes with a surface and grows with it (1) or against it (-1); 0 if it does neither.

    Either may vanish elsewhere, too, as tan(x) beside x. The last of a series of rebounds are slow: gradients are
    compared where both are zero and do not move in the mode.
    """
    if other == surface:
        return 1
    if trial.zero(other, (surface,)):
        where = (surface,)
    elif trial.zero(surface, (other,)):
        where = (other,)
    else:
        where = (surface, other)
    _, on = trial.points((*where, rate(system, mode, where[0])))
    one, two = (_directions([trial.values(differentiate(e, x), on) for x in system.states]) for e in (surface, other))
    along = (one * two).sum(axis=0)
    # where they cross each other, as far away as numbers are rounded, both are zero by accident
    same = along**2 >= 1.0 - TUNING.on_surface
    if same.sum() < max(TUNING.fewest_samples, len(same) / 2):
        return 0
    signs = {*np.sign(along[same]).tolist()}
    return int(signs.pop()) if len(signs) == 1 else 0


def _directions(gradients: Sequence[np.ndarray]) -> np.ndarray:
    """Gradients, one a column, as vectors of length 1; NaN where there is none."""
    found = np.array(gradients)
    with np.errstate(all="ignore"):
        found = found / np.abs(found).max(axis=0)
        return found / np.sqrt((found**2).sum(axis=0))


def cancels(image: Any) -> bool:
    """Whether the image of a reset may be small beside its operands, and so as inexact as they are.

    A product, such as ``-e*v``, is as exact as its factors.
    """
    exact = (*INCREASING, sympy.exp, sympy.cosh)
    return any(
        p.is_Add or (p.is_Function and not isinstance(p, exact) and type(p).__name__ not in SPECIAL)
        for p in sympy.preorder_traversal(image)
    )
