"""A symmetric system over half of its motion: what comes after is the image of what was before."""

from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import chain, count
from math import inf, isfinite
from typing import TYPE_CHECKING, Any, cast

import sympy

from chaosdrill.errors import ModelError, SettingsError
from chaosdrill.model.crossings import ratio, same_surface
from chaosdrill.model.derive import image_of
from chaosdrill.model.held import Trial, kept_apart
from chaosdrill.model.parts import read_of_states, read_table
from chaosdrill.model.places import parameter, rewritten
from chaosdrill.model.system import SYSTEM, HybridSystem
from chaosdrill.model.tables import DEFAULT_BOUNDS
from chaosdrill.model.transition import REFLECTION, Transition
from chaosdrill.names import remedy
from chaosdrill.typed import expecting

if TYPE_CHECKING:
    from chaosdrill.model.maps import Map

CLOCK = "half_time"
"""State that tells the time within the half period."""


@expecting(ModelError, system=SYSTEM)
def halved(system: "HybridSystem", symmetry: Mapping[Any, Any]) -> "HybridSystem":
    """The system over half of its motion, by a symmetry S that its equations have; S is checked.

    Every orbit x(t) has a partner: S x(t + T/2) in a forced system of period T, S x in one without forcing and in a
    map. A symmetric orbit is its own partner, and closes after half of its period here.

    Forced, the motion is followed to T/4, where S takes it back to -T/4 (an event of the kind ``half``): the period is
    T/2, and the strobe points of x are those of the system itself, with S applied to every second one. A further state,
    ``half_time``, is the time within the half period, 0 at strobes; its multiplier is 0. Without forcing S is applied
    where the first state that S changes, and that no other event watches, meets its image: the motion stays on one side
    of that surface. Of a map the images become S of them.

    A multiplier mu of a symmetric orbit is mu**2 over the whole period. At -1 it loses its symmetry (a pitchfork of
    the system): the doubled orbit found there has the period T and holds both partners, one at its even and one at its
    odd strobes. Exponents in a unit of time are those of the system.

    Parameters
    ----------
    system : HybridSystem or Map
        It is not changed.
    symmetry : mapping of state to expression
        The image of every state that S changes, in states and parameters: ``{"x": "-x", "v": "-v"}``. Applied twice it
        must change nothing. Which modes and transitions it exchanges is found.

    Returns
    -------
    HybridSystem
        Without a parameter that is 0 and would break the symmetry otherwise, and without the marks and quadratures
        that S changes. Its bounds are those within which a state and its image are within those of the system.

    Raises
    ------
    ModelError
        If the equations do not have the symmetry: which rate, guard, reset or condition breaks it. If S does not take
        the bounds of a state to bounds of a state.
    SettingsError
        If the system is noisy or has Python functions.

    References
    ----------
    J. W. Swift, K. Wiesenfeld, "Suppression of period doubling in symmetric systems", Physical Review Letters 52 (1984)
    705-708, doi:10.1103/PhysRevLett.52.705: the half map of a forced system.
    """
    system = system.built
    if system.noise or system.sources:
        what = "is noisy" if system.noise else "has Python functions"
        raise SettingsError(f"{system.name} {what}: a symmetry is checked in expressions without noise; leave it out")
    images = _images(system, symmetry)
    found, fixed = _found(system, images)
    values = {name: value for name, value in system.parameters.items() if name not in fixed}
    halve = _half_of_map if system.discrete else _half_of_forced if system.forced else _half_of_autonomous
    return halve(found, values).changed(limits={k: one for k, one in system.limits.items() if k in values})


def _images(system: "HybridSystem", symmetry: Any) -> dict[Any, Any]:
    """The image of every state."""
    where = f"{system.name}: symmetry"
    states = {x.name: x for x in system.states}
    given = read_table(where, symmetry)
    for name in given:
        if name not in states:
            raise ModelError(f"{where}: unknown state {name!r:.60}; {remedy(name, states)}")
    images = {x: read_of_states(f"{where}: {x.name}", given.get(x.name, x), system) for x in system.states}
    if all(x == image for x, image in images.items()):
        raise ModelError(f"{where}: it changes no state; name one with its image, as in {{'x': '-x'}}")
    return images


def _found(system: "HybridSystem", images: Mapping[Any, Any]) -> tuple["_Symmetry", set[str]]:
    """The symmetry, and the parameters that must stay 0 for it."""
    trial = Trial(system, near=True)
    try:
        return _Symmetry.of(trial, system, images, set()), set()
    except ModelError:
        zeros = [name for name, value in sorted(system.parameters.items()) if value == 0]
        found, fixed = None, set(zeros)
        # with all of them at 0, then without each in turn that it does not need there
        for name in ("", *zeros):
            with suppress(ModelError):
                found, fixed = _Symmetry.of(trial, system, images, fixed - {name}), fixed - {name}
            if found is None:
                raise
        return cast("_Symmetry", found), fixed


@dataclass(frozen=True)
class _Symmetry:
    """A symmetry that the equations of a system have."""

    system: "HybridSystem"
    images: Mapping[Any, Any]  # of the states
    modes: Mapping[str, str]  # mode -> its image
    put: Mapping[Any, Any]  # what stands for parameters that must be 0
    trial: Trial

    @classmethod
    def of(cls, trial: Trial, system: "HybridSystem", images: Mapping[Any, Any], fixed: set[str]) -> "_Symmetry":
        """The symmetry by its images of the states."""
        put = {parameter(name): sympy.Integer(0) for name in fixed}
        bare = cls(system, {x: image.xreplace(put) for x, image in images.items()}, {}, put, trial)
        for x, image in bare.images.items():
            again = bare.seen(image)
            if not bare.same(again, x):
                raise ModelError(
                    f"{system.name}: symmetry: applied twice, {x.name} becomes {again!s:.80}; it must be {x.name}"
                )
        return replace(bare, modes={} if system.discrete else bare._exchanged())

    def seen(self, expression: Any) -> Any:
        """An expression at the image of the state, half a period later."""
        moved = dict(self.images)
        if self.system.forced and self.system.time is not None and not self.system.discrete:
            moved[self.system.time] = self.system.time + self.system.period / 2
        return sympy.sympify(expression).xreplace(moved).xreplace(self.put)

    def same(self, a: Any, b: Any, factor: float = 1) -> bool:
        """Whether b is a times a factor, as functions."""
        a, b = (sympy.Add.make_args(sympy.sympify(e).xreplace(self.put)) for e in (a, b))
        terms = [*(factor * term for term in a), *(-term for term in b)]
        return sympy.Add(*terms) == 0 or self.trial.zero(kept_apart(terms), ())

    def sign(self, a: Any, b: Any) -> int:
        """Sign of the number by which b is a multiple of a; 0 if b is no multiple."""
        a, b = (sympy.sympify(e).xreplace(self.put) for e in (a, b))
        if (number := ratio(b, a)) is None:
            below, above = (sum(self.trial.rows(term, ())[0] for term in sympy.Add.make_args(e)) for e in (a, b))
            ratios = (float(x) / float(y) for x, y in zip(above, below, strict=True) if y != 0.0)
            number = next(filter(isfinite, ratios), 0.0)
            number *= self.same(a, b, number)
        return (number > 0) - (number < 0)

    def _alike(self, a: Any, b: Any) -> bool:
        """Whether two conditions hold at the same states."""
        if a == b:
            return True
        if isinstance(a, sympy.Eq | sympy.Ne) and type(a) is type(b):
            return self.sign(a.lhs - a.rhs, b.lhs - b.rhs) != 0
        if all(isinstance(one, sympy.Gt | sympy.Ge | sympy.Lt | sympy.Le) for one in (a, b)):
            strict = {isinstance(one, sympy.Gt | sympy.Lt) for one in (a, b)}
            return len(strict) == 1 and self.sign(a.gts - a.lts, b.gts - b.lts) == 1
        if not isinstance(a, sympy.And | sympy.Or | sympy.Not) or type(a) is not type(b):
            return False
        rest = list(b.args)
        for part in a.args:
            other = next((one for one in rest if self._alike(part, one)), None)
            if other is None:
                return False
            rest.remove(other)
        return not rest

    def pushed(self, rates: Mapping[Any, Any]) -> dict[Any, Any]:
        """The rates of the image of a motion with these rates."""
        return {
            x: sum((sympy.diff(image, y) * rates[y] for y in self.images), sympy.Integer(0))
            for x, image in self.images.items()
        }

    def _exchanged(self) -> dict[str, str]:
        """The image of every mode, by which transitions have images too."""
        system = self.system
        names = system.mode_names
        fields = {mode: self.pushed(rates) for mode, rates in system.modes.items()}
        seen = {mode: {x: self.seen(rate) for x, rate in rates.items()} for mode, rates in system.modes.items()}
        off = {
            mode: {
                other: [x for x in system.states if not self.same(seen[other][x], fields[mode][x])] for other in names
            }
            for mode in names
        }
        fits = {mode: [other for other in names if not off[mode][other]] for mode in names}
        for mode in (one for one in names if not fits[one]):
            near = min(names, key=lambda other: (len(off[mode][other]), other != mode))
            x = off[mode][near][0]
            raise ModelError(
                f"{system.name}: symmetry: mode {mode!r:.60}: the image of a motion has the rate "
                f"{fields[mode][x]!s:.120} of {x.name}; in mode {near!r:.60} it is {seen[near][x]!s:.120}"
            )
        told = ""
        for modes in _involutions(names, fits):
            found = replace(self, modes=modes)
            fault = found._fault_of_transitions()
            if fault is None:
                return modes
            told = told or fault
        raise ModelError(f"{self.system.name}: symmetry: {told or 'modes have no images in pairs'}")

    def _fault_of_transitions(self) -> str | None:
        """Which transition has no image, and why; None if all have one."""
        met: dict[tuple[str, int], int] = {}
        for number, one in enumerate(self.system.transitions):
            for source in one.source:
                image, fault = self._image_of(one, source)
                if image is None and not one.marks_only():
                    return fault
                if image is not None:
                    met[source, number] = image
        for (source, first), other in met.items():
            one = self.system.transitions[first]
            if one.completes is not None:
                rebound = next(i for i, t in enumerate(self.system.transitions) if t.name == one.completes)
                if self.system.transitions[other].completes != self.system.transitions[met[source, rebound]].name:
                    return f"transition {one.name!r:.60} completes {one.completes!r:.60}, its image does not"
            # of outcomes of one event the first that holds is taken
            for later in range(first + 1, len(self.system.transitions)):
                t = self.system.transitions[later]
                same = (source, later) in met and (t.guard, t.direction) == (one.guard, one.direction)
                if same and met[source, later] <= other:
                    return f"transitions {one.name!r:.60} and {t.name!r:.60} have images in another order"
        return None

    def _image_of(self, one: Transition, source: str) -> tuple[int | None, str]:
        """The number of the transition that is the image of one from a mode; else what comes closest, and why not."""
        where, to = self.modes[source], self.modes[one.target]
        closest, told = -1, f"there is none from {where!r:.60} to {to!r:.60}"
        for number, other in enumerate(self.system.transitions):
            if where not in other.source or other.target != to:
                continue
            fault, steps = self._difference(one, source, other)
            if fault is None:
                return number, ""
            if steps > closest:
                closest, told = steps, f"the nearest is {other.name!r:.60}, but {fault}"
        return None, f"transition {one.name!r:.60} has no image: {told}"

    def _difference(self, one: Transition, source: str, other: Transition) -> tuple[str | None, int]:
        """Why another transition is not the image of one, and how far they agree."""
        guard = self.seen(other.guard)
        sign = self.sign(one.guard, guard)
        if not sign or other.direction != sign * one.direction:
            return (
                f"its guard at the image is {guard!s:.80}, direction {other.direction}; it must be a multiple of "
                f"{one.guard!s:.80}, direction {one.direction}"
            ), 0
        after, theirs = image_of(self.system, one), image_of(self.system, other)
        for x, image in self.images.items():
            wanted, given = image.xreplace(after), self.seen(theirs[x])
            if not self.same(wanted, given):
                return f"after it {x.name} is {given!s:.80}, the image has {wanted!s:.80}", 1
        holds, where = one.conditions.get(source, sympy.true), self.modes[source]
        given = self.seen(other.conditions.get(where, sympy.true))
        if not self._alike(holds.xreplace(self.put), given):
            return f"its condition is {given!s:.80}, the image has {holds!s:.80}", 2
        if one.priority != other.priority or (one.completes is None) != (other.completes is None):
            return "its priority or what it completes is another", 3
        return None, 4

    def keeps(self, t: Transition) -> bool:
        """Whether a transition is no mark that the symmetry changes."""
        return not t.marks_only() or all(self._image_of(t, mode)[0] is not None for mode in t.source)

    def bounds(self) -> dict[str, tuple[float, float]]:
        """Bounds within which a state and its image are within those of the system: the motion has both."""
        system, everywhere = self.system, (-inf, inf)
        given = {name: pair for name, pair in system.bounds.items() if pair not in (DEFAULT_BOUNDS, everywhere)}
        found = dict(given)
        for x, image in self.images.items():
            if x.name not in given or image == x:
                continue
            y = next((one for one in system.states if image.free_symbols == {one}), None)
            if y is None or not sympy.diff(image, y).is_number:
                raise ModelError(
                    f"{system.name}: symmetry: {x.name} has bounds, and its image {image!s:.60} is not a number times "
                    f"one state, plus a number; give the system none: bounds={{{x.name!r}: None}}"
                )
            rest, slope = float(image.xreplace({y: sympy.Integer(0)})), float(sympy.diff(image, y))
            # no negative zero
            low, high = sorted((end - rest) / slope + 0.0 for end in given[x.name])
            least, most = found.get(y.name, everywhere)
            found[y.name] = max(low, least), min(high, most)
            if not found[y.name][0] < found[y.name][1]:
                raise ModelError(
                    f"{system.name}: symmetry: no {x.name} within its bounds {given[x.name]} has its image in them"
                )
        return {**system.bounds, **found}

    def kept_quadratures(self) -> list[str]:
        """The quadratures that the symmetry does not change."""
        return [
            name
            for name, rates in self.system.quadratures.items()
            if all(self.same(self.seen(rates[self.modes[mode]]), rate) for mode, rate in rates.items())
        ]


def _involutions(names: tuple[str, ...], fits: Mapping[str, list[str]]) -> Iterator[dict[str, str]]:
    """All ways to exchange modes in pairs, or to leave them, as they fit."""
    if not names:
        yield {}
        return
    first, rest = names[0], names[1:]
    for other in fits[first]:
        if other == first or (other in rest and first in fits[other]):
            for found in _involutions(tuple(one for one in rest if one != other), fits):
                yield {first: other, other: first, **found}


def _labels(system: "HybridSystem", kept: Collection[str]) -> dict[str, Any]:
    """The labels of a system but those of parameters and quadratures that are not kept."""
    gone = {*system.parameters, *system.quadratures}.difference(kept)
    return {key: one for key, one in system.labels.items() if key not in gone}


def _half_of_map(found: _Symmetry, values: Mapping[str, float]) -> "HybridSystem":
    from chaosdrill.model.maps import Map

    system = cast("Map", found.system)
    after = {x: image.xreplace(found.put) for x, image in system.images.items()}
    wanted = {x: one.xreplace(after) for x, one in found.images.items()}
    for x, image in wanted.items():
        seen = found.seen(system.images[x])
        if not found.same(seen, image):
            raise ModelError(
                f"{system.name}: symmetry: the image of {x.name} is {seen!s:.120}; it must be {image!s:.120}"
            )
    return Map(
        system.states,
        dict(values),
        wanted,
        name=f"{system.name}, halved",
        initial=system.start,
        bounds=found.bounds(),
        labels=_labels(system, values),
    )


def _parts(found: _Symmetry, values: Mapping[str, float], moved: Mapping[Any, Any]) -> dict[str, Any]:
    """Parameters, modes, transitions and quadratures of the system itself, with other symbols."""
    system = found.system
    whole = rewritten(system, lambda expression: sympy.sympify(expression).xreplace(found.put).xreplace(moved))
    quadratures = {name: whole.quadratures[name] for name in found.kept_quadratures()}
    return {
        "name": f"{system.name}, halved",
        "parameters": dict(values),
        "modes": {mode: dict(rates) for mode, rates in whole.modes.items()},
        "transitions": [t for t, own in zip(whole.transitions, system.transitions, strict=True) if found.keeps(own)],
        "quadratures": quadratures,
        "regions": whole.regions,
        "labels": _labels(system, {*values, *quadratures}),
        "bounds": found.bounds(),
    }


def _halfway(found: _Symmetry, guard: Any, reset: Mapping[Any, Any]) -> list[Transition]:
    """The event that puts the image in the place of the state."""
    taken = {t.name for t in found.system.transitions}
    return [
        Transition(
            name if (name := f"half-{mode}") not in taken else f"{name}'",
            mode,
            image,
            guard,
            -1,
            dict(reset),
            kind=REFLECTION,
        )
        for mode, image in found.modes.items()
    ]


def _half_of_forced(found: _Symmetry, values: Mapping[str, float]) -> "HybridSystem":
    from chaosdrill.model.system import HybridSystem

    system = found.system
    period = system.period.xreplace(found.put)
    taken = {*system.state_names, *system.parameters, *system.quadratures}
    time = system.time or sympy.Symbol("t" if "t" not in taken else "time", real=True)
    within = sympy.Symbol(
        next(name for name in chain([CLOCK], (f"{CLOCK}_{k}" for k in count())) if name not in taken), real=True
    )
    parts = _parts(found, values, {time: within})
    for rates in parts["modes"].values():
        rates[within] = sympy.Integer(1)
    changed = {x: image for x, image in found.images.items() if x != image}
    # a quarter after a strobe, where the drives of most systems have no corner
    parts["transitions"] += _halfway(found, sympy.sin(4 * sympy.pi * time / period), {**changed, within: -period / 4})
    parts["bounds"][within.name] = None
    parts["labels"][within.name] = "time within the half period"
    return HybridSystem(states=(*system.states, within), time=time, period=period / 2, initial=system.start, **parts)


def _half_of_autonomous(found: _Symmetry, values: Mapping[str, float]) -> "HybridSystem":
    from chaosdrill.model.system import HybridSystem

    system = found.system
    changed = {x: image for x, image in found.images.items() if x != image}
    free = (
        x for x, image in changed.items() if not any(same_surface((x - image, t.guard)) for t in system.transitions)
    )
    first = next(free, None)
    if first is None:
        raise ModelError(f"{system.name}: symmetry: every state that it changes has an event where it meets its image")
    guard = sympy.factor_terms(first - found.images[first])
    # on the surface that state is its own image
    reset = {x: image for x, image in changed.items() if x != first}
    parts = _parts(found, values, {})
    parts["transitions"] += _halfway(found, guard, reset)
    start = dict(system.start)
    here = {
        **{parameter(p): v for p, v in system.parameters.items()},
        **{x: system.initial[x.name] for x in system.states},
    }
    if float(guard.xreplace(here)) < 0:
        start |= {x.name: float(image.xreplace(here)) for x, image in changed.items()}
        start |= {"mode": found.modes[start["mode"]]} if "mode" in start else {}
    return HybridSystem(states=system.states, time=system.time, initial=start, **parts)
