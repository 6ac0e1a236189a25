"""Noise at events: a parameter that is drawn anew, from a distribution, whenever certain events happen.

The parameter becomes an expression of a state of rate 0, the standard variate, which the events reset to a new number,
and of parameters of the distribution. A second state counts the draws. The numbers depend on the seed and on the
count alone: on no run beside, on no step, on no order of computation.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from hashlib import sha256
from math import fsum, inf, isfinite, log, nextafter
from numbers import Integral
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from chaosdrill.errors import SettingsError
from chaosdrill.limits import NOT_NEGATIVE, POSITIVE, Limit
from chaosdrill.model.tables import OF_NOISE, finite
from chaosdrill.model.values import System
from chaosdrill.names import event_words, remedy, shown

if TYPE_CHECKING:
    import numpy as np

PERIOD = "period"
"""The event name that stands for a draw once a forcing period."""

SEED = "noise_seed"

LARGEST_SEED = 2**53
"""Up to which a double counts."""


@dataclass(frozen=True)
class Distribution:
    """Values that a parameter is drawn from: a standard variate, shifted and scaled by parameters of their own."""

    uniforms: ClassVar[int] = 1
    """How many uniform numbers a draw takes."""

    limits: ClassVar[Mapping[str, Limit]] = {}
    """Limits of its parameters that hold for any draw."""

    def __post_init__(self) -> None:
        for name, value in self.numbers().items():
            number = finite(value)
            if number is None:
                raise SettingsError(f"{self.title}: {name} is {shown(value):.60}; it must be a finite number")
            object.__setattr__(self, name, number)
        for name, limit in self.limits.items():
            if told := limit.refuses(getattr(self, name)):
                raise SettingsError(f"{self.title}: {name}: {told}")

    @property
    def title(self) -> str:
        """Its name in scenes."""
        return type(self).__name__.lower()

    def numbers(self) -> dict[str, Any]:
        """Its parameters, by name."""
        return {one.name: getattr(self, one.name) for one in fields(self)}

    def value(self, variate: Any, of: Mapping[str, Any]) -> Any:
        """The value of a standard variate, by symbols of the parameters."""
        raise NotImplementedError

    def variate(self, drawn: Sequence[Any], of: Mapping[str, Any]) -> Any:
        """The standard variate of uniform numbers."""
        return drawn[0]

    def at_first(self) -> float:
        """The standard variate before the first draw."""
        return 0.5

    def support(self) -> tuple[float, float]:
        """The least and the greatest value."""
        raise NotImplementedError

    def spread(self) -> bool:
        """Whether there is more than one value."""
        low, high = self.support()
        return low < high

    def parameters(self) -> dict[str, float]:
        """The parameters of a system in which it is drawn: one without spread is the first of them alone."""
        numbers = self.numbers()
        return numbers if self.spread() else dict([next(iter(numbers.items()))])


@dataclass(frozen=True)
class Uniform(Distribution):
    """All values between two ends are equally likely.

    Parameters
    ----------
    low, high : float
        The ends, low <= high.
    """

    low: float
    high: float

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.low > self.high:
            raise SettingsError(f"uniform: low is {self.low:g} and high {self.high:g}; low must not be above high")

    def value(self, variate: Any, of: Mapping[str, Any]) -> Any:
        return of["low"] + (of["high"] - of["low"]) * variate

    def support(self) -> tuple[float, float]:
        return self.low, self.high


@dataclass(frozen=True)
class Normal(Distribution):
    """Gaussian values, by Box and Muller's transformation (1958, doi:10.1214/aoms/1177706645).

    Parameters
    ----------
    mean, deviation : float
        Mean and standard deviation, the latter >= 0.
    """

    mean: float
    deviation: float
    uniforms: ClassVar[int] = 2
    limits: ClassVar[Mapping[str, Limit]] = {"deviation": NOT_NEGATIVE}

    def value(self, variate: Any, of: Mapping[str, Any]) -> Any:
        return of["mean"] + of["deviation"] * variate

    def variate(self, drawn: Sequence[Any], of: Mapping[str, Any]) -> Any:
        return _gaussian(drawn)

    def at_first(self) -> float:
        return 0.0

    def support(self) -> tuple[float, float]:
        return (-inf, inf) if self.deviation else (self.mean, self.mean)


@dataclass(frozen=True)
class LogNormal(Distribution):
    """Positive values whose logarithm is Gaussian.

    Parameters
    ----------
    median, sigma : float
        The median, > 0, and the standard deviation of the logarithm, >= 0.
    """

    median: float
    sigma: float
    uniforms: ClassVar[int] = 2
    limits: ClassVar[Mapping[str, Limit]] = {"median": POSITIVE, "sigma": NOT_NEGATIVE}

    def value(self, variate: Any, of: Mapping[str, Any]) -> Any:
        return of["median"] * variate

    def variate(self, drawn: Sequence[Any], of: Mapping[str, Any]) -> Any:
        import sympy

        return sympy.exp(of["sigma"] * _gaussian(drawn))

    def at_first(self) -> float:
        return 1.0

    def support(self) -> tuple[float, float]:
        return (nextafter(0.0, 1.0), inf) if self.sigma else (self.median, self.median)


@dataclass(frozen=True)
class Exponential(Distribution):
    """Positive values of the density exp(-x/mean)/mean.

    Parameters
    ----------
    mean : float
        The mean, >= 0.
    """

    mean: float
    limits: ClassVar[Mapping[str, Limit]] = {"mean": NOT_NEGATIVE}

    def value(self, variate: Any, of: Mapping[str, Any]) -> Any:
        return of["mean"] * variate

    def variate(self, drawn: Sequence[Any], of: Mapping[str, Any]) -> Any:
        import sympy

        return sympy.Abs(sympy.log(drawn[0]))

    def at_first(self) -> float:
        return log(2)

    def support(self) -> tuple[float, float]:
        return (nextafter(0.0, 1.0), inf) if self.mean else (0.0, 0.0)


def _gaussian(drawn: Sequence[Any]) -> Any:
    """A standard normal number of two uniform ones."""
    import sympy

    return sympy.sqrt(2 * sympy.Abs(sympy.log(drawn[0]))) * sympy.cos(2 * sympy.pi * drawn[1])


@dataclass(frozen=True)
class Choice(Distribution):
    """One of several values.

    Parameters
    ----------
    values : sequence of float
        The values to choose from.
    weights : sequence of float, optional
        Their relative probabilities; default: equal ones.
    """

    values: Sequence[float]
    weights: Sequence[float] | None = None

    def __post_init__(self) -> None:
        for name in ("values", "weights"):
            given = getattr(self, name)
            if given is None:
                continue
            listed = list(given) if isinstance(given, Iterable) and not isinstance(given, str | Mapping) else []
            read = tuple(number for one in listed if (number := finite(one)) is not None)
            if len(read) < max(1, len(listed)):
                raise SettingsError(f"choice: {name} is {shown(given):.60}; it must be a list of finite numbers")
            object.__setattr__(self, name, read)
        weights = self.weights
        if weights is not None and (
            len(weights) != len(self.values) or min(weights) < 0 or not 0 < fsum(weights) < inf
        ):
            raise SettingsError(
                f"choice: weights is {shown(list(weights)):.60}; give a number >= 0 for each of the {len(self.values)} "
                "values, not all of them 0"
            )

    def numbers(self) -> dict[str, Any]:
        """The values, by their numbers from 1; weights stay as they are."""
        return {f"value_{k}": value for k, value in enumerate(self.values, 1)}

    def _edges(self) -> list[float]:
        """Parts of all weights up to and with each value."""
        weights = self.weights or [1.0] * len(self.values)
        return [fsum(weights[: k + 1]) / fsum(weights) for k in range(len(weights))]

    def value(self, variate: Any, of: Mapping[str, Any]) -> Any:
        return variate

    def variate(self, drawn: Sequence[Any], of: Mapping[str, Any]) -> Any:
        import sympy

        # 1 from an edge on: all terms but one are exactly zero
        beyond = [1, *(sympy.floor(1 + drawn[0] - sympy.Float(edge)) for edge in self._edges()[:-1]), 0]
        one, following = beyond[:-1], beyond[1:]
        return sympy.Add(*(v * (a - b) for v, a, b in zip(of.values(), one, following, strict=True)))

    def at_first(self) -> float:
        return next(v for v, edge in zip(self.values, self._edges(), strict=True) if edge >= 0.5)

    def support(self) -> tuple[float, float]:
        return min(self.values), max(self.values)


DISTRIBUTIONS = {one.__name__.lower(): one for one in (Uniform, Normal, LogNormal, Exponential, Choice)}
"""By their names in scenes."""


def names_of(name: str) -> tuple[str, str]:
    """The states that a parameter becomes."""
    variate, count = (f"{name}_{one}" for one in OF_NOISE)
    return variate, count


def added_parameters(distributions: Mapping[str, Distribution], seed: int) -> dict[str, float]:
    """Parameters that take the place of those that are drawn."""
    own = {f"{name}_{key}": value for name, one in distributions.items() for key, value in one.parameters().items()}
    return {**own, SEED: float(seed)}


def added_limits(distributions: Mapping[str, Distribution], limits: Mapping[str, Limit]) -> dict[str, Limit]:
    """Limits of these: of what are values of a parameter those of the parameter, too."""
    plain = {
        f"{name}_{key}": one.limits[key]
        for name, one in distributions.items()
        for key in one.parameters()
        if key in one.limits
    }
    bounded = {name: one for name, one in distributions.items() if isinstance(one, Uniform | Choice) and name in limits}
    own = {f"{name}_{key}": limits[name] for name, one in bounded.items() for key in one.parameters()}
    return {**plain, **own, SEED: Limit(high=LARGEST_SEED - 1.0, quantity="the seed of the noise", whole=True)}


def seeds_of_starts(
    system: System, starts: "np.ndarray", parameters: "Mapping[str, np.ndarray]" = MappingProxyType({})
) -> "dict[str, np.ndarray]":
    """Parameters of runs from some of many starts, each with noise of its own: that of the seed plus its place.

    ``starts``: places of the starts among all of them, from 0, shape (P,). ``parameters``: those that the runs have
    already, each of shape (P,).
    """
    given = dict(parameters)
    if system.draws:
        given[SEED] = (given.get(SEED, system.parameters[SEED]) + starts) % LARGEST_SEED
    return given


class Noise(NamedTuple):
    """Noise that a system can have: what is drawn, at which events, and the numbers of the system with it."""

    distributions: dict[str, Distribution]
    events: dict[str, tuple[str, ...]]
    """Names or kinds of them, by parameter."""
    parameters: dict[str, float]
    initial: dict[str, Any]
    limits: dict[str, Limit]

    @property
    def form(self) -> str:
        """Digest of all that makes the equations, apart from the numbers in them."""
        parts = [
            [name, one.title, one.spread(), [*one.parameters()], getattr(one, "weights", None)]
            for name, one in self.distributions.items()
        ]
        return sha256(json.dumps([parts, list(self.events.values())]).encode()).hexdigest()


def noise_of(system: System, distributions: Any, at: Any, seed: int) -> Noise:
    """The noise of a system some of whose parameters are drawn anew at events; see `HybridSystem.with_noise`."""
    _check(system, distributions, seed)
    # their order in the mapping must not say which numbers a parameter gets
    distributions = {name: distributions[name] for name in sorted(distributions)}
    return Noise(
        distributions=distributions,
        events={name: _told(system, name, at) for name in distributions},
        parameters=_parameters(system, distributions, seed),
        initial={**system.start, **{names_of(name)[0]: one.at_first() for name, one in distributions.items()}},
        limits={**system.limits, **added_limits(distributions, system.limits)},
    )


def _told(system: System, name: str, at: Any) -> tuple[str, ...]:
    """The names of events at which a parameter is drawn."""
    default = tuple(str(t.kind) for t in system.transitions[:1]) if system.discrete else None
    of_one = at.get(name) if isinstance(at, Mapping) else at
    if of_one is None and default:
        return default
    listed = (of_one,) if isinstance(of_one, str) else of_one
    if not isinstance(listed, Sequence) or not listed or not all(isinstance(one, str) for one in listed):
        raise SettingsError(
            f"{system.name}: at is {shown(of_one):.60} for {name!r}; give the name or kind of an event, "
            f"{PERIOD!r}, or a list of these; it has {known_events(system)}"
        )
    return tuple(listed)


def known_events(system: System) -> str:
    events = event_words(system.transitions)
    if system.forced and not system.discrete:
        events.append(PERIOD)
    return ", ".join(map(repr, events)) or "no events"


def _parameters(system: System, distributions: Mapping[str, Distribution], seed: int) -> dict[str, float]:
    added = added_parameters(distributions, seed)
    # the first parameter of a distribution has the place of the one that is drawn, since rounding depends on places
    first = {name: f"{name}_{next(iter(one.parameters()))}" for name, one in distributions.items()}
    kept = {first.get(key, key): value for key, value in system.parameters.items()}
    if taken := next((key for key in added if key in system.parameters), None):
        raise SettingsError(f"{system.name}: it has a parameter {taken!r} already, of which noise makes one; rename it")
    return {**kept, **added}


def _check(system: System, distributions: Any, seed: Any) -> None:
    if system.noise:
        raise SettingsError(f"{system.name}: it has noise already; give all of it in one call, to the system without")
    if system.sources:
        raise SettingsError(
            f"{system.name}: it has Python functions, which read their parameters themselves; write them as expressions"
        )
    if isinstance(seed, bool) or not isinstance(seed, Integral) or not 0 <= int(seed) < LARGEST_SEED:
        raise SettingsError(f"{system.name}: seed is {shown(seed):.60}; it must be a whole number from 0 to 2**53 - 1")
    if not isinstance(distributions, Mapping) or not distributions:
        raise SettingsError(
            f"{system.name}: the noise is {shown(distributions):.60}; give distributions by parameter, as in "
            "{'e': Uniform(0.7, 0.9)}"
        )
    for name, one in distributions.items():
        if name not in system.parameters:
            raise SettingsError(
                f"{system.name}: unknown parameter {name!r:.60}; {remedy(str(name), system.parameters)}"
            )
        if not isinstance(one, Distribution):
            known = ", ".join(made.__name__ for made in DISTRIBUTIONS.values())
            raise SettingsError(f"{system.name}: {name} is {shown(one):.60}; give one of {known}")
        if name in system.exponent_parameters:
            raise SettingsError(f"{system.name}: {name!r} stands in an exponent and cannot be drawn")
        for end in one.support() if name in system.limits else ():
            told = system.limits[name].refuses(end) if isfinite(end) else "it has no bounds"
            if told and not end == inf == system.limits[name].high:
                raise SettingsError(f"{system.name}: {name!r} cannot have {one.title} values: {told}")
