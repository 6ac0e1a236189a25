"""Numbers that tune the engine, with their reasons, a record a subject; none of them is physics.

Compiled functions take the fields of these records as constants.
"""

from typing import NamedTuple

from chaosdrill.codegen.layout import EPSILON


class Steps(NamedTuple):
    """How long steps are, and what ends a run."""

    smallest: float = 1e-15
    """Shortest step, as a part of the longest one taken so far."""
    safety: float = 0.9
    """Part of the length that an error allows which is tried."""
    smallest_growth: float = 0.1
    """Factor by which a step is shortened at most: into a contact it may have to shrink by orders of magnitude."""
    tangents: float = 0.1
    """Part of the tolerance for tangents: through a stiff contact they grow by orders of magnitude, and come back."""
    beginning: float = 1e-2
    """Part of a period, or of a run without one, to begin with where the size of no state is known."""
    quick: float = 1e9
    """Sizes that a state may move in a period, or in a run without one, for a length of that motion to be looked for;
    what is quicker is about to leave what it has decayed to."""
    calm: float = 0.3
    """Part of itself by which a rate may change in a first length."""
    probes: int = 9
    """Lengths at which that is looked at, each ``closer`` times the next one."""
    closer: float = 0.1
    """See ``probes``."""
    to_bound: int = 3
    """Newton steps from the root of a dense output to the instant at which a state leaves its bounds, or is farthest
    beyond them;"""
    places: int = 16
    """places of a step among which that is looked for."""
    underflow: float = 1e-16
    """Part of the longest step below which shortening is given up."""
    blocked: float = 1e-6
    """Part of the longest step below which one that moves no state, and could not be longer, is the last."""
    held_up: float = 1e-12
    """The same for one that leaves a state where it is though it has a rate: others may be slower by 1e4."""
    goal: float = 1e-6
    """Part of the period before the end of a run within which a step is not shortened to end there."""
    halvings: int = 30
    """Halvings of a step whose guards are not yet polynomials; one with a kink never is."""
    tie: float = 1e-12
    """Part of a step within which two roots coincide."""
    probe: float = 1e-3
    """Part of a fixed step after which a guard tells to which side the motion leads from zero: a shorter rebound is not
    seen."""
    behind: float = 0.75
    """Where in the period the step behind the event ends, which finds what the event has made of the state."""


class Series(NamedTuple):
    """Steps of Taylor series."""

    gap: float = 10.0
    """Factor between the sizes of two terms and the next two, at the radius of convergence, that raises suspicion;
    about 5 in the series of exp."""
    late: int = 8
    """Last terms of a series of which one is not zero if any that matter are: higher powers are watched."""


class Dop853(NamedTuple):
    """Steps of the method of order 8."""

    largest_growth: float = 6.0
    """Factor by which a step is longer than the one before, at most."""
    blind: float = 0.25
    """Part of the square of the error of order 3, over the spread of the rates, below which that of order 5 is zero by
    accident: an order beyond the one that it stands for. Without it 1 in 100 of the longest steps through a pulse was
    believed though it was off by more than 50 tolerances, some by 1e6; with it none was, and 1 in 60 is shorter."""
    parted: float = 0.5
    """Part of a rate by which it may differ between two points at the end of a step from which a size is taken: below
    0.1 up to 5 times the time of a relaxation, above 1 from 10 on."""


class Radau(NamedTuple):
    """Steps of implicit methods."""

    largest_growth: float = 8.0
    """Factor by which a step is longer than the one before, at most."""
    failed: float = 0.25
    """Part of a step whose stages are not found that is tried next."""
    noise: float = 16.0
    """Rounding errors of a state within which the error of an implicit step is unknown. Where a relaxation of mu =
    1e6 began on its slow part, a size of one rounding error took 800,000 steps to the length of the next; of 16 it
    takes 39."""
    finest: float = 1e-9
    """Tolerance below which a step has 7 stages: more cost more a step, and make it longer;"""
    fine: float = 1e-5
    """that below which it has 5."""
    least: float = 4e-15
    """Tolerance of states, and of tangents, below which the error of a step is that of the sums that tell it."""
    left: float = 1e-4
    """Part of the tolerance that Newton's method may leave: the derivative of the step is that of its exact
    solution."""
    sluggish: float = 0.03
    """Part of an update that the next one may have, beyond which the Jacobians are computed anew, at the stages."""
    updates: int = 12
    """Updates of Newton's method; where its Jacobians are those of the stages, it needs four, or fails."""
    still: float = 0.5
    """Part of an update from which on the next is as large, being round-off, or none that leads anywhere."""
    rates: float = 16.0 * EPSILON
    """Rounding error of the rates, in sums of the sizes of their terms; only where updates no longer become smaller."""


class Sizes(NamedTuple):
    """Sizes of states."""

    fade: float = 0.98
    """Factor by which a state's size fades in a step: it follows the motion within some hundred steps."""
    slow: float = 1000.0
    """Steps' motion up to which the value of a state counts as its size: what moves on for ever has no size."""
    turn: float = 0.25
    """Part of what its first rate would move a state in a step by which it has been away at least, if the step brings
    it back to where it began: that of a parabola. Where every step ends on one value, which may be 0, nothing else
    shows."""
    left: float = 1e-140
    """Value below which a state that moves in proportion to itself is as exact as any other: tangents in parts of it,
    and their squares, must be doubles."""
    begun: float = 1e-200
    """Size below which what begins to move has none yet: exponentials that are written so that they do not overflow may
    begin with a jump of 1e-222."""


class Checks(NamedTuple):
    """When a step counts."""

    defect: float = 20.0
    """Defect of a series, times the length of the step, in units of the tolerance, above which the step is
    shortened."""
    dense_defect: float = 100.0
    """The same of a dense output, whose rates are two orders less exact than the step."""
    rounding: float = 1e-12
    """Relative rounding error of a rate, and of a state in units of its scale."""
    shortenings: int = 16
    """Times that a step is shortened for a defect; what does not change then is round-off, as about a point at rest."""
    earlier: int = 7
    """Places before the last at which the terms begin that tell how far a series goes whose last two are zero."""
    doubt: float = 4.0
    """Times by which rounding may be larger than what it is seen to make of the rates."""
    few: float = 0.5
    """Part of what an argument may move by within which its first eight terms say that all do not move it farther."""
    sampled: float = 0.75
    """Part of what an argument may move by that counts where its range is only known at a few places."""
    begin: float = 2.0**-10
    """Part of a step to its first place; from one to the next at most twice as far, which no turn of a smooth argument
    escapes."""
    places: int = 600
    """Places of one step; where more would be needed it ends at the last."""
    onward: float = 0.7
    """Part of what an argument may move to the next place that is aimed at."""
    finest: float = 1e-14
    """Part of a step between two places below which an argument is where its operation ends."""
    passed: float = 1e-3
    """Part of its largest size below which an argument passes zero in a method that needs no series."""
    largest: float = 1e300
    """Size of an argument that has become infinite, as a hyperbolic cosine in a divisor does."""
    nudge: float = 1e-6
    """Part of states and time by which an argument is seen to depend on them."""
    ahead: float = 1e-8
    """Part of the longest step within which an operation ends that has stopped a run."""


class Guards(NamedTuple):
    """When guards are zero, and which event comes first."""

    vanishing: float = 1e-13
    """Part of a guard's variation over a step below which its second and later derivatives count as zero."""
    interpolated: float = 1e-10
    """Least truncation error of the interpolated polynomial of a curved guard, beside its rounding error."""
    interpolated_in_time: float = 1e-13
    """The same for a guard of time alone, which is interpolated between values that are exact."""
    in_time: float = 1e-12
    """Part of what it moves that the last terms of the series of such a guard may be, whatever the tolerance: at 1e-4 a
    guard that touches zero would cross it."""
    parallel: float = 1e-12
    """Part by which the square of the cosine of two gradients may differ from 1 where guards that are zero at the same
    place are on one surface: the angle counts as zero up to 1e-6."""
    late: float = 100.0
    """Tolerances by which a run may begin beyond a guard and be on it: no run that is right ends farther off."""
    told: float = 1e-2
    """Part of the way to a root by which the last terms of a polynomial may move it: of what decays onto a guard they
    alone make a root, at which they move it by 0.1."""
    short: float = 1e-2
    """Part of a step below which the interpolated polynomial gives a rebound better than values of the guard do:
    rounding has about 1e7 times as large a part in the fourth order of that as in a value."""
    finer: float = 8.0
    """Factor by which a guard has to round less near roots that its terms at the start of the step do not tell apart,
    for a step to begin there: written as a product it may by 1e10."""
    clear: float = 4.0
    """Distances from such a root to where the guard is clear of its error from which that step begins."""
    nearest: float = 1e-9
    """Part of the longest step so far below which none is shortened for close roots to be told apart."""
    flat: float = 1e-3
    """Part of what its first slope would change a guard by in a step that tells it from what is left out of it."""
    hidden: float = 100.0
    """What the polynomial leaves out, times which a guard is that near zero where it may have crossed it unseen:"""
    seen: float = 4.0
    """not if it is this many times as far from zero as the polynomial and its rounding may be off by."""
    near: float = 1e-6
    """Part of the step within which two roots, or a root and a strobe, are looked at for whether they coincide, unless
    that of ``late`` tolerances is longer."""
    far: float = 1e15
    """Scale of the states by which they are put onto a guard however far away it is: where steps are fixed an event is
    as exact as its bisection, and a guess of an orbit may end anywhere."""


class Roots(NamedTuple):
    """The search for the first root of a polynomial."""

    degree: int = 7
    """Degree of the Bernstein form that is tried first."""
    depth: int = 60
    """Intervals that wait to be searched, at most."""
    budget: int = 24
    """Intervals tried with the Bernstein form of low degree."""
    whole_budget: int = 500
    """Intervals tried with that of the whole polynomial."""


class Lane(NamedTuple):
    """Eight runs side by side."""

    degree: int = 11
    """Degree of the Bernstein form: in lanes a higher one costs little, and it isolates nearly all roots."""
    iterations: int = 12
    """Newton steps before a root is left to the search for one trajectory."""
    sure: float = 1e-8
    """Part of the largest coefficient by which a value must be above zero to be called so: what only touches zero is
    looked at for one trajectory."""
    noise: float = 1e-14
    """Part of the sum of a guard's terms that rounding may take from its polynomial, and more."""
    active: int = 64
    """Runs under way at a time: enough to fill the lanes of every queue, few enough to stay in the cache."""


class Rebounds(NamedTuple):
    """When rebounds are over."""

    low: float = 16.0
    """Heights of a rebound that may be rounding alone, in those above which a guard is no longer zero."""
    most: int = 30_000
    """Rebounds that are taken one after the other; a restitution of 1 - 0.5 v**0.2 needs a third of them."""
    first_cycle: int = 8
    """Rebounds within which the guard is looked for at which a cycle begins; twice as many each time it is not
    found."""
    fastest: float = 0.9
    """Part of its length by which what is left may be longer than that of a geometric series."""
    further: float = 1.25
    """Times as many cycles after which an end is looked at again; from one to the next it may move by rounding only."""
    fine: float = 1e-3
    """Part of the error that is allowed down to which an end is looked for: the rebounds that show it cost little."""
    sure: float = 2.0
    """Times by which the error of an end may be larger than what the cycles still to come move it, each as the last."""


class Tangents(NamedTuple):
    """Growth and rank of tangents."""

    rank: float = 1e-13
    """Part of the image of a tangent, by sizes of states, that has to be new at an event of deficient rank; else it is
    lost. In saltation matrices, part of the largest entry below which one is round-off."""
    finest: float = 1e-140
    """Least size of a state as a part of the largest: the square of one over it is a double."""
    shown: float = 0.125
    """Part of a state's recent size that strobes show at least, if lengths of tangents are to be in parts of what they
    show."""
    once: float = 0.25
    """Part of its squared length that a tangent must keep for one projection to be enough (Kahan; Parlett 1998,
    6.9)."""
    graded: float = 1e-12
    """Part of its squared length that a tangent must keep for its projection to be exact to half of its digits."""
    squares: float = 1e-280
    """Square of a length, or one over it, below which squares of entries may be no doubles."""
    most_grown: float = 1e8
    """Growth of a tangent, or one over it, whose logarithm is taken: of every length it would take twice as long as all
    else, and so few factors round as a sum of their logarithms does."""
    longest_wait: int = 4
    """Steps between two orthonormalisations, at most: contraction may set in at any time."""
    often: float = 100.0
    """Growth between two orthonormalisations from which on these follow each other twice as soon;"""
    seldom: float = 5.0
    """that up to which they follow half as often."""
    steep: float = 1e6
    """that from which on they follow every step for good: two such contractions between them leave round-off alone."""
    large: float = 1e4
    """Tangents are orthonormalised at once after an event that makes one this long."""
    independent: float = 1e-6
    """A direction counts as new if more than this part of it is orthogonal to the live tangents."""
    onto_surfaces: int = 20
    """Steps onto the surfaces that a mode holds: one is exact where they are flat."""


class Orbits(NamedTuple):
    """Segments of orbits that are looked for."""

    end: float = 1e-8
    """Part of the period before the end of a segment in which its guard is taken to be met at the end."""
    steps: int = 2_000_000
    """Steps of adaptive methods along one segment, at most, some seconds: a guess that is far off may be stiff without
    end, and a relaxation oscillation that is a thousand times as stiff as slow takes 300,000."""
    steep: float = 1e-2
    """Speed of an event, in parts of the variation of its guard over the sizes of the states in one period, and"""
    grown: float = 1e3
    """growth of the unknowns, in the same sizes, from which on a duration is eliminated."""


class Runs(NamedTuple):
    """What goes on around runs."""

    fixed_steps: int = 200
    """Steps that a method with a fixed step takes in a period, or in a unit of time, unless told otherwise."""
    rounding: float = 4e-15
    """What rounding adds to a step, however small the tolerance."""
    order: tuple[float, float] = (6.0, -0.62)
    """Order of a Taylor series: at the tolerance 1, and what is added for every factor e. A step costs order**2, and
    its length grows like tolerance**(1/order)."""
    batch_order: tuple[float, float] = (12.5, -0.42)
    """The same for runs in lanes: there the series is the smaller part of a step's cost."""
    most_steps: int = 100_000_000
    """Steps of adaptive methods from one sample, strobe or event to the next, at most: in what comes again and again
    far faster than these they have no end."""
    event_rows: int = 64
    """Rows of the table of events of a run whose section points are kept."""
    return_rows: int = 1024
    """Events between two looks at a run whose length is counted by them: each look takes about as long as four
    events."""
    newton: int = 3
    """Steps to a point at rest,"""
    singular: float = 1e-12
    """singular values that count as zero,"""
    near: float = 1e-2
    """and how far off the point may be, in sizes of the states."""
    on_surface: float = 1e-9
    """Relative distance within which a stalled run counts as on a surface."""
    cancelled: float = 2.0**-40
    """Part of its terms down to which a sum at the end of a run counts as lost in rounding, in thousands of
    roundings."""


class Structures(NamedTuple):
    """What is known of a system before it runs."""

    samples: int = 24
    """Saltation matrices of a transition, and Jacobians of a mode, of which it is examined what they do."""
    trials: int = 256
    """States at which a guard is looked at: for systems of the library 128 tell what 2,048 do, and 24 miss passages
    that one state in thirty shows."""
    decades: tuple[float, float] = (-4.0, 0.5)
    """Powers of ten of the sizes of states between which they are looked at,"""
    branches: tuple[float, float] = (-6.0, 6.0)
    """and those where a reset has branches, each of which may do another thing far from where a run begins."""
    on: float = 1e-13
    """Part of the sizes of its terms, some hundred roundings, below which a guard counts as zero."""
    about: float = 2.0**-10
    """Part of the sizes of states by which one is moved at first to meet a guard, and"""
    farther: int = 12
    """how often four times as far, if it does not: a motion that comes back is no faster than some thousand sizes."""
    most: float = 1e6
    """Growth, in units of the sizes of states, up to which a saltation matrix tells its rank."""
    apart: float = 1e-10
    """Length from which on what is left of a unit vector across others is another direction."""
    kept: int = 64
    """Answers that are kept, of starts of other sizes and of other parameters."""
    regular: float = 1e-6
    """Part of the largest singular value above which the smallest one tells of an inverse."""
    halvings: int = 60
    """Halvings of the way to a guard, which is curved if it is no line."""
    along: float = 1e-6
    """Part of the flow that may be left across the symmetries where the motion counts as nothing but a shift."""
    powers: int = 160
    """Doublings to which a state at rest is displaced, from one over them on, and"""
    stride: int = 8
    """steps of those that are tried first."""
    digits: int = 7
    """Digits of a unit of time: of an eigenvalue that is double rounding leaves eight."""
    changed: float = 0.5
    """Part of the fastest motion by which it is another one."""
    measures: int = 64
    """Turns of a phase after which phases that turn together have come back together, at most."""


STEPS = Steps()
SERIES = Series()
DOP853 = Dop853()
RADAU = Radau()
SIZES = Sizes()
CHECKS = Checks()
GUARDS = Guards()
ROOTS = Roots()
LANE = Lane()
REBOUNDS = Rebounds()
TANGENTS = Tangents()
ORBITS = Orbits()
RUNS = Runs()
STRUCTURE = Structures()
