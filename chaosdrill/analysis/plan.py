"""How every point of a sweep is measured: lengths, section, exponents, numerics."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.analysis.arguments import section_transitions, tangent_count
from chaosdrill.analysis.base import Points
from chaosdrill.engine.ahead import LANES, compile_ahead
from chaosdrill.engine.batch import Batch
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.structure import Structure, examine
from chaosdrill.sweep.fingerprint import of_system, origin

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

BLOCKS = 32
"""Blocks over which exponents are averaged, for their standard errors."""

SMALL = 6
"""States up to which all exponents are computed, however few are asked for: a point is then the same to the bit for any
number of them, also where chaos dies out just before or after the end of a record. Beyond, tangents take most of the
time."""

LEAST_ROWS = 16
"""Section points that are compared at least."""


@dataclass(frozen=True)
class Plan:
    """What is done at every point.

    Attributes
    ----------
    system : HybridSystem
        The system at its own parameters.
    transient, periods : int
        Forcing periods before the averages, and of the averages.
    section : frozenset of int or None
        Transitions before which section points are taken; None for the strobe.
    max_period : int
        Longest period looked for.
    patience : int
        How many times as long as ``periods`` a point may run on that is undecided; 0: it is taken as it is.
    exponents : int
        Number of exponents that are asked for.
    computed : int
        Number of those that are computed: all in a small system, else of those that are not zero whatever happens two
        at least.
    structure : Structure
        What is known of the tangents.
    deficient : frozenset of int
        Transitions at which rank may be lost at some point of the sweep.
    rows : int
        Section points that are kept at every point.
    """

    system: "HybridSystem"
    transient: int
    periods: int
    section: frozenset[int] | None
    max_period: int
    patience: int
    numerics: Numerics
    exponents: int
    computed: int
    structure: Structure
    deficient: frozenset[int]
    rows: int = 0

    @property
    def window(self) -> int:
        """Section points by which a point is judged."""
        return max(self.rows, 2 * self.max_period, LEAST_ROWS)

    @property
    def ends(self) -> np.ndarray:
        """Ends of the blocks, in periods."""
        return block_ends(self.periods)

    def batch(self, parameters: Mapping[str, np.ndarray], starts: np.ndarray, modes: np.ndarray) -> Batch:
        """Runs that measure what the plan asks for."""
        frame, shifts = self.structure.tangents(self.computed) if self.computed else (None, 0)
        return Batch(
            self.system,
            parameters,
            starts,
            modes,
            self.numerics,
            tangents=frame,
            shifts=shifts,
            deficient=self.deficient,
            section=None if self.section is None else set(self.section),
            window=self.window,
        )

    def fingerprint(self) -> dict[str, Any]:
        """Everything of the plan that determines the numbers, as plain values."""
        return {
            "system": of_system(self.system),
            "transient": self.transient,
            "periods": self.periods,
            "section": None if self.section is None else sorted(self.section),
            "max_period": self.max_period,
            "patience": self.patience,
            "exponents": self.exponents,
            "section_points": self.rows,
            "numerics": asdict(self.numerics),
            **origin(),
        }

    def strobed(
        self, parameters: Mapping[str, np.ndarray], starts: np.ndarray, modes: np.ndarray, window: int
    ) -> Batch:
        """Runs without tangents whose section is at the strobe."""
        return Batch(self.system, parameters, starts, modes, self.numerics, window=window)


def block_ends(periods: int, unit: int = 1) -> np.ndarray:
    """Ends of the blocks of a record of so many units of so many periods, in periods."""
    return np.unique(np.linspace(0, periods, min(BLOCKS, periods) + 1).astype(int)) * unit


def make_plan(
    system: "HybridSystem", given: Points, numerics: Numerics, *, swept: tuple[str, ...] = (), rows: int = 0
) -> Plan:
    """What is done at every point of an analysis; ``swept`` are the parameters that differ between the points.

    So many ``rows`` of the section are kept at every point.
    """
    section = section_transitions(system, given.at)
    chosen = None if section is None else frozenset(section)
    count = tangent_count(system, given.exponents)
    if numerics.method == "taylor":
        compile_ahead(LANES)
    structure = examine(system)
    # of a complex pair only both exponents together are known well, and tangents are stepped in pairs anyway
    n = len(system.states)
    enough = (n if n <= SMALL else max(count, min(structure.most_neutral + 2, n))) if count else 0
    in_resets = {
        i
        for i, t in enumerate(system.transitions)
        if any(s.name in swept for value in t.reset.values() for s in value.free_symbols)
    }
    return Plan(
        system=system,
        transient=given.transient,
        periods=given.periods,
        section=chosen,
        max_period=given.max_period,
        patience=given.patience,
        numerics=numerics,
        exponents=count,
        computed=enough,
        structure=structure,
        # a rank can depend on a parameter that a reset names: then it is looked for at every event
        deficient=structure.deficient | in_resets,
        rows=rows,
    )
