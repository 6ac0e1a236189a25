"""The equations of a system whose parameters are drawn at events: states of rate 0 that resets draw anew."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import sympy

from chaosdrill.errors import SettingsError
from chaosdrill.model.noise import PERIOD, SEED, Distribution, Noise, known_events, names_of
from chaosdrill.model.places import parameter, rewritten
from chaosdrill.model.special import random_uniform
from chaosdrill.model.transition import Transition
from chaosdrill.model.values import System

CLOCK = "draw"
"""Kind of the event once a period."""


def with_draws(system: System, noise: Noise) -> dict[str, Any]:
    """The definition of a system whose parameters are drawn at events."""
    distributions = noise.distributions
    put = {parameter(name): _value(name, one) for name, one in distributions.items()}
    whole = rewritten(system.built, lambda expression: sympy.sympify(expression).xreplace(put))
    period = whole.period if whole.forced else None
    if period is not None and (fixed := {symbol.name for symbol in period.free_symbols} & distributions.keys()):
        raise SettingsError(f"{whole.name}: the period depends on {min(fixed)!r}, which therefore cannot be drawn")
    drawn = _Drawn(distributions)
    events = {name: _events(whole, name, noise.events[name]) for name in distributions}
    given: dict[str, Any] = {
        "name": whole.name,
        "description": whole.description,
        "states": [*whole.state_names, *(state for name in distributions for state in names_of(name))],
        "quadratures": whole.quadratures,
        "bounds": {**whole.bounds, **{state: None for name in distributions for state in names_of(name)}},
        "labels": {
            **{k: v for k, v in whole.labels.items() if k not in distributions},
            **_labels(whole, distributions),
        },
        "noise": {
            name: {"distribution": one.title, "at": list(noise.events[name]) if one.spread() else []}
            for name, one in distributions.items()
        },
    }
    held = {state: sympy.Integer(0) for name in distributions for state in names_of(name)}
    if whole.discrete:
        images = {x.name: image.xreplace(put) for x, image in vars(whole)["images"].items()}
        still = {state: sympy.Symbol(state, real=True) for name in distributions for state in names_of(name)}
        draws = {k: v for name in distributions for k, v in drawn.reset(name).items()}
        given |= {"images": {**images, **still, **draws}}
        given.pop("quadratures")
    else:
        given |= {
            "time": whole.time,
            "period": whole.period,
            "modes": {mode: {**rates, **held} for mode, rates in whole.modes.items()},
            "regions": whole.regions,
            "transitions": [*_resets(whole, events, drawn), *_clocks(whole, events, drawn)],
        }
    return given


class _Drawn:
    """Resets of the noise states at an event; each draw takes the next numbers of one sequence."""

    def __init__(self, distributions: Mapping[str, Distribution]) -> None:
        self.distributions = distributions
        self.width = sum(one.uniforms for one in distributions.values())
        counts = [one.uniforms for one in distributions.values()]
        self.first = {name: sum(counts[:k]) for k, name in enumerate(distributions)}

    def reset(self, name: str) -> dict[str, Any]:
        """The states of a parameter after a draw; none of one without spread, which is not drawn."""
        variate, count = names_of(name)
        number, one = sympy.Symbol(count, real=True), self.distributions[name]
        if not one.spread():
            return {}
        places = [self.width * number + self.first[name] + k for k in range(one.uniforms)]
        uniform = [random_uniform(parameter(SEED), place) for place in places]
        return {variate: one.variate(uniform, _own(name, one)), count: number + 1}


def _own(name: str, one: Distribution) -> dict[str, Any]:
    return {key: parameter(f"{name}_{key}") for key in one.parameters()}


def _value(name: str, one: Distribution) -> Any:
    if not one.spread():
        (only,) = _own(name, one).values()
        return only
    return one.value(sympy.Symbol(names_of(name)[0], real=True), _own(name, one))


def _labels(system: System, distributions: Mapping[str, Distribution]) -> dict[str, str]:
    found = {SEED: "seed of the noise"}
    for name, one in distributions.items():
        label = system.labels.get(name, name)
        variate, count = names_of(name)
        found |= {variate: f"standard variate of {label}", count: f"draws of {label}"}
        found |= {f"{name}_{key}": f"{label}: {key} of its distribution" for key in one.parameters()}
    return found


def _events(system: System, name: str, at: tuple[str, ...]) -> tuple[frozenset[str], bool]:
    """Names of the transitions at which a parameter is drawn, and whether it is drawn once a period."""
    found: set[str] = set()
    clock = False
    for event in at:
        named = {t.name for t in system.transitions if event in (t.name, t.kind)}
        if named:
            found |= named
        elif event == PERIOD and not system.discrete:
            if not system.forced:
                raise SettingsError(
                    f"{system.name}: at is {PERIOD!r} for {name!r}, but it has no period; it has {known_events(system)}"
                )
            clock = True
        else:
            raise SettingsError(f"{system.name}: at is {event!r:.60} for {name!r}; it has {known_events(system)}")
    return frozenset(found), clock


def _resets(system: System, events: Mapping[str, tuple[frozenset[str], bool]], drawn: _Drawn) -> Iterator[Transition]:
    """The transitions of the system, with the draws that they make."""
    for t in system.transitions:
        more = {k: v for name, (named, _) in events.items() if t.name in named for k, v in drawn.reset(name).items()}
        yield replace(t, reset={**t.reset, **more})


def _clocks(system: System, events: Mapping[str, tuple[frozenset[str], bool]], drawn: _Drawn) -> Iterator[Transition]:
    """The event once a period, a quarter of a period after the strobe, in every mode."""
    more = {k: v for name, (_, clock) in events.items() if clock for k, v in drawn.reset(name).items()}
    if not more:
        return
    time = system.time or sympy.Symbol("t", real=True)
    taken = {t.name for t in system.transitions}
    for mode in system.modes:
        name = CLOCK if len(system.modes) == 1 else f"{CLOCK} in {mode}"
        while name in taken:
            name += "'"
        guard = -sympy.cos(2 * sympy.pi * time / system.period)
        yield Transition(name, mode, mode, guard, 1, reset=more, kind=CLOCK)
