"""What the search for an orbit and the following of a branch give, as plain values.

Throughout, n is the number of states, k the period in forcing periods (1 for autonomous systems), E the number of
events in one period, P the number of points of all branches together, q the number of free parameters.
"""

from dataclasses import dataclass

import numpy as np

from chaosdrill.dataset.branches import BranchEnd, Special
from chaosdrill.dataset.outcomes import Outcome


@dataclass(frozen=True)
class Checks:
    """What an orbit's numbers say of each other.

    Attributes
    ----------
    exponents : ndarray, shape (n,)
        Lyapunov exponents of the orbit by the QR method, descending; -inf where rank is lost.
    exponent_difference : float
        Largest difference between them and log|multiplier| / duration.
    determinant_difference : float
        Difference between the product of the multipliers and the product of the contractions (divergence of the
        field, determinants at the events), relative to the larger of the two.
    recurrence_difference : float
        Largest distance after one more period, relative to max(1, |x|).
    consistent : bool
        Whether all of them are within what round-off and the tolerance explain.
    disagreements : str
        What is not, in words; empty if all is well.
    """

    exponents: np.ndarray
    exponent_difference: float
    determinant_difference: float
    recurrence_difference: float
    consistent: bool
    disagreements: str = ""


@dataclass(frozen=True)
class FoundOrbit:
    """A periodic orbit, or why there is none.

    Where there is none, arrays have no rows (``multipliers`` is NaN) and numbers are NaN; ``period`` is the one asked
    for.

    Attributes
    ----------
    outcome : Outcome
        ``Outcome.PERIODIC`` if an orbit was found, and nothing else then.
    message : str
        What there is to say of it; empty if all is well.
    period : int
        Least period in forcing periods; 1 for autonomous systems.
    duration : float
        Time of one period of the orbit.
    states : ndarray, shape (k, n)
        States at the strobes, the one at phase 0 of the first period first; autonomous systems: at the start of the
        first segment.
    mode : int
        Mode at the first of them.
    multipliers : ndarray of complex, shape (n,)
        Eigenvalues of the tangent map over one period, by falling modulus; exactly 0 where rank is lost.
    rank : int
        Rank of the tangent map.
    residual : float
        Largest difference after one period in a run of the engine, relative to max(1, |x|); where small deviations
        grow very much over it, after parts of it, from each of which the run begins anew on the orbit.
    newton : ndarray, shape (iterations,)
        Residual after each step of Newton's method, the start's first.
    event_times, event_speeds : ndarray, shape (E,)
        Times since phase 0, and rates of the guards as they are met.
    event_transitions : ndarray of int, shape (E,)
        Index of the transition taken.
    event_states_before, event_states_after : ndarray, shape (E, n)
        States before and after each event.
    checks : Checks
        What the numbers say of each other.
    neutral : int
        How many multipliers are 1 by the structure of the system, that of the flow direction among them.
    """

    outcome: Outcome
    message: str
    period: int
    duration: float
    states: np.ndarray
    mode: int
    multipliers: np.ndarray
    rank: int
    residual: float
    newton: np.ndarray
    event_times: np.ndarray
    event_speeds: np.ndarray
    event_transitions: np.ndarray
    event_states_before: np.ndarray
    event_states_after: np.ndarray
    checks: Checks
    neutral: int = 0


@dataclass(frozen=True)
class BranchInfo:
    """One branch: where it began and how it ended.

    Attributes
    ----------
    parent : int
        Number of the branch that it branches off; -1 if it was started from outside.
    period : int
        Period of its orbits.
    start, end : str
        Both in words.
    end_code : BranchEnd
        The end as a code.
    """

    parent: int
    period: int
    start: str
    end: str
    end_code: BranchEnd


@dataclass(frozen=True)
class SpecialPoint:
    """A point of a branch at which something happens, located.

    Attributes
    ----------
    point : int
        Number of the point among all.
    code : Special
        What happens.
    values : ndarray, shape (q,)
        The free parameters there.
    error : float
        Estimated error of the first of them.
    text : str
        In words, with what becomes of the branch, as in "impact appears; the branch continues".
    """

    point: int
    code: Special
    values: np.ndarray
    error: float
    text: str


@dataclass(frozen=True)
class Cascade:
    """Period doublings one after the other, and where they lead.

    Attributes
    ----------
    values : ndarray, shape (D,)
        Parameter at each doubling.
    periods : ndarray of int, shape (D,)
        Period of the orbit that doubles there.
    ratios : ndarray, shape (D,)
        (values[d-1] - values[d-2]) / (values[d] - values[d-1]), the ratio that tends to Feigenbaum's 4.669; NaN for the
        first two.
    limit, limit_error : float
        Accumulation point of the doublings, and its estimated error.
    """

    values: np.ndarray
    periods: np.ndarray
    ratios: np.ndarray
    limit: float
    limit_error: float


@dataclass(frozen=True)
class BranchResult:
    """Branches of periodic orbits: their points one branch after the other, and what happens on them.

    Attributes
    ----------
    parameters : tuple of str
        The q free parameters: one, or two for a curve of special points.
    values : ndarray, shape (P, q)
        Their values.
    branch : ndarray of int, shape (P,)
        Number of the branch that a point belongs to, from 0.
    arclength : ndarray, shape (P,)
        Along the branch from its start.
    period : ndarray of int, shape (P,)
        Period in forcing periods.
    section : ndarray, shape (P, k, n)
        States at the strobes as in `FoundOrbit`, with the longest period of all; NaN beyond the own period.
    mode : ndarray of int, shape (P,)
        Mode at the first strobe.
    multipliers : ndarray of complex, shape (P, n)
        As in `FoundOrbit`.
    stable : ndarray of bool, shape (P,)
        Whether small deviations die out; on a curve of special points: by all multipliers but the one that is 1 or -1.
    special : ndarray of int, shape (P,)
        Codes of `Special`.
    sequence : ndarray of int, shape (P,)
        Which of ``sequences`` the events of one period follow.
    sequences : tuple of str
        Names of the transitions in order, as in "slip impact stick".
    smallest_speed : ndarray, shape (P,)
        Smallest speed at which a guard is met; infinite without events.
    residual : ndarray, shape (P,)
        As in `FoundOrbit`.
    branches : tuple of BranchInfo
        What each branch is.
    events : tuple of SpecialPoint
        The special points in order of their points.
    cascade : Cascade, optional
        Period doublings in a row, where doubled branches were followed.
    outcome : Outcome
        Of the search for the orbit that the first branch starts from; ``Outcome.PERIODIC`` if there is one.
    message : str
        What there is to say of the start, as why there is no branch; empty if all is well.
    neutral : int
        As in `FoundOrbit`.
    """

    parameters: tuple[str, ...]
    values: np.ndarray
    branch: np.ndarray
    arclength: np.ndarray
    period: np.ndarray
    section: np.ndarray
    mode: np.ndarray
    multipliers: np.ndarray
    stable: np.ndarray
    special: np.ndarray
    sequence: np.ndarray
    sequences: tuple[str, ...]
    smallest_speed: np.ndarray
    residual: np.ndarray
    branches: tuple[BranchInfo, ...]
    events: tuple[SpecialPoint, ...]
    cascade: Cascade | None = None
    outcome: Outcome = Outcome.PERIODIC
    message: str = ""
    neutral: int = 0
