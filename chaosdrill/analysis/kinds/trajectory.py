"""States over time, with every event."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, ClassVar, Self

from chaosdrill.analysis.arguments import Times
from chaosdrill.analysis.base import Dataset, HybridSystem, Job, Record, analysis
from chaosdrill.analysis.spans import Span
from chaosdrill.analysis.starts import STARTS, Tangents
from chaosdrill.dataset.schema import (
    INITIAL_STATE,
    QUADRATURE,
    RUN,
    RUN_NUMBER,
    SI,
    STATES,
    axis,
    forcing,
    may,
    need,
    outcome,
    table,
)
from chaosdrill.settings import Faults, Whole, setting, told

_EITHER = "times are given, at which states are recorded instead of samples"

_SHORTEST = 1e-12
"""Duration of a run whose only output time is its start."""

VARIABLES = table(
    axis("time", "time", "f8", "model time", "Dimensionless time of each sample.", True),
    *STATES,
    need("states", f"{RUN} time state", "f8", "state", "States of the hybrid system at the sample times."),
    need("mode", f"{RUN} time", "i1", "mode", "At the sample time; -1: after the end.", flags="mode", lacking=True),
    may(QUADRATURE, f"{RUN} time", "f8", "quadrature", "Integral along the flow from the start of the record."),
    need("event_time", "event", "f8", "time of the event", "Times do not decrease; equal times are ties."),
    may("event_time_error", "event", "f8", "error of the time", "Of completed rebounds; zero of other events."),
    need("event_kind", "event", "i1", "transition taken", "Which transition it was.", flags="transition"),
    need(
        *("event_speed", "event", "f8", "normal speed"),
        "Rate of the guard, as it is written, before the event. Small means grazing.",
    ),
    may("event_mode_before", "event", "i1", "mode before the event", "Mode left.", flags="mode"),
    may("event_mode_after", "event", "i1", "mode after the event", "Mode entered.", flags="mode"),
    need("event_state_before", "event state", "f8", "state before the event", "Projected onto the guard."),
    need("event_state_after", "event state", "f8", "state after the event", "After the reset."),
    outcome(RUN),
    RUN_NUMBER,
    INITIAL_STATE,
    may("initial_mode", RUN, "i1", "initial mode", "Mode in which a run starts.", flags="mode"),
    may("event_count", RUN, "i4", "events of the run", "Events stand run by run.", sample="event", rule="sampled"),
    axis("tangent", "tangent", "i4", "number of the tangent", "From 1."),
    may("initial_tangent", "tangent state", "f8", "initial tangent", "Small difference of two states at the start."),
    may("final_tangent", f"{RUN} tangent state", "f8", "final tangent", "At the end of the record.", rule="sampled"),
    *forcing(),
    may("time_si", "time", "f8", "time", SI, "s"),
    may("event_time_si", "event", "f8", "time of the event", SI, "s"),
    may("penetration_si", f"{RUN} time", "f8", "penetration", SI, "m"),
    may(
        "force_si",
        f"{RUN} time",
        "f8",
        "force of spring and damper on the rock",
        "Without the force of a contact.",
        "N",
    ),
    # the events of two runs in chaos are compared until these diverge
    bars={"event_time": ""},
)


@dataclass(frozen=True, kw_only=True)
class Trajectory(Record):
    """Settings of `trajectory`."""

    without_noise: ClassVar[str] = ""
    ends: ClassVar[tuple[str, ...]] = ("times",)
    meanings: ClassVar[Mapping[str, str]] = {
        "periods": "Points of the section to record: forcing periods, or, with ``at``, events or crossings of a "
        "surface; the record then extends from the point at which the transient ends to the last one, including "
        "its event."
    }

    samples: int | None = setting(
        Whole(1), None, doc="Samples per period or mean return (or over the whole ``duration``); default 200."
    )
    times: Any = setting(
        Times(),
        None,
        doc="Model times of the output, ascending, from the end of the transient on; they replace ``samples``, "
        "and the run ends at the last one unless a length is given. They change neither steps nor events, since "
        "states are interpolated by the method's dense output. At the time of an event the state before it is "
        "given. Not available with a section at events or on a surface.",
    )
    initial: Any = setting(
        STARTS,
        None,
        doc="Initial states of many runs on the same times, in any form that `basins` takes. A run that ends "
        "early has its outcome, and NaN from there on. Not with a section by events or a surface.",
    )
    tangents: Any = setting(
        Tangents(),
        None,
        doc="Initial tangents, one per row, linearly independent and no more than states, that are followed "
        "over the record, with saltation at every event; True: the unit vectors, the j-th of which becomes the "
        "j-th column of the state-transition matrix: the derivatives of the state at the end (the last of "
        "``times``) with respect to the state at the start of the record.",
    )

    @classmethod
    def beside(cls, table: Mapping[str, Any]) -> Faults:
        """Samples and times; and the lengths."""
        yield from super().beside(table)
        if "times" in table and "samples" in table:
            yield ("samples",), told(f"{_EITHER}; leave one of them out", table["samples"])

    @classmethod
    def misfits(cls, table: Mapping[str, Any], system: HybridSystem) -> Faults:
        """As for every run, plus times, or several runs, together with a section at events or on a surface."""
        yield from super().misfits(table, system)
        if table.get("at") in (None, "strobe"):
            return
        why = {"times": "leave one of them out", "initial": "the runs would have no times in common; leave one out"}
        for name, words in why.items():
            if name in table:
                yield ("at",), told(f"{name} and at exclude each other: {words}", table["at"])

    def counts(self, system: HybridSystem) -> str:
        """Lengths and their unit; the last of the given times is a length."""
        return Record.counts(self._told(system), system)

    def span(self, system: HybridSystem, numerics: Any, *, units: int = 1) -> Span:
        """Length of the run: the given one, or up to the last of the given times."""
        return Record.span(self._told(system), system, numerics, units=units)

    def ends_at_times(self) -> bool:
        """Whether the record ends at the last of the given times, for want of a length."""
        return self.times is not None and self.periods is None and self.duration is None

    def _told(self, system: HybridSystem) -> Self:
        """The same with a length."""
        if self.times is None or not self.ends_at_times():
            return self
        last, period = self.times[-1], system.forcing_period()
        if period is None:
            return replace(self, duration=max(last - self.transient, _SHORTEST))
        return replace(self, periods=max(1, math.ceil(Fraction(last) / Fraction(period)) - int(self.transient)))


@analysis("trajectory", Trajectory, "states over time, with every event", VARIABLES)
def trajectory(system: HybridSystem, given: Trajectory, job: Job) -> Dataset:
    """States at equal intervals of time, and every event.

    Returns
    -------
    xarray.Dataset
        ``states`` (time, state), ``mode`` (time), each quadrature (time), and over the dimension event: ``event_time``,
        ``event_kind``, ``event_speed``, ``event_mode_before``, ``event_mode_after``, ``event_state_before``,
        ``event_state_after``; ``outcome``. If a run ends early, the dataset contains the part before. A system that
        completes rebounds has ``event_time_error`` (event), the error of the time at which they end;
        ``event_state_after`` is the state at that time, but ``event_state_before`` that at the last rebound computed,
        so that forces do work between both. With ``initial`` all but events have the leading dimension ``run``; events
        stand run by run, ``event_count`` (run) of each, as after `join`, and there are ``initial_state`` (run, state)
        and ``initial_mode`` (run). With ``tangents`` there are ``initial_tangent`` and ``final_tangent`` (tangent,
        state), NaN where a run ended early; where its tangents alone did, ``outcome`` and the message are theirs.
    """
    from chaosdrill.analysis.ensembles import ensemble, one_run

    return one_run(system, given, job) if given.initial is None else ensemble(system, given, job)
