"""How every point of a sweep is measured: lengths, section, exponents, numerics."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any, cast

import numpy as np

from chaosdrill.analysis.arguments import tangent_count
from chaosdrill.analysis.base import Points
from chaosdrill.analysis.judgement.statistics import block_ends
from chaosdrill.analysis.judgement.tori import LENGTH
from chaosdrill.analysis.sections import Section, find_section
from chaosdrill.analysis.tuning import ATTRACTORS, PLAN
from chaosdrill.engine.ahead import LANES, compile_ahead
from chaosdrill.engine.batch import Batch, Returns
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.shifts import Shifts, shifts_of
from chaosdrill.engine.structure import Structure, examine
from chaosdrill.model import HybridSystem
from chaosdrill.sweep.fingerprint import of_system, origin


@dataclass(frozen=True)
class SweptShifts(Shifts):
    """Shifts of a sweep that may change circles: the states that run round these are angles all the same."""

    angles: np.ndarray  # bool (d,): which states are angles at the system's own parameters

    @cached_property
    def bounded(self) -> np.ndarray:
        """bool (d + k,): which coordinates of the quotient are those of circles."""
        found = super().bounded.copy()
        found[: len(self.angles)] |= self.angles
        return found


@dataclass(frozen=True)
class Plan:
    """What is done at every point."""

    where: Section
    """The system at its own parameters, where points are taken, and what lengths count: a unit of them is a strobe, a
    point of the section, or one of `PARTS` of a duration."""
    transient: int  # units before the averages
    periods: int  # units of the averages
    part: float  # time between strobes of a system without a forcing period
    max_period: int  # longest period looked for
    max_extension: (
        int  # how many times as long as ``periods`` a point may run on that is undecided; 0: it is taken as it is
    )
    numerics: Numerics
    exponents: int  # number of exponents that are asked for
    computed: int
    """Number of those that are computed: all in a small system, else of those that are not zero whatever happens two at
    least."""
    structure: Structure  # what is known of the tangents
    deficient: frozenset[int]  # transitions at which rank may be lost at some point of the sweep
    shifts: Shifts  # shifts of states that change nothing at any point of the sweep
    rows: int = 0  # section points that are kept at every point

    @property
    def system(self) -> HybridSystem:
        """The system at its own parameters."""
        return self.where.system

    @property
    def section(self) -> frozenset[int] | None:
        """Transitions before which section points are taken; None for the strobe, or for the parts of a duration."""
        return self.where.transitions

    @property
    def maps(self) -> bool:
        """Whether there is a map from point to point: of strobes, or of a section of a system free of time."""
        return self.system.forced or self.at_events

    @property
    def at_events(self) -> bool:
        """Whether that map is one of a section, not of strobes; also where lengths are counted otherwise."""
        return not self.system.forced and self.system.autonomous and self.section is not None

    @property
    def compared(self) -> int:
        """Section points among which a period is looked for."""
        return max(2 * self.max_period, PLAN.least_rows)

    @property
    def judged(self) -> int:
        """Section points by which a point is judged, however many are kept."""
        return max(self.compared, min(self.periods, PLAN.most_rows))

    @property
    def window(self) -> int:
        """Section points that runs hold: by which a point is judged, and that are kept."""
        return max(self.rows, self.judged)

    @property
    def ends(self) -> np.ndarray:
        """Ends of the blocks, in units."""
        return block_ends(self.periods, PLAN.blocks)

    def batch(
        self, parameters: Mapping[str, np.ndarray], starts: np.ndarray, modes: np.ndarray, *, of_map: bool = False
    ) -> Batch:
        """Runs that measure what the plan asks for; ``of_map`` lets lengths count steps of the map."""
        frame, symmetries = self.structure.tangents(self.computed) if self.computed else (None, 0)
        with_tangents: dict[str, Any] = {"tangents": frame, "symmetries": symmetries, "deficient": self.deficient}
        returns = self.at_events if of_map else self.where.counts == "section"
        return self._runs(parameters, starts, modes, self.section, returns=returns, window=self.window, **with_tangents)

    def mapped(self, parameters: Mapping[str, np.ndarray], starts: np.ndarray, modes: np.ndarray, window: int) -> Batch:
        """Runs without tangents over steps of the map: the states at strobes, or after the events of the section.

        Where there is no map they are those at the ends of parts of the duration.
        """
        section = self.section if self.at_events else None
        return self._runs(parameters, starts, modes, section, returns=self.at_events, after=True, window=window)

    def section_of_map(self, parameters: Mapping[str, np.ndarray], starts: np.ndarray, modes: np.ndarray) -> Batch:
        """Runs without tangents over steps of the map, and all points of the section that are kept."""
        return self._runs(parameters, starts, modes, self.section, returns=self.at_events, window=self.window)

    def passages(
        self, parameters: Mapping[str, np.ndarray], starts: np.ndarray, modes: np.ndarray, transition: int
    ) -> Batch:
        """Runs without tangents from event to event of a transition, and the states after them."""
        return self._runs(parameters, starts, modes, {transition}, returns=True, after=True, window=LENGTH)

    def uneven(self) -> "Plan":
        """The same with parts of a duration, if there are any, of which a record is no simple multiple."""
        if self.where.counts != "time":
            return self
        part = ATTRACTORS.uneven * self.part
        return replace(self, part=part, transient=int(-(-self.transient * self.part // part)))

    def at_instants(self) -> "Plan":
        """The same with `LENGTH` parts of its duration, or a few more."""
        finer = -(-LENGTH // self.periods)
        return replace(self, part=self.part / finer, transient=self.transient * finer, periods=self.periods * finer)

    def at_instants_of(self, begin: float, length: float) -> "Plan":
        """The same with a record that begins then and takes so long, in the parts in which spectra look at one.

        They are so many more than `LENGTH` that instants do not fall on a few phases of the turns only.
        """
        parts = LENGTH + LENGTH // 8
        return replace(self, part=length / parts, transient=round(begin * parts / length), periods=parts)

    def instants(self, parameters: Mapping[str, np.ndarray], starts: np.ndarray, modes: np.ndarray) -> Batch:
        """Runs without tangents, and their states at the ends of all parts of the duration."""
        return self._runs(parameters, starts, modes, None, returns=False, window=self.periods)

    def bare(self, parameters: Mapping[str, np.ndarray], starts: np.ndarray, modes: np.ndarray) -> Batch:
        """Runs whose lengths are counted as those of `batch`, without tangents and section points."""
        returns = self.where.counts == "section"
        return self._runs(parameters, starts, modes, self.section if returns else None, returns=returns)

    def _runs(
        self,
        parameters: Mapping[str, np.ndarray],
        starts: np.ndarray,
        modes: np.ndarray,
        section: Iterable[int] | None,
        *,
        returns: bool,
        after: bool = False,
        **more: Any,
    ) -> Batch:
        """Runs whose lengths count the points of a section, if it ``returns``, or strobes and parts of a duration."""
        return Batch(
            self.system,
            parameters,
            starts,
            modes,
            self.numerics,
            section=None if section is None else set(section),
            unit=self.where.unit if returns else self.part,
            returns=Returns(self.where.longest, after=after) if returns else None,
            **more,
        )

    def fingerprint(self) -> dict[str, Any]:
        """Everything of the plan that determines the numbers, as plain values."""
        return {
            "system": of_system(self.system),
            "counts": self.where.counts,
            "unit": self.where.unit,
            "max_return": self.where.longest,
            "transient": self.transient,
            "periods": self.periods,
            "part": self.part,
            "section": None if self.section is None else sorted(self.section),
            "max_period": self.max_period,
            "max_extension": self.max_extension,
            "exponents": self.exponents,
            "section_points": self.rows,
            "numerics": asdict(self.numerics),
            **origin(),
        }


def make_plan(
    system: HybridSystem, given: Points, numerics: Numerics, *, swept: tuple[str, ...] = (), rows: int = 0
) -> Plan:
    """What is done at every point of an analysis; ``swept`` are the parameters that differ between the points.

    ``rows``: how many rows of the section are kept at every point.
    """
    where = find_section(system, given, numerics, timed=True)
    system, part = where.system, 1.0
    transient, periods = given.transient, given.periods
    if where.counts == "time":
        part, periods = cast(float, given.duration) / PLAN.parts, PLAN.parts
        transient = -(-float(given.transient) // part)
    count = tangent_count(system, given.exponents)
    if numerics.traits.lanes and not system.discrete:
        compile_ahead(LANES)
    structure = examine(system)
    # of a complex pair only both exponents together are known well, and tangents are stepped in pairs anyway
    n = system.free
    enough = (n if n <= PLAN.small else max(count, min(structure.most_neutral + 2, n))) if count else 0
    shifts = shifts_of(system, but_of=swept)
    in_resets = {i for i, t in enumerate(system.transitions) if not t.in_reset().isdisjoint(swept)}
    return Plan(
        where=where,
        transient=int(transient),
        periods=int(cast(int, periods)),
        part=part,
        max_period=given.max_period,
        max_extension=given.max_extension,
        numerics=numerics,
        exponents=count,
        computed=enough,
        structure=structure,
        # a rank can depend on a parameter that a reset names: then it is looked for at every event
        deficient=structure.deficient | in_resets,
        shifts=SweptShifts(shifts.lines, shifts.turns, shifts_of(system, but_of=()).bounded[: len(system.state_names)]),
        rows=rows,
    )
