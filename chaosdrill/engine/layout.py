"""What a run is made of: settings, its state as one record, and the arrays that go with it, by name and type.

Nothing here is compiled. `chaosdrill.engine.records` makes the types that compiled code has of these tuples.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from chaosdrill.codegen.kinds import Array, RecordOf
from chaosdrill.codegen.signatures import WIDTH, cube, integer_matrix, integers, matrix, vector
from chaosdrill.engine.tuning import LANE

Vector = Annotated[Any, vector]
Matrix = Annotated[Any, matrix]
Cube = Annotated[Any, cube]
Integers = Annotated[Any, integers]
IntegerMatrix = Annotated[Any, integer_matrix]

SETTINGS = np.dtype(
    [
        *((name, np.int64) for name in ("stepping", "order", "quadratures", "samples", "recording", "orthonormalise")),
        *((name, np.int64) for name in ("absolute_time", "max_events", "max_stalls", "target", "own_jacobian")),
        ("max_steps", np.int64),
        *((name, np.float64) for name in ("tolerance", "reach", "dense_noise", "phase")),
    ],
    align=True,
)
"""What holds for all runs of a batch; ``target`` is the number of strobes at which a call ends, ``recording`` says what
is recorded: nothing, samples ``EVENLY`` in a period, or states at ``INSTANTS`` that the buffer's rows hold,
``dense_noise`` is the rounding units by which the dense output of the method moves the polynomial of a state, ``phase``
where between two strobes a map takes its iterate, 0 for other systems."""

AllSettings = Annotated[Any, Array(RecordOf(SETTINGS), 1)]

EVENLY, INSTANTS = 1, 2

RUN = np.dtype(
    [
        *((name, np.int64) for name in ("mode", "strobes", "live", "fresh", "fired", "surface", "way", "moved_by")),
        *((name, np.int64) for name in ("turning", "sample", "sample_rows", "event_rows", "steps", "steps_since")),
        *((name, np.int64) for name in ("evaluations", "ties", "events_in_period", "stalls", "qr_wait", "qr_since")),
        *((name, np.int64) for name in ("rank_check", "blocked", "waiting")),
        *((name, np.float64) for name in ("time", "origin", "whole", "rest", "period", "fixed_step", "longest")),
        *((name, np.float64) for name in ("next_step", "tried", "strength", "residual", "wait_until", "wait_above")),
        *((name, np.float64) for name in ("speed", "pull", "jerk")),
        ("held", np.int64),
    ],
    align=True,
)
"""Where a run stands.

The time is ``origin + whole + rest + time``: whole periods as an exact sum of two doubles, then the time since the last
strobe. ``fired`` and ``surface`` name the guard that has just fired and its surface, ``way`` is the side to which that
was crossed (0 where a reset has thrown the state across), ``moved_by`` the transition that was then taken, ``residual``
what the guard's value was at the event, ``speed`` its rate before. ``held`` says whether the motion did not leave that
guard, ``turning`` whether a guard that was passed comes back in the step, ``blocked`` which of the mode's steep
operations has ended the run, -1 for none. ``steps_since`` counts steps since the last sample, strobe or event. Rebounds
from the guard ``waiting`` are not over before ``wait_until``, as long as they are faster than ``wait_above``. ``pull``
and ``jerk`` are the second and third derivative of the guard that has just fired, 0 where these are not known.
"""

Runs = Annotated[Any, Array(RecordOf(RUN), 1)]


class Tables(NamedTuple):
    """What is known of a system's events and states, whatever the run."""

    active: IntegerMatrix
    """(modes, 1 + guards): number of guards, then their directions"""
    keys: IntegerMatrix
    """(modes, guards): number of a guard with its direction, the same in all modes"""
    surfaces: IntegerMatrix
    """(modes, guards): number of the surface on which a guard is zero"""
    watched: IntegerMatrix
    """(modes, keys): whether a mode watches a guard"""
    marks: IntegerMatrix
    """(modes, guards): bits that describe a guard, see MARKS, ..."""
    transitions: IntegerMatrix
    """(transitions, 5): TO_MODE, MARKS_ONLY, RANK_DEFICIENT, COMPLETES, COMPLETED"""
    moves: IntegerMatrix
    """(transitions, keys): whether the reset may change the guard's value"""
    returns: IntegerMatrix
    """(transitions, 2): guards that what is thrown off a surface meets there again, from above and from below, or -1"""
    bounds: Matrix
    """(2, n): lower and upper bounds of the states that are looked at where steps end"""
    fences: Matrix
    """(k, 3): number of a state, and the doubles next beyond its bounds"""
    symmetries: Matrix
    """(k, n): directions in which nothing ever changes"""
    constrained: IntegerMatrix
    """(modes, n): states that a mode leaves no freedom"""
    feeds: IntegerMatrix
    """(modes, n): whether rates in the mode depend on the state; the others are constant, and move no tangent"""
    proportional: IntegerMatrix
    """(modes, 1 + most): number of the states that stay zero if they are, and leave it at a rate that changes; these"""
    held: Integers
    """(modes,): number of surfaces that a mode holds; ``guard`` knows them behind the guards"""
    slack: Vector
    """(n,): how far states may lie off the guards on which a run begins"""
    steep: IntegerMatrix
    """(modes, 1 + operations): number of steep operations, then the rows of what they are applied to, where such are"""
    shapes: Cube
    """(modes, operations, 7): `codegen.layout.Shape` of each"""


class States(NamedTuple):
    """All that P runs carry from step to step; the first axis of every array is the run."""

    run: Runs
    """(P,) of RUN"""
    c: Matrix
    """(P, constants)"""
    x: Matrix
    """(P, n)"""
    scale: Matrix
    """(P, n + q): sizes that states have had of late, and what integrals have moved in a step"""
    span: Matrix
    """(P, n + q): sizes by which tangents are measured; `scale` itself where no state moves in proportion to itself"""
    sums: Cube
    """(P, 3, q): quadratures as compensated sums, and how far they have moved in all"""
    vectors: Cube
    """(P, m, n): tangents, one a row"""
    exponent_of: IntegerMatrix
    """(P, m): the exponent to which a live tangent belongs"""
    lost: IntegerMatrix
    """(P, m): whether an exponent's tangent is lost"""
    logs: Matrix
    """(P, m): logarithms of the tangents' growth, but for its last factors"""
    grown: Matrix
    """(P, m): the product of these"""
    sooner: Matrix
    """(P, m): by how much the last event comes sooner along a live tangent"""
    shares: Cube
    """(P, m, m), or (P, 0, 0) where nobody asks: of which tangents at the start of a block each was made, in parts of
    its own; rows and columns are exponents, and ``logs`` counts from that start, too"""
    sides: IntegerMatrix
    """(P, keys): side of every guard: -1, 1, 0 where it is not known, times ``guards.JUMPED``, ``PUT_ACROSS``, ``HELD``
    or ``PLACED``"""
    counts: IntegerMatrix
    """(P, transitions)"""
    grazing: Matrix
    """(P, transitions): smallest normal speed met"""
    hardest: Matrix
    """(P, keys): largest normal speed met since rebounds from the guard were last completed"""
    extent: Matrix
    """(P, n): largest values of the states at the start and where steps with a strobe ended"""
    doubt: Matrix
    """(P, n): errors of the states where the run began or after the last event, in units of ``guards.ROUNDING``"""
    leeway: Matrix
    """(P, n): how far beyond its bounds a state has been on them, since it was last within"""
    normal: Matrix
    """(P, n + 1): gradient of the guard that has just fired, by states and, last, time"""

    @property
    def ended_by(self) -> np.ndarray:
        """(P, 2): mode and number of the steep operation that has ended each run; the number is -1 for none"""
        return np.stack([self.run["mode"], self.run["blocked"]], axis=-1)


class State(States):
    """One of the runs: `States` without the first axis."""

    __slots__ = ()


class Implicit(NamedTuple):
    """Arrays of Newton's method for s stages of n states; without rows for methods that need none."""

    at_start: Matrix
    """(n, n): Jacobian at the start of a step"""
    jacobians: Cube
    """(s, n, n): those of which the matrix is made"""
    matrix: Matrix
    """(s n, s n): its factors"""
    filter: Matrix
    """(n, n): factors for errors"""
    changes: Matrix
    """(s + 1, n)"""
    right: Vector
    """(s n,)"""
    spare: Matrix
    """(2, n)"""
    frame: Matrix
    """(m, n): directions of the tangents at a place of the step"""
    decay: Matrix
    """(6, m): what is known of the tangents' growth in a step, see `chaosdrill.engine.radau_growth`"""
    pivots: Integers
    filter_pivots: Integers
    active: Integers
    """(n,): states that are unknowns, the first ones"""


class Scratch(NamedTuple):
    """Arrays that hold nothing from one step to the next."""

    workspace: Matrix
    """(rows, COLUMNS): series of states, quadratures, guards; then of what drives them, and of tangents"""
    polynomial: Vector
    shifted: Vector
    stack: Matrix
    ends: Matrix
    times: Vector
    """(guards,): first event of every guard in the step, or -1"""
    backs: Vector
    """(guards,): when a guard that was passed is back on its near side, or -1"""
    orders: Integers
    """(guards,): of guards whose roots are looked for, the order of their zero at the start of the step"""
    gradient: Vector
    errors: Vector
    """(2,): bounds of a guard's and its rate's rounding errors"""
    weights: Vector
    """(n,): one over the scales of the states"""
    metric: Vector
    """(n,): factors by which components of tangents are compared"""
    none: Vector
    """(n + q,): zeros"""
    before: Vector
    after: Vector
    out: Vector
    image: Vector
    whole: Vector
    """(n,): a tangent as it was before its parts along others were taken away"""
    event: Vector
    jump: Vector
    stages: Matrix
    normals: Matrix
    """(surfaces, n + 2): gradients of surfaces that a mode holds, then their time derivative and value"""
    implicit: Implicit
    doubt: Vector
    """(n + q,): what rounding may make of rates"""
    watched: Matrix
    """(4, operations): what steep operations are applied to, at two places, its largest and its first size in a step"""


class Machine(NamedTuple):
    """All that a compiled function needs for runs of one system: it is given the address of these in memory."""

    functions: Any
    stepper: Any
    search: Any
    """`chaosdrill.engine.first_event.first_event`, for lanes and orbits"""
    settings: AllSettings
    """(1,) of SETTINGS"""
    tables: Tables
    states: States
    scratch: Scratch


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

    t: Vector
    c: Matrix
    x: Matrix
    v: Cube
    ws: Cube
    scale: Matrix
    """(n, lanes)"""
    span: Matrix
    """(n, lanes), as in `States`; without rows where it is ``scale``"""
    weights: Matrix
    """(n, lanes): one over the scales"""
    metric: Matrix
    """(n, lanes): factors by which components of tangents are compared"""
    h: Vector
    reach: Vector
    gap: Matrix
    """(3, lanes): what raises suspicion of the series of states, of what follows from them, of steep operations"""
    out: Matrix
    period: Vector
    scaled: Cube
    """(guards, COLUMNS, lanes): polynomials of the guards, with the step as the unit of time"""
    total: Matrix
    """(guards, lanes): sums of the sizes of their terms"""
    later: Matrix
    """(guards, lanes): sums of the terms but the first"""
    wanted: Matrix
    """(guards, lanes): 1.0 where a root is searched, else 0.0"""
    alone: Vector
    """1.0 where the guards are looked at for one trajectory, else 0.0"""
    which: Vector
    """the guard that fires first in the step, or -1.0"""
    sign: Matrix
    """(guards, lanes): 1.0 where a guard is below zero, -1.0 where it is above"""
    shift: Matrix
    """(guards, lanes): order of its zero at the start of the step"""
    times: Matrix
    backs: Matrix
    polynomial: Matrix
    bernstein: Matrix


class LaneRoom(NamedTuple):
    """What ``lane_flow`` keeps in order by, and its scratch."""

    queues: IntegerMatrix
    """(keys, 2 + ACTIVE): of each the first place and the length, then a ring of runs"""
    ends: IntegerMatrix
    """(LANES + 1, LANES): how the steps of a block end"""
    row: Matrix
    """one row of the event buffer"""
    spare: Matrix
    """(window, n + 1)"""
    block: Block


class Results(NamedTuple):
    """What a batch of P runs is for, and how far each is."""

    progress: IntegerMatrix
    """(P, PROGRESS): STAGE, GOAL, LAST, TAKEN, LEFT, CELL, MET"""
    growth: Cube
    """(P, stretches, m): sums of logarithms at the ends of the stretches"""
    frames: Cube
    """(P, stretches, m (n + 1)): tangents there, each with the number of its exponent from 1 on; 0 behind the last"""
    integrals: Cube
    """(P, stretches, q): quadratures there"""
    times: Matrix
    """(P, stretches): times there, of runs whose stretches are counted in section points"""
    window: Cube
    """(P, size, n + 1): the last section points and their modes, a ring"""
    outcome: Integers
    """(P,)"""


# rows of a Bernstein form in lanes, behind its coefficients: what the rest may add, and of each the largest up to it
REST, HIGHEST = LANE.degree + 1, LANE.degree + 2
BERNSTEIN = HIGHEST + LANE.degree + 1

# columns of the event buffer before the states
EVENT_STROBES, EVENT_TIME, EVENT_KIND, EVENT_MODE, EVENT_SPEED, EVENT_RATE, EVENT_ERROR = range(7)
EVENT_COLUMNS = 7

# columns of the table of transitions
TO_MODE, MARKS_ONLY, RANK_DEFICIENT, COMPLETES, COMPLETED = range(5)

# bits that describe a guard: its events change nothing; they may lose rank; it is linear and free of time; it has
# steep operations; it depends on time alone; a run may begin beyond it; its own event may let the motion go on
# beyond it; no motion leads it to zero
MARKS, LOSES_RANK, AFFINE, STEEP, TIMED, OPEN, PASSES, STILL = 1, 2, 4, 8, 16, 32, 64, 128

# how a method is stepped: by the series that are part of the engine, by steps of one length, by steps that it chooses
BY_SERIES, FIXED, ADAPTIVE = range(3)

# columns of how far a run of a batch is: its stretch, the strobe where it is looked at and the last of all stretches,
# section points kept; where stretches are counted in these, those left in this one, the strobes between two looks (else
# 0), and the strobe before the last point
STAGE, GOAL, LAST, TAKEN, LEFT, CELL, MET = range(7)
PROGRESS = 7

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
