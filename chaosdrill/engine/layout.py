"""What a run is made of: settings, its state as one record, and the arrays that go with it, by their names.

Nothing here is compiled. `chaosdrill.engine.records` has the types of all this for compiled code.
"""

from typing import Any, NamedTuple

import numpy as np

from chaosdrill.codegen.signatures import WIDTH
from chaosdrill.declared import METHODS

SETTINGS = np.dtype(
    [
        *((name, np.int64) for name in ("method", "order", "quadratures", "samples", "recording", "orthonormalise")),
        *((name, np.int64) for name in ("absolute_time", "max_events", "max_stalls", "target", "own_jacobian")),
        *((name, np.float64) for name in ("tolerance", "reach", "dense_noise")),
    ],
    align=True,
)
"""What holds for all runs of a batch; ``target`` is the number of strobes at which a call ends, ``recording`` says what
is recorded: nothing, ``EVENLY`` so many samples a period, or states at ``INSTANTS`` that the buffer's rows hold,
``dense_noise`` is the rounding units by which the dense output of the method moves the polynomial of a state."""

EVENLY, INSTANTS = 1, 2

RUN = np.dtype(
    [
        *((name, np.int64) for name in ("mode", "strobes", "live", "fresh", "fired", "surface", "way", "moved_by")),
        ("turning", np.int64),
        *((name, np.int64) for name in ("sample", "sample_rows", "event_rows", "steps", "evaluations")),
        *((name, np.int64) for name in ("ties", "events_in_period", "stalls", "qr_wait", "qr_since", "rank_check")),
        *((name, np.int64) for name in ("blocked", "waiting")),
        *((name, np.float64) for name in ("time", "origin", "whole", "rest", "period", "fixed_step", "longest")),
        *((name, np.float64) for name in ("next_step", "tried", "strength", "residual", "wait_until", "wait_above")),
    ],
    align=True,
)
"""Where a run stands.

The time is ``origin + whole + rest + time``: whole periods as an exact sum of two doubles, then the time since the last
strobe. ``fired`` and ``surface`` name the guard that has just fired and its surface, ``way`` is the side to which that
was crossed (0 where a reset has thrown the state across), ``moved_by`` the transition that was then taken, ``residual``
what the guard's value was at the event. ``turning`` says whether a guard that was passed comes back in the step,
``blocked`` which of the mode's steep operations has ended the run, -1 for none. Rebounds from the guard
``waiting`` are not over before ``wait_until``, as long as they are faster than ``wait_above``.
"""


class Tables(NamedTuple):
    """What is known of a system's events and states, whatever the run."""

    active: Any
    """(modes, 1 + guards): number of guards, then their directions"""
    keys: Any
    """(modes, guards): number of a guard with its direction, the same in all modes"""
    surfaces: Any
    """(modes, guards): number of the surface on which a guard is zero"""
    watched: Any
    """(modes, keys): whether a mode watches a guard"""
    marks: Any
    """(modes, guards): bits that describe a guard, see MARKS, ..."""
    transitions: Any
    """(transitions, 5): TO_MODE, MARKS_ONLY, RANK_DEFICIENT, COMPLETES, COMPLETED"""
    moves: Any
    """(transitions, keys): whether the reset may change the guard's value"""
    returns: Any
    """(transitions, 2): guards that what is thrown off a surface meets there again, from above and from below, or -1"""
    bounds: Any
    """(2, n): lower and upper bounds of the states"""
    symmetries: Any
    """(k, n): directions in which nothing ever changes"""
    constrained: Any
    """(modes, n): states that a mode leaves no freedom"""
    held: Any
    """(modes,): number of surfaces that a mode holds; ``guard`` knows them behind the guards"""
    slack: Any
    """(n,): how far states may lie off the guards on which a run begins"""
    steep: Any
    """(modes, 1 + operations): number of steep operations, then the rows of what they are applied to, where such are"""
    shapes: Any
    """(modes, operations, 7): `codegen.layout.Shape` of each"""


class States(NamedTuple):
    """All that P runs carry from step to step; the first axis of every array is the run."""

    run: Any
    """(P,) of RUN"""
    c: Any
    """(P, constants)"""
    x: Any
    """(P, n)"""
    scale: Any
    """(P, n + q): sizes that states have had of late, and what integrals have moved in a step"""
    sums: Any
    """(P, 3, q): quadratures as compensated sums, and how far they have moved in all"""
    vectors: Any
    """(P, m, n): tangents, one a row"""
    exponent_of: Any
    """(P, m): the exponent to which a live tangent belongs"""
    lost: Any
    """(P, m): whether an exponent's tangent is lost"""
    logs: Any
    """(P, m): logarithms of the tangents' growth, but for its last factors"""
    grown: Any
    """(P, m): the product of these"""
    sooner: Any
    """(P, m): by how much the last event comes sooner along a live tangent"""
    shares: Any
    """(P, m, m), or (P, 0, 0) where nobody asks: of which tangents at the start of a block each was made, in parts of
    its own; rows and columns are exponents, and ``logs`` counts from that start, too"""
    sides: Any
    """(P, keys): side of every guard: -1, 1, 0 where it is not known, times ``guards.JUMPED``, ``PUT_ACROSS``, ``HELD``
    or ``PLACED``"""
    counts: Any
    """(P, transitions)"""
    grazing: Any
    """(P, transitions): smallest normal speed met"""
    hardest: Any
    """(P, keys): largest normal speed met since rebounds from the guard were last completed"""
    extent: Any
    """(P, n): largest values of the states at the start and where steps with a strobe ended"""
    doubt: Any
    """(P, n): errors of the states where the run began or after the last event, in units of ``guards.ROUNDING``"""
    normal: Any
    """(P, n + 1): gradient of the guard that has just fired, by states and, last, time"""


class State(NamedTuple):
    """One of the runs: `States` without the first axis."""

    run: Any
    c: Any
    x: Any
    scale: Any
    sums: Any
    vectors: Any
    exponent_of: Any
    lost: Any
    logs: Any
    grown: Any
    sooner: Any
    shares: Any
    sides: Any
    counts: Any
    grazing: Any
    hardest: Any
    extent: Any
    doubt: Any
    normal: Any


class Implicit(NamedTuple):
    """Arrays of Newton's method for s stages of n states; without rows for methods that need none."""

    at_start: Any
    """(n, n): Jacobian at the start of a step"""
    jacobians: Any
    """(s, n, n): those of which the matrix is made"""
    matrix: Any
    """(s n, s n): its factors"""
    filter: Any
    """(n, n): factors for errors"""
    changes: Any
    """(s + 1, n)"""
    right: Any
    """(s n,)"""
    spare: Any
    """(2, n)"""
    pivots: Any
    filter_pivots: Any
    active: Any
    """(n,): states that are unknowns, the first ones"""


class Scratch(NamedTuple):
    """Arrays that hold nothing from one step to the next."""

    workspace: Any
    """(rows, COLUMNS): series of states, quadratures, guards; then of what drives them, and of tangents"""
    polynomial: Any
    shifted: Any
    stack: Any
    ends: Any
    times: Any
    """(guards,): first event of every guard in the step, or -1"""
    backs: Any
    """(guards,): when a guard that was passed is back on its near side, or -1"""
    gradient: Any
    errors: Any
    """(2,): bounds of a guard's and its rate's rounding errors"""
    weights: Any
    """(n,): one over the scales of the states"""
    metric: Any
    """(n,): factors by which components of tangents are compared"""
    none: Any
    """(n,): zeros"""
    before: Any
    after: Any
    out: Any
    image: Any
    event: Any
    jump: Any
    stages: Any
    normals: Any
    """(surfaces, n + 2): gradients of surfaces that a mode holds, then their time derivative and value"""
    implicit: Any
    """`Implicit`"""
    doubt: Any
    """(n + q,): what rounding may make of rates"""
    watched: Any
    """(4, operations): what steep operations are applied to, at two places, its largest and its first size in a step"""


class Stepper(NamedTuple):
    """A method's functions, see ``engine.stepper``."""

    expand: Any
    locate: Any
    evaluate: Any
    advance: Any


class Machine(NamedTuple):
    """All that a compiled function needs for runs of one system: it is given the address of these in memory."""

    functions: Any
    stepper: Any
    search: Any
    """`chaosdrill.engine.first_event.first_event`, for lanes and orbits"""
    settings: Any
    """(1,) of SETTINGS"""
    tables: Any
    states: Any
    scratch: Any


class Method(NamedTuple):
    """How run p is stepped: the functions of its method, the search for events, and where they find the run."""

    stepper: Any
    search: Any
    place: Any
    """address of the `Machine`"""
    asleep: Any
    """that of one that watches no guard"""
    p: Any


class Block(NamedTuple):
    """Arrays of eight runs that are stepped together, the last axis being the lane."""

    t: Any
    c: Any
    x: Any
    v: Any
    ws: Any
    scale: Any
    """(n, lanes)"""
    weights: Any
    """(n, lanes): one over the scales"""
    metric: Any
    """(n, lanes): factors by which components of tangents are compared"""
    h: Any
    reach: Any
    gap: Any
    """(3, lanes): what raises suspicion of the series of states, of what follows from them, of steep operations"""
    out: Any
    period: Any
    scaled: Any
    """(guards, COLUMNS, lanes): polynomials of the guards, with the step as the unit of time"""
    total: Any
    """(guards, lanes): sums of the sizes of their terms"""
    later: Any
    """(guards, lanes): sums of the terms but the first"""
    wanted: Any
    """(guards, lanes): 1.0 where a root is searched, else 0.0"""
    alone: Any
    """1.0 where the guards are looked at for one trajectory, else 0.0"""
    which: Any
    """the guard that fires first in the step, or -1.0"""
    sign: Any
    """(guards, lanes): 1.0 where a guard is below zero, -1.0 where it is above"""
    shift: Any
    """(guards, lanes): order of its zero at the start of the step"""
    times: Any
    backs: Any
    polynomial: Any
    bernstein: Any


class LaneRoom(NamedTuple):
    """What ``lane_flow`` keeps in order by, and its scratch."""

    queues: Any
    """(keys, 2 + ACTIVE): of each the first place and the length, then a ring of runs"""
    ends: Any
    """(LANES + 1, LANES): how the steps of a block end"""
    row: Any
    """one row of the event buffer"""
    spare: Any
    """(window, n + 1)"""
    block: Any


class Results(NamedTuple):
    """What a batch of P runs is for, and how far each is."""

    progress: Any
    """(P, PROGRESS): STAGE, GOAL, LAST, TAKEN, LEFT, CELL, MET"""
    growth: Any
    """(P, stretches, m): sums of logarithms at the ends of the stretches"""
    integrals: Any
    """(P, stretches, q): quadratures there"""
    times: Any
    """(P, stretches): times there, of runs whose stretches are counted in section points"""
    window: Any
    """(P, size, n + 1): the last section points and their modes, a ring"""
    outcome: Any
    """(P,)"""


# columns of the event buffer before the states
EVENT_STROBES, EVENT_TIME, EVENT_KIND, EVENT_MODE, EVENT_SPEED, EVENT_ERROR = range(6)
EVENT_COLUMNS = 6

# columns of the table of transitions
TO_MODE, MARKS_ONLY, RANK_DEFICIENT, COMPLETES, COMPLETED = range(5)

# bits that describe a guard: its events change nothing; they may lose rank; it is linear and free of time; it has
# steep operations; it depends on time alone; a run may begin beyond it; its own event may let the
# motion go on beyond it
MARKS, LOSES_RANK, AFFINE, STEEP, TIMED, OPEN, PASSES = 1, 2, 4, 8, 16, 32, 64

# how a method is stepped: by the series that are part of the engine, by steps of one length, by steps that it chooses
(TAYLOR, RK4, ADAPTIVE) = range(3)


def method_code(name: str) -> int:
    """How the method of this name is stepped."""
    if name == "taylor":
        return TAYLOR
    return RK4 if METHODS[name].fixed_step else ADAPTIVE


# columns of how far a run of a batch is: its stretch, the strobe where it is looked at and the last of all stretches,
# section points kept; where stretches are counted in these, those left in this one, the strobes between two looks (else
# 0), and the strobe before the last point
STAGE, GOAL, LAST, TAKEN, LEFT, CELL, MET = range(7)
PROGRESS = 7

EPSILON = 2.220446049250313e-16

BEFORE, BEHIND = 1, 2
"""Which state of an event is a section point."""

COLUMNS = WIDTH + 4
"""Length of a workspace row: the last pass over four orders may write beyond the highest."""

# what a call of the engine ends with; values from 4 on are those of dataset.Outcome
DONE, FULL = range(2)
ESCAPED, EVENT_LIMIT, STALLED, NONFINITE, STEP_UNDERFLOW, INVALID_START, FAILED = range(4, 11)
NO_RETURN, SINGULAR = 17, 18

# what a guard does in a step: it is on the side from which it can be crossed; it must come back first; it fires at the
# start of the step; it cannot be started from; it is zero all along; its slope is zero, too
ARMED, PASSED, FIRE, INVALID, NOWHERE, UNSURE = range(6)

# what came before the step: more of the same phase, nothing, an event, a state put in from elsewhere
ONGOING, BEGIN, AFTER, PUT = range(4)

# `rank_check`: whether tangents may have lost rank, at an event that may have been caused by the last one's reset or
# may cause another
CHECKED, AT_EVENT = 1, 2
