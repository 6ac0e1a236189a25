"""What the search for an orbit and the following of a branch give, as plain values.

Throughout, n is the number of states, k the period in forcing periods (1 for autonomous systems), E the number of
events in one period, P the number of points of all branches together, q the number of free parameters.
"""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset.branches import BranchEnd, Criticality, Onset, Special
from chaosdrill.dataset.outcomes import Outcome

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.problem import Problem, Shot


@dataclass(frozen=True)
class Checks:
    """What an orbit's numbers say of each other."""

    exponents: np.ndarray  # (n,): Lyapunov exponents of the orbit by the QR method, descending; -inf where rank is lost
    exponent_difference: float  # largest difference between them and log|multiplier| / duration
    determinant_difference: float
    """Difference between the product of the multipliers and the product of the contractions (divergence of the field,
    determinants at the events), relative to the larger of the two."""
    recurrence_difference: float  # largest distance after one more period, relative to the sizes of the states
    consistent: bool  # whether all of them are within what round-off and the tolerance explain
    disagreements: str = ""  # what is not, in words; empty if all is well


@dataclass(frozen=True)
class Derived:
    """Derivatives by q parameters of the results on an orbit with E events; NaN where unknown."""

    values: dict[str, np.ndarray]
    """By name: ``orbit_state`` (n, q), ``period_time`` (q,), ``event_time`` (E, q), ``rates`` (r, q) of the r
    quadratures, complex ``multiplier`` (n, q), ``lyapunov_exponent`` (n, q)."""
    errors: dict[str, np.ndarray]  # of the same names; complex for both parts of what is complex
    means: np.ndarray  # (r,): the mean rates of the quadratures themselves
    message: str = ""  # why some or all are missing; empty if none is


def underived(system: "HybridSystem", count: int, events: int, message: str) -> Derived:
    """Missing derivatives by ``count`` parameters, with the reason."""
    n, r = len(system.state_names), len(system.quadratures)
    shapes: dict[str, tuple[int, ...]] = {
        "orbit_state": (n,),
        "period_time": (),
        "event_time": (events,),
        "rates": (r,),
        "lyapunov_exponent": (n,),
    }
    none = {name: np.full((*shape, count), np.nan) for name, shape in shapes.items()}
    none["multiplier"] = np.full((n, count), complex(np.nan, np.nan))
    return Derived(none, none, np.full(r, np.nan), message)


@dataclass(frozen=True)
class FoundOrbit:
    """A periodic orbit, or the reason why none was found.

    Without an orbit, arrays have no rows (``multipliers`` is NaN) and numbers are NaN; ``period`` is the one asked
    for.
    """

    outcome: Outcome  # ``Outcome.PERIODIC`` if an orbit was found, and nothing else then
    message: str  # what there is to say of it; empty if all is well
    period: int  # least period in forcing periods; 1 for autonomous systems
    duration: float  # time of one period of the orbit
    states: np.ndarray
    """(k, n): states at the strobes, the one at phase 0 of the first period first; autonomous systems: at the start of
    the first segment, behind its event."""
    section: np.ndarray  # (m, n): points on the section, before its events; without a section the same
    mode: int  # mode at the first of the states
    multipliers: np.ndarray
    """complex (n,): eigenvalues of the tangent map over one period, by falling modulus; exactly 0 where rank is
    lost."""
    rank: int  # rank of the tangent map
    residual: float
    """Largest difference after one period in a run of the engine, relative to the sizes of the states; where small
    deviations grow very much over it, the run restarts on the orbit after each part of it."""
    newton: np.ndarray  # (iterations,): residual after each step of Newton's method, the start's first
    event_times: np.ndarray  # (E,): times since the first of the strobes
    event_speeds: np.ndarray  # (E,): rates of the guards, as they are written, where they are met
    event_transitions: np.ndarray  # int (E,): index of the transition taken
    event_states_before: np.ndarray  # (E, n)
    event_states_after: np.ndarray  # (E, n)
    checks: Checks  # what the numbers say of each other
    path_times: np.ndarray
    """(m,): times since the first of the strobes over one period, both ends included; an event has two."""
    path_states: np.ndarray  # (m, n)
    neutral: int = 0  # how many multipliers are 1 by the structure of the system, that of the flow direction among them
    derived: Derived | None = None  # its derivatives by parameters, if they were asked for
    solved: "tuple[Problem, Orbit, Shot] | None" = None  # what was solved; None without an orbit


@dataclass(frozen=True)
class BranchInfo:
    """One branch: where it began and how it ended."""

    parent: int  # number of the branch that it branches off; -1 if it was started from outside
    period: int  # period of its orbits
    start: str  # in words
    end: str  # in words
    end_code: BranchEnd  # the end as a code


@dataclass(frozen=True)
class NormalForm:
    """The coefficient that decides what is born at a special point."""

    criticality: Criticality
    coefficient: float = float("nan")
    """Of the cubic term, positive where it drives back what moves away; of states in parts of their root mean
    squares along the orbit, for a critical eigenvector of mean square 1 there. NaN without one."""
    error: float = float("nan")


NO_FORM = NormalForm(Criticality.NONE)


@dataclass(frozen=True)
class GrazingForm:
    """The leading term of the return map beside a grazing point, and what follows."""

    onset: Onset
    power: float = float("nan")  # of the guard's greatest value, y > 0 where the event happens; NaN if it is not known
    coefficient: float = float("nan")
    """What that power of y, times this, adds to the next greatest value, in units of the guard; NaN without one."""
    error: float = float("nan")
    decisive: int = 0
    """Number of the return after an event that decides: for a jump the first above the guard; undecided: the first that
    is as high as the guard, a resonance. 0 where none does."""


NO_GRAZING = GrazingForm(Onset.NONE)


@dataclass(frozen=True)
class SpecialPoint:
    """A point of a branch at which something happens, located."""

    point: int  # number of the point among all
    code: Special  # what happens
    values: np.ndarray  # (q,): the free parameters there
    error: float  # estimated error of the first of them
    text: str  # in words, with what becomes of the branch, as in "impact appears; the branch continues"
    multiplicity: int = 0  # how many multipliers are on the unit circle there; 0 where events change, and they jump
    form: NormalForm = NO_FORM  # what is born there
    grazing: GrazingForm = NO_GRAZING  # what follows where events change at no speed


@dataclass(frozen=True)
class Cascade:
    """Period doublings one after the other, and where they lead."""

    values: np.ndarray  # (D,): parameter at each doubling
    periods: np.ndarray  # int (D,): period of the orbit that doubles there
    ratios: np.ndarray
    """(D,): (values[d-1] - values[d-2]) / (values[d] - values[d-1]), the ratio that tends to Feigenbaum's 4.669; NaN
    for the first two."""
    limit: float  # accumulation point of the doublings
    limit_error: float  # its estimated error


@dataclass(frozen=True)
class BranchResult:
    """Branches of periodic orbits: their points one branch after the other, and what happens on them."""

    parameters: tuple[str, ...]  # the q free parameters: one, or two for a curve of special points
    values: np.ndarray  # (P, q): their values
    branch: np.ndarray  # int (P,): number of the branch that a point belongs to, from 0
    arclength: np.ndarray  # (P,): along the branch from its start
    period: np.ndarray  # int (P,): period in forcing periods
    duration: np.ndarray  # (P,): time of one period
    state: np.ndarray  # (P, n): the first of the states of `FoundOrbit`
    section: np.ndarray  # (P, k, n): as in `FoundOrbit`, as many as any orbit has; NaN beyond the own ones
    mode: np.ndarray  # int (P,): mode in that state
    multipliers: np.ndarray  # complex (P, n): as in `FoundOrbit`
    stable: np.ndarray
    """bool (P,): whether small deviations die out; on a curve of special points: by all multipliers but those on the
    unit circle."""
    special: np.ndarray  # int (P,): codes of `Special`
    sequence: np.ndarray  # int (P,): which of ``sequences`` the events of one period follow
    sequences: tuple[str, ...]  # names of the transitions in order, as in "slip impact stick"
    smallest_speed: np.ndarray  # (P,): smallest speed at which a guard is met; infinite without events
    residual: np.ndarray  # (P,): as in `FoundOrbit`
    branches: tuple[BranchInfo, ...]  # what each branch is
    events: tuple[SpecialPoint, ...]  # the special points in order of their points
    cascade: Cascade | None = None  # period doublings in a row, where doubled branches were followed
    outcome: Outcome = Outcome.PERIODIC
    """Of the search for the orbit that the first branch starts from; ``Outcome.PERIODIC`` if there is one."""
    message: str = ""  # a remark on the start, such as why it has no branch; empty if all is well
    neutral: int = 0  # as in `FoundOrbit`
    orbits: tuple[tuple["Problem", "Orbit", int], ...] = ()  # (P,): what was solved, and the rank of the tangent map
    functions: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))
    """(P, F): functions of the orbits, as many as were asked for."""
    function_errors: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))  # (P, F)
