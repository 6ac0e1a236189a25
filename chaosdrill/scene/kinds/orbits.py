"""Periodic orbits, and branches of them along a parameter."""

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from chaosdrill.scene.kinds.base import Amount, Analysis, Transient
from chaosdrill.scene.kinds.points import Random
from chaosdrill.scene.strict import Strict

Period = Annotated[int, Field(ge=1, le=1000)]


class PeriodicOrbit(Analysis):
    """Keywords of `periodic_orbit`."""

    period: Period | None = None
    start: Literal["attractor", "guess", "search"] | None = None
    transient: Transient | None = None
    max_period: Period | None = None
    seeds: Annotated[list[dict[str, float | str]], Field(min_length=1)] | None = None
    random: Random | None = None

    @model_validator(mode="after")
    def _search(self) -> "PeriodicOrbit":
        if self.start == "search":
            if self.max_period is None:
                raise PydanticCustomError("search", 'start = "search" needs max_period, the longest period to look for')
            if self.period is not None:
                raise PydanticCustomError(
                    "search", 'start = "search" looks for all periods: give max_period, no period'
                )
            return self
        for name in ("max_period", "seeds", "random"):
            if getattr(self, name) is not None:
                raise PydanticCustomError(
                    "search", 'start = "search" is missing, without which {name} says nothing', {"name": name}
                )
        return self


class Limits(Strict):
    """From where to where a parameter is followed."""

    start: float
    stop: float

    @model_validator(mode="after")
    def _apart(self) -> "Limits":
        if self.start == self.stop:
            raise PydanticCustomError("apart", "start and stop are the same; a branch needs room between them")
        return self


class Continuation(Analysis):
    """Keywords of `continue_orbit`."""

    sweep: Annotated[dict[str, Limits], Field(min_length=1, max_length=2)]
    period: Period | None = None
    start: Literal["attractor", "guess"] | None = None
    transient: Transient | None = None
    doublings: Annotated[int, Field(ge=0, le=12)] | None = None
    follow: Literal["fold", "period_doubling", "grazing"] | None = None
    step: Amount | None = None
    max_points: Annotated[int, Field(ge=2, le=1_000_000)] | None = None

    @model_validator(mode="after")
    def _curve(self) -> "Continuation":
        if self.follow is None and len(self.sweep) == 2:
            raise PydanticCustomError(
                "curve", "sweep names two parameters: say with follow = ... which special point is followed in them"
            )
        if self.follow is not None and len(self.sweep) == 1:
            raise PydanticCustomError("curve", "follow needs a second parameter: name it in sweep too")
        if self.follow is not None and self.doublings:
            raise PydanticCustomError("curve", "a curve in two parameters has no doublings; leave it out")
        first = next(iter(self.sweep.values()))
        if self.step is not None and self.step > abs(first.stop - first.start):
            raise PydanticCustomError("step", "step is longer than the whole range of the (first) parameter")
        return self

    def keywords(self) -> dict[str, Any]:
        """Arguments of the function, the limits as pairs."""
        return super().keywords() | {"sweep": {name: (ends.start, ends.stop) for name, ends in self.sweep.items()}}
