"""Multipliers that are 1 whatever the orbit: what a system's structure leaves neutral."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.model.derive import conserved_combinations, shift_directions

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem


@dataclass(frozen=True)
class Neutral:
    """What nothing ever changes.

    Attributes
    ----------
    flow : bool
        Whether nothing depends on time, so that an orbit shifted in time is an orbit.
    shifts : ndarray, shape (a, n)
        Directions in which an orbit can be shifted as a whole: right eigenvectors of every tangent map.
    conserved : ndarray, shape (b, n)
        Combinations of states whose deviations are kept: left eigenvectors of every tangent map.
    """

    flow: bool
    shifts: np.ndarray
    conserved: np.ndarray

    @property
    def paired(self) -> int:
        """How many shifts change conserved sums: each and its sum share one multiplier."""
        return int(np.linalg.matrix_rank(self.conserved @ self.shifts.T)) if self.shifts.size else 0

    @property
    def count(self) -> int:
        """How many multipliers of every orbit are 1."""
        return int(self.flow) + len(self.shifts) + len(self.conserved) - self.paired

    @property
    def held(self) -> np.ndarray:
        """Combinations of states, shape (m, n), which tell orbits of one family: conserved sums, if they tell all."""
        return self.conserved if self.paired == len(self.shifts) else self.shifts

    def words(self, system: "HybridSystem") -> str:
        """What there is beside the direction of the flow; empty if there is nothing."""
        parts = [f"it can be shifted along {_combination(v, system)}" for v in self.shifts]
        if not len(self.shifts):
            parts = [f"deviations of {_combination(v, system)} are kept" for v in self.conserved]
        if not parts:
            return ""
        return f"the orbit is one of a family, since {' and '.join(parts)}; {self.count} of its multipliers are 1"


def neutral_of(system: "HybridSystem") -> Neutral:
    """What a system's structure leaves neutral; derived once for all values of its parameters."""
    known: Neutral | None = system.shared.get("neutral")
    if known is None:
        n = len(system.states)
        if "shifts" not in system.shared:
            system.shared["shifts"] = shift_directions(system.placed)
        known = system.shared["neutral"] = Neutral(
            flow=system.time is None or not _explicit(system),
            shifts=np.reshape(np.array(system.shared["shifts"], dtype=float), (-1, n)),
            conserved=np.reshape(np.array(conserved_combinations(system.placed), dtype=float), (-1, n)),
        )
    return known


def _explicit(system: "HybridSystem") -> bool:
    """Whether time stands in any expression that a motion follows."""
    expressions = [rate for field in system.modes.values() for rate in field.values()]
    for transition in system.transitions:
        expressions += [transition.guard, *transition.reset.values()]
        expressions += [] if transition.condition is None else [transition.condition]
    return any(system.time in getattr(e, "free_symbols", ()) for e in expressions)


def _combination(vector: np.ndarray, system: "HybridSystem") -> str:
    """A combination of states in words, as in "x - z"."""
    terms = [(float(v), name) for v, name in zip(vector, system.state_names, strict=True) if v]
    parts = [f"{'-' if v < 0 else '+'} {'' if abs(v) == 1 else f'{abs(v):g} '}{name}" for v, name in terms]
    return " ".join(parts).removeprefix("+ ")
