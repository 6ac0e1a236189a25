"""States over time, with every event."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Self

from chaosdrill.analysis.arguments import Span, Times, counted
from chaosdrill.analysis.base import Record, analysis
from chaosdrill.dataset.schema import QUADRATURE, SI, STATES, axis, forcing, may, need, outcome, table
from chaosdrill.errors import SettingsError
from chaosdrill.settings import Faults, Whole, setting

if TYPE_CHECKING:
    import xarray as xr

    from chaosdrill.analysis.base import Job
    from chaosdrill.model import HybridSystem

_EITHER = "times are given, at which states are put out in place of samples"

_SHORTEST = 1e-12
"""Duration of a run whose only time of output is its start."""

VARIABLES = table(
    axis("time", "time", "f8", "model time", "Dimensionless time of each sample.", True),
    *STATES,
    need("states", "time state", "f8", "state", "States of the hybrid system at the sample times."),
    need("mode", "time", "i1", "mode", "Mode that holds at the sample time.", flags="mode"),
    may(QUADRATURE, "time", "f8", "quadrature", "Integral along the flow from the start of the record."),
    need("event_time", "event", "f8", "time of the event", "Times do not decrease; equal times are ties."),
    need("event_kind", "event", "i1", "transition taken", "Which transition it was.", flags="transition"),
    need("event_speed", "event", "f8", "normal speed", "Rate of the guard at the crossing; small means grazing."),
    may("event_mode_before", "event", "i1", "mode before the event", "Mode left.", flags="mode"),
    may("event_mode_after", "event", "i1", "mode after the event", "Mode entered.", flags="mode"),
    need("event_state_before", "event state", "f8", "state before the event", "Projected onto the guard."),
    need("event_state_after", "event state", "f8", "state after the event", "After the reset."),
    outcome(""),
    *forcing(),
    may("time_si", "time", "f8", "time", SI, "s"),
    may("event_time_si", "event", "f8", "time of the event", SI, "s"),
    may("penetration_si", "time", "f8", "penetration", SI, "m"),
    may("force_si", "time", "f8", "force of spring and damper on the rock", "Without the force of a contact.", "N"),
)


@dataclass(frozen=True, kw_only=True)
class Trajectory(Record):
    """Settings of `trajectory`."""

    samples: int | None = setting(Whole(1), None)
    times: Any = setting(Times(), None)

    @classmethod
    def beside(cls, table: Mapping[str, Any]) -> Faults:
        """A length, which the last of given times is too, and samples or times."""
        if "times" in table and "samples" in table:
            yield ("samples",), f"{_EITHER}; leave one of them out"
        if "times" not in table or {"periods", "duration"} & table.keys():
            yield from super().beside(table)

    def agree(self, system: "HybridSystem") -> None:
        """As for every run; and refuse times in a run that is counted in something else, or has samples."""
        super().agree(system)
        if self.times is not None and self.samples is not None:
            raise SettingsError(f"samples is {self.samples!r}, but {_EITHER}; leave one of them out")
        if self.times is not None and self.counts(system) == "section":
            raise SettingsError(f"times and at={self.at!r} exclude each other; leave one of them out")

    def counts(self, system: "HybridSystem") -> str:
        """What lengths count, of which the last of given times is one."""
        told = self._told(system)
        return counted(system, told.at, told.periods, told.duration, told.transient)

    def span(self, system: "HybridSystem", numerics: Any, *, units: int = 1) -> Span:
        """How long to run: as long as it is told, or up to the last of the given times."""
        return Record.span(self._told(system), system, numerics, units=units)

    def _told(self, system: "HybridSystem") -> Self:
        """The same with a length."""
        if self.times is None or self.periods is not None or self.duration is not None:
            return self
        last, period = self.times[-1], system.forcing_period()
        if period is None:
            return replace(self, duration=max(last - self.transient, _SHORTEST))
        return replace(self, periods=max(1, math.ceil(Fraction(last) / Fraction(period)) - int(self.transient)))


@analysis("trajectory", Trajectory, "states over time, with every event", VARIABLES)
def trajectory(system: "HybridSystem", given: Trajectory, job: "Job") -> "xr.Dataset":
    """States at equal intervals of time, and every event.

    Parameters
    ----------
    system : HybridSystem
        System with its parameters and initial state.
    periods : int
        Points of the section to record: forcing periods, or, with ``at``, events or crossings of a surface; the record
        then goes on from the point at which the transient ends to the last one, with its event.
    duration : float
        Time to record instead; for systems without a forcing period.
    transient : int or float, default 0
        Points of the section, or time, to run before the record starts.
    at, max_return : optional
        The section, as in `poincare_section`.
    samples : int, optional
        Samples a period or return on the average (or in all of ``duration``); default 200.
    times : list of float, optional
        Model times at which states are given in place of ``samples``, in ascending order, from the end of the transient
        on; where no length is given the run ends with the last of them. They change neither steps nor events: a time
        is met by the interpolation of the method. One that coincides with an event shows the state before it. Not with
        a section by events or a surface.
    method : {"taylor", "dop853", "radau", "rk4"}
        Numerical method.
    tolerance : float, default 1e-12
        Local error a step, of every state relative to the size that it has had of late ("taylor", "dop853",
        "radau"); bisection of event times ("rk4").
    steps : int, optional
        Steps a period, for "rk4" only; default 200.
    max_events : int, optional
        Events followed in a period, beyond which a run ends with the outcome ``event_limit``; for systems without a
        period in all of the transient, and in all of the run after it. By default 10,000, or ten million without a
        period.
    max_stalls : int, default 50
        Events in succession without time passing, beyond which a run ends with the outcome ``stalled``.
    progress : callable or bool, optional
        Called with (done, total, None). True: a bar on a terminal or in a notebook, lines elsewhere; False: nothing;
        by default a bar where there is a terminal or a notebook, once it takes longer than a second.

    Returns
    -------
    xarray.Dataset
        ``states`` (time, state), ``mode`` (time), each quadrature (time), and over the dimension event: ``event_time``,
        ``event_kind``, ``event_speed``, ``event_mode_before``, ``event_mode_after``, ``event_state_before``,
        ``event_state_after``; ``outcome``. A run that ends early keeps what it has.

    Raises
    ------
    SettingsError
        An argument that cannot be used.
    """
    import numpy as np
    import xarray as xr

    from chaosdrill.analysis.sections import find_section, traced
    from chaosdrill.engine import layout as at

    path = traced(find_section(system, given, job.numerics), given, job)
    n, rows, found = len(system.states), path.rows, path.events
    targets = np.array([system.mode_names.index(t.target) for t in system.transitions], dtype=np.int8)
    ds = xr.Dataset(
        {
            "states": (("time", "state"), rows[:, :n]),
            "mode": ("time", rows[:, -1].astype(np.int8)),
            **{name: ("time", rows[:, n + i]) for i, name in enumerate(system.quadratures)},
            "event_time": ("event", found.times),
            "event_kind": ("event", found.events[:, at.EVENT_KIND].astype(np.int8)),
            "event_speed": ("event", found.events[:, at.EVENT_SPEED]),
            "event_mode_before": ("event", found.events[:, at.EVENT_MODE].astype(np.int8)),
            "event_mode_after": ("event", targets[found.events[:, at.EVENT_KIND].astype(int)]),
            "event_state_before": (("event", "state"), found.states_before()),
            "event_state_after": (("event", "state"), found.states_after()),
            "outcome": ((), np.int8(path.outcome)),
        },
        coords={"time": path.times, "state": list(system.state_names)},
    )
    if system.period is not None:
        ds["forcing_period"] = ((), system.forcing_period())
    return ds
