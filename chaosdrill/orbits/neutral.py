"""Multipliers that are 1 by the structure of a system."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.engine.structure import symmetries_of

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem


@dataclass(frozen=True)
class Neutral:
    """Symmetry directions and conserved combinations of a system."""

    flow: bool  # whether an orbit shifted in time is an orbit
    symmetries: np.ndarray
    """(a, n): directions in which an orbit can be shifted as a whole: right eigenvectors of every tangent map."""
    conserved: np.ndarray
    """(b, n): combinations of states whose deviations are kept: left eigenvectors of every tangent map."""

    @cached_property
    def paired(self) -> int:
        """How many symmetries change conserved sums: each and its sum share one multiplier."""
        return int(np.linalg.matrix_rank(self.conserved @ self.symmetries.T)) if self.symmetries.size else 0

    @cached_property
    def count(self) -> int:
        """How many multipliers of every orbit are 1."""
        return int(self.flow) + len(self.symmetries) + len(self.conserved) - self.paired

    @cached_property
    def held(self) -> np.ndarray:
        """Combinations of states, shape (m, n), that distinguish orbits of a family: conserved sums, and shifts.

        A shift that changes a conserved sum is distinguished by that sum.
        """
        if not self.paired:
            return np.vstack([self.conserved, self.symmetries])
        shared = self.conserved @ self.symmetries.T
        return np.vstack([self.conserved, np.linalg.svd(shared)[2][self.paired :] @ self.symmetries])

    def words(self, system: "HybridSystem", count: int) -> str:
        """The neutral directions besides that of the flow, in words; empty without any.

        ``count``: how many multipliers are 1, with those of what was found to be conserved.
        """
        parts = [f"it can be shifted along {_combination(v, system)}" for v in self.symmetries]
        if not len(self.symmetries):
            parts = [f"deviations of {_combination(v, system)} are kept" for v in self.conserved]
        if count > self.count:
            parts.append("a quantity was found to be conserved")
        if not parts:
            return ""
        return f"the orbit is one of a family, since {' and '.join(parts)}; {count} of its multipliers are 1"


def neutral_of(system: "HybridSystem") -> Neutral:
    """What a system's structure leaves neutral; derived once for all values of its parameters."""
    known: Neutral | None = system.shared.get("neutral")
    if known is None:
        n = len(system.state_names)
        if "conserved" not in system.shared:
            from chaosdrill.model.derive import conserved_combinations

            found = np.reshape(conserved_combinations(system.placed), (-1, n)).astype(float)
            system.shared["conserved"] = _beside_flow(system, found).tolist()
        known = system.shared["neutral"] = Neutral(
            flow=system.autonomous,
            symmetries=np.reshape(np.array(symmetries_of(system), dtype=float), (-1, n)),
            conserved=np.reshape(np.array(system.shared["conserved"], dtype=float), (-1, n)),
        )
    return known


def _beside_flow(system: "HybridSystem", conserved: np.ndarray) -> np.ndarray:
    """Combinations whose deviations are kept, but for one that the flow itself changes: the two share a multiplier.

    Such a combination, as the phase of a clock among the states, grows steadily wherever the system is.
    """
    if not (system.autonomous and len(conserved)):
        return conserved
    placed = system.placed
    field = placed.modes[placed.mode_names[0]]
    rates = [sum(c * field[x] for c, x in zip(row, placed.states, strict=True)) for row in conserved.tolist()]
    numbers = {s: 1.1 + k for k, s in enumerate(sorted({s for e in rates for s in _symbols(e)}, key=str))}
    grown = np.array([float(e.xreplace(numbers)) if _symbols(e) else float(e) for e in rates])
    return conserved if not grown.any() else np.linalg.svd(grown[np.newaxis])[2][1:] @ conserved


def _symbols(expression: Any) -> Any:
    return getattr(expression, "free_symbols", ())


def _combination(vector: np.ndarray, system: "HybridSystem") -> str:
    """A combination of states in words, as in "x - z"."""
    terms = [(float(v), name) for v, name in zip(vector, system.state_names, strict=True) if v]
    parts = [f"{'-' if v < 0 else '+'} {'' if abs(v) == 1 else f'{abs(v):g} '}{name}" for v, name in terms]
    return " ".join(parts).removeprefix("+ ")
