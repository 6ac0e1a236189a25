"""All equilibria that are found from many starts, in every mode.

Powell's hybrid method (scipy) leads from each start to a zero of the rates, Newton's method from there to rounding. How
often the rarest were found says how many may have been missed (Good 1953, doi:10.1093/biomet/40.3-4.237).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.optimize

from chaosdrill.equilibrium.fields import Field, NoFieldError, field_of
from chaosdrill.equilibrium.points import Equilibrium, equilibrium, polished
from chaosdrill.equilibrium.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem


@dataclass(frozen=True)
class Found:
    """What a search has found."""

    equilibria: list[Equilibrium]  # mode by mode, in the order of their states
    hits: list[int]  # how many starts led to each
    refused: dict[str, str]  # modes in which none can be looked for, with the reasons
    starts: int  # how many starts there were


def search(
    system: "HybridSystem",
    modes: Sequence[str],
    starts: np.ndarray,
    sizes: np.ndarray,
    within: dict[int, tuple[float, float]],
) -> Found:
    """All equilibria to which starts lead.

    ``modes``: those that are looked at. ``starts``, shape (S, n). ``sizes``, shape (n,): how large each state is.
    ``within``: limits of states by their numbers, outside of which none counts.
    """
    values, own = list(system.parameters.values()), system.initial_values
    found, hits, refused = list[Equilibrium](), list[int](), dict[str, str]()
    for mode in modes:
        try:
            field = field_of(system, mode)
        except NoFieldError as reason:
            refused[mode] = str(reason)
            continue
        here, counts = _in_mode(field, field.numbers(own, values), starts, sizes, within)
        found += here
        hits += counts
    return Found(found, hits, refused, len(starts))


def _in_mode(
    field: Field, own: np.ndarray, starts: np.ndarray, sizes: np.ndarray, within: dict[int, tuple[float, float]]
) -> tuple[list[Equilibrium], list[int]]:
    free = list(field.free)
    found, counts = list[Equilibrium](), list[int]()
    for start in starts:
        begin = own.copy()
        begin[free] = start[free]
        zero = _led(field, begin, sizes[free])
        numbers = None if zero is None else polished(field, zero)
        if numbers is None:
            continue
        one = equilibrium(field, numbers)
        known = next((k for k, other in enumerate(found) if one.met(other, sizes[free])), None)
        if known is not None:
            counts[known] += 1
        elif _inside(one, within):
            found.append(one)
            counts.append(1)
    order = sorted(range(len(found)), key=lambda k: tuple((found[k].states / sizes).round(9)))
    return [found[k] for k in order], [counts[k] for k in order]


def _led(field: Field, begin: np.ndarray, sizes: np.ndarray) -> np.ndarray | None:
    """Where the hybrid method leads; each rate counts in its largest change over a size."""
    free, origin = list(field.free), begin[list(field.free)]
    scaled = np.abs(field.jacobian(begin)) * sizes
    rows = np.where(np.isfinite(most := scaled.max(axis=1)) & (most > 0), most, 1.0)

    def at(z: np.ndarray) -> np.ndarray:
        here = begin.copy()
        here[free] = origin + sizes * z
        return here

    def rates(z: np.ndarray) -> np.ndarray:
        return np.nan_to_num(field.rate(at(z)) / rows, nan=1e30, posinf=1e30, neginf=-1e30)

    def slopes(z: np.ndarray) -> np.ndarray:
        return np.nan_to_num(field.jacobian(at(z)) * sizes / rows[:, np.newaxis])

    with np.errstate(all="ignore"):
        result = scipy.optimize.root(
            rates, np.zeros(len(free)), jac=slopes, method="hybr", options={"xtol": TUNING.hybrid}
        )
    return at(result.x) if np.isfinite(result.x).all() else None


def _inside(one: Equilibrium, within: dict[int, tuple[float, float]]) -> bool:
    states, errors = one.states, one.state_errors()
    return all(low - errors[i] <= states[i] <= high + errors[i] for i, (low, high) in within.items())
