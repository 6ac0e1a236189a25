"""Numbers that tune analyses, with their reasons, a record a subject; none of them is physics.

What decides words stands beside the rules that use it, and what compiled code reads beside that code.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Plan:
    """How points of grids are measured."""

    blocks: int = 32
    """Blocks over which exponents are averaged, for their standard errors."""
    small: int = 6
    """States up to which all exponents are computed, however few are asked for: a point is then the same to the bit for
    any number of them, also where chaos dies out just before or after the end of a record. Beyond, tangents take most
    of the time."""
    least_rows: int = 16
    """Section points that are compared at least."""
    most_rows: int = 2**14
    """Section points of a record that are kept at most: all of a common one."""
    parts: int = 544
    """Parts of a duration at whose ends a point is looked at: blocks of 17 each, so that of a cycle that takes a part
    of a round duration they meet 17 phases at least."""
    at_once: int = 4096
    """Points whose runs are held in memory together, at most."""
    most_held: int = 2**26
    """Bytes of the section points of these, at most."""
    grows: float = 1e-6
    """Logarithm by which a distance grows in a unit of the lengths from where on it is unstable."""
    evenly: float = 4.0
    """Error of the logarithm of growth in a whole record up to which tangents grow evenly, for all that its ends tell:
    that of chaos grows like the root of its length."""


@dataclass(frozen=True)
class Sections:
    """Sections, and what is recorded of a run."""

    longest_return: int = 1000
    """Longest time between two points of a section, unless another one is given: in forcing periods, else in times in
    which the motion from the initial state crosses its own extent. Slow phases of bursting and stick-slip motions are
    shorter, and a run that never returns does not take long."""
    at_once: float = 1e-9
    """Part of the unit of time within which a second point of a surface comes from grazing it, not from a return."""
    blocks: int = 256
    """Parts of a record at most, from which the errors of its mean rates are taken."""
    sooner: float = 3.0
    """Times the distance after a period within which a state is back after a part of it that counts."""
    looked_at: int = 256
    """Points of a section among which the nearest return is looked for."""
    rounding: float = 4e-16
    """Part of a time by which round-off may put it beyond the ends of the run."""
    samples: int = 200
    """Default number of samples of a trajectory: in a period or return, or in a whole duration."""
    event_rows: int = 1024
    """Rows of the table of events of a run; it is emptied as often as it is full."""
    slices: int = 64
    """Parts of a record between which an interruption is heard."""
    few_events: int = 1000
    """Events followed while the time of a motion is looked for."""


@dataclass(frozen=True)
class Cycles:
    """The search for cycles to which slow transients lead."""

    rounds: int = 12
    """Extrapolations, at most."""
    shrinks: float = 0.5
    """Part of the residual that may be left after a round, beyond the first two."""
    settling: int = 32
    """Steps of the map in which tangents turn into their directions before growth is averaged."""
    averaging: int = 64
    """Steps over which growth is averaged, at least."""
    least_cycles: int = 4
    """Cycles in which tangents turn, and over which growth is averaged, at least."""
    parallel: float = 1e-3
    """Sine of the angle below which two differences have one direction."""
    approach: float = 0.25
    """Part of the linear rate at which a run comes closer to the cycle at least."""
    displaced: float = 0.02
    """Distance to which a run is displaced from an unstable rest or cycle, in parts of the sizes of the states."""


@dataclass(frozen=True)
class Attractors:
    """Attractors along a parameter, and which of them are one."""

    length: int = 4096
    """Points of the long records by which attractors are compared."""
    most: int = 64
    """Attractors that are followed at most, those of most runs: a conservative system has as many tori as starts."""
    uneven: float = 1.2360679774997896
    """Times by which instants of such records are further apart than those by which points were judged, sqrt(5) - 1:
    where these fall on few phases of a cycle, such an irrational number lets the others fall on all."""
    cells: tuple[int, ...] = (128, 64, 32, 16, 8)
    """Cells along a state, in parts of its extent over all records; the first that suffices is taken."""
    familiar: float = 0.8
    """Part of the later half of such a record that lies in cells of its earlier half, at least, where cells are large
    enough."""
    shared: float = 0.3
    """Part of one of two records that lies in cells of the other, at least, where both are of one attractor. Of two
    attractors it is hardly anything, and of one it is nearly all; a motion between two wells may have spent most of one
    record in either."""
    carried_most: int = 16
    """Attractors that are distinguished and followed at one value: a conservative system has as many tori as starts."""
    probes: int = 8
    """Motions that go back from an attractor to which several have led, each from another stretch of it and, in turn,
    to either side of it: they tell one that the others have fallen to from one that all have merged into. A merger of
    two equals is missed once in 2**7 times."""
    most_probed: int = 8
    """States in which these differ from the motion: in a neutral one, as the phase of a clock, there is nothing to
    find."""
    probed: float = 1e-3
    """How far they do, in parts of the sizes of the states: what two attractors that mirror each other have merged into
    lies on the boundary between them."""
    most_numbered: int = 1000
    """Attractors in a table, those of the largest shares."""


@dataclass(frozen=True)
class Windows:
    """Exponents over windows."""

    windows: tuple[int, ...] = (1, 10, 100)
    """Windows unless some are given, in units of the record, of which each is to hold ``fewest``."""
    fewest: int = 4
    """Windows of a length in a record, without which there are no cumulants."""
    parts: int = 1024
    """Units of a record without forcing, unless windows are given."""
    orders: int = 4
    """Cumulants: mean, variance, and those that are 0 for a normal distribution."""
    blocks: int = 256
    """Blocks at most from which errors are taken."""
    enlarged: float = 1.18
    """Times the standard deviation of a mean, for its error from eight frequencies, see `standard_error`."""
    end: float = 0.9
    at_end: float = 0.2
    """Part of the largest deviation beyond which such a share of the values shows that a distribution ends there."""
    of_density: int = 32
    """Blocks at most from which the errors of a density are taken, of which there are many."""
    at_least: float = 2.25
    """Values added to those of a bin for its error: an empty bin has three expected values in one case of twenty."""
    flat: int = 20
    lowest: int = 4
    """Part of the frequency of a correlation time up to which a spectrum counts as flat, as one over it: a Lorentzian
    loses 1 % there; and frequencies that are averaged at least."""
    held: int = 2**22
    """Numbers of the tangents at the ends of units that are held together, 32 MB."""
    rounds: int = 8
    """Number of iterations with a better correlation time."""
    constant: float = 1e-9
    """Spread of rates in parts of their size, below which it is round-off, and they are constant."""


@dataclass(frozen=True)
class Covariant:
    """Covariant vectors."""

    parts: int = 1024
    """Vectors in a record without forcing, unless an interval is given."""
    most: int = 32_768
    """Vectors in a forced record at most, unless an interval is given: 5 MB of results in three states."""
    lead: float = 0.25
    leads: tuple[int, ...] = (100, 1000)
    """Part of the record that leads into it and out of it, unless told otherwise, and forcing periods at least and
    most."""
    kept: int = 8_000_000
    """Numbers that are kept of the forward pass at most: of longer records it is repeated, a chunk at a time, from
    states that were kept."""
    beginning: float = 0.125
    """Part of the time since the start of a pass that shows by how much growths differ where directions take turns, as
    those of a spiral."""


@dataclass(frozen=True)
class Escapes:
    """Lives that end, and the saddle that they leave from."""

    parts: int = 1024
    """Units in which lifetimes without forcing are given."""
    early: float = 0.25
    late: float = 0.625
    """Quantiles of lives between which the rate of a flow is taken: half of the runs leave meanwhile, and lives that
    end at multiples of a time differ by one."""
    none_seen: float = 1.5
    """Expected escapes of which twice as many would have shown one in 95 % of all cases: the error of a rate of 0."""
    fewest: int = 20
    """Escapes in each half without which these are not compared."""
    apart: float = 4.0
    """Errors by which an exponent differs from zero."""
    slower: float = 3.0
    """Standard errors by which runs leave more slowly later on, as where some come to an attractor: beyond, those that
    stay longest tell of it, and not of the saddle. By chance one record of 700 is beyond."""
    step: float = 1e-6
    """Step of a difference of dimensions, in parts of the largest exponent: they have kinks at whole numbers only."""
    zero: float = 1e-6
    """Part of the largest exponent up to which one may be 0 however small its error: that of runs which are alike does
    not tell what their tolerance and a short life leave of it."""


@dataclass(frozen=True)
class Boundaries:
    """Boundaries of basins."""

    nearest: int = 3
    """Distance in cells, at least, at which the attractors of cells are compared."""
    blocks: int = 4
    """Parts of the grid along every axis; what is left out in turn for the error of an exponent."""
    parts: int = 16
    """Part of the shortest axis, as one over it, up to which cells are compared: beyond, their distance is that of the
    basins."""
    fewest: int = 4
    """Distances at least to which an exponent is fitted."""
    most_uncertain: float = 0.999
    """Fraction that is taken for all."""
    least: int = 16
    """Cells with different attractors, at least, for a distance to count in the fit."""
    powers: tuple[float, float, int] = (0.01, 1.5, 150)
    """Exponents that are tried beside a constant: from the roughest boundary to beyond a smooth one."""
    shifts: int = 5
    """Places at most at which boxes begin along an axis, to see by how much entropies depend on it."""
    most_shifts: int = 125
    """... and in the whole grid."""


@dataclass(frozen=True)
class Scaling:
    """Dimensions."""

    shortest: int = 7
    """Steps of the distance in a scaling region, at least: a factor of 11."""
    growth: float = 0.34
    """What the logarithm of the number of neighbours grows by over each half of a region, at least: a dimension of 1/3
    does so over the shortest one."""
    nearly: float = 2.0
    """Times the least error up to which a longer range is taken instead: slopes of sets with gaps oscillate at all
    scales, those of the Henon map by a tenth, and are level where they turn."""
    blocks: int = 128
    """Parts of a record, in order, from which the error by chance is taken."""
    fewest_pairs: int = 500
    """Pairs at the smallest distance that counts, at least: their number is then sure to 5 %."""
    widest: float = 0.2
    """Part of all pairs at the largest distance, at most: beyond, the extent of the attractor tells."""
    beyond: float = 1.2
    """Times the widest distance up to which pairs are counted, so that it is seen how a region ends."""
    centres: int = 8192
    centres_of_shares: int = 2048
    looked_at: int = 64
    """Points at most whose neighbours are counted, from which distances to neighbours are asked, and by which it is
    seen at which distances to count."""
    many: int = 200
    """Mean number of neighbours from which on they are counted among few points."""
    fewer: int = 4096
    """Points at most among which they are counted there."""
    boxes: int = 1024
    """Boxes along a coordinate, at most: the number of a row and the place in it share the digits of a number."""
    spare: float = 2.0
    """Mean number of neighbours, in those that are asked for, where these are looked for first."""
    largest_share: float = 0.04
    """Part of all points that the neighbours hold at most. With 0.05 twice the error does not allow for the edges of a
    square in 16 % of the records of 2,000 points; with 0.04 these have no region, and in 95 % of those of 10,000 points
    it does."""
    regular: float = 0.5
    """Part of the points without a neighbour that chance would leave, below which points keep away from each other."""
    crowded: float = 3.0
    """Mean number of neighbours, at least, where it is looked whether points keep away from each other."""


@dataclass(frozen=True)
class Recurrences:
    """Measures of recurrences."""

    fewest: int = 500
    """Smallest number of values for a result."""
    most: int = 10_000
    """Largest number of values: every vector is compared with all others."""
    followed: int = 20
    """Default number of steps over which neighbours are followed."""
    looked_at: int = 64
    """Steps, at most, at which their distance is taken: the time goes with the square of these."""
    blocks: int = 256
    shortest: int = 4
    """Steps, at least, over which the distance of neighbours must grow evenly."""
    near: float = 0.5
    """Mean logarithm by which they are nearer then than vectors far apart in time, at least."""
    coarse: int = 4
    """Steps to which the values of a series are rounded below which no dimension is looked for; with two it is too
    small by 4 per cent."""


@dataclass(frozen=True)
class Ties:
    """Orders of events that meet at once."""

    instant: float = 1e-9
    """Part of the time in which states change by their size within which guards are met in one instant."""
    most: int = 12
    """Events in one instant at most: more are a series that does not end there."""
    same: float = 1e-9
    """Difference of directions, and of states relative to their sizes, that counts as zero."""
    back: float = 1e-6
    """Distance, in parts of the states' sizes, within which a motion leads back to where it was."""
    most_on_the_way: int = 4096
    """Events on the way round an orbit, at most."""


@dataclass(frozen=True)
class Curves:
    """Invariant curves."""

    bend: float = 0.3
    """Largest angle between neighbouring chords, in radians: alpha_max of Krauskopf and Osinga."""
    bow: float = 0.1
    """Largest product of a chord's length and that angle, in parts of the spacing: their (delta alpha)_max, which
    bounds how far the curve is from its chords, by an eighth of it."""
    shortest: float = 1e-3
    """Chords, in parts of the spacing, that may bend as they like: Delta_min, at corners and at the tips of folds."""
    thin: float = 0.45
    """Part of all bounds up to which a chord may replace two."""
    lanes: int = 8
    """Parts into which a chord is split on the way to a break: this many runs take no longer than one."""
    beside: float = 100.0
    """Widths of a break's bracket from it at which the curve is looked at again."""
    continuous: float = 3.0
    """Factor by which a gap, or a speed, must be smaller at a break than at that distance from it; a square root gives
    10, a jump 1."""
    margin: float = 0.5
    """Width by which the curve is followed around the region, in parts of its sides."""
    halvings: int = 60
    """Halvings of the first segment."""
    second_order: float = 0.5
    """Part of an error that may be left when the first segment is halved, for it to count as one of second order: that
    leaves a fourth."""
    generations: int = 2000
    """Iterates of the first segment, at most."""
    away: int = 8
    """Iterates in a row outside the region after which a curve has left it."""
    in_a_row: int = 8
    """Points without a preimage in a row after which no further ones are tried."""
    neutral: float = 1e-6
    """Distance of a modulus from 1 up to which a multiplier counts as neutral: no curve grows along it."""
    noise: float = 16.0
    """Errors of the map below which what is left of an error of second order is rounding."""
    shortest_start: float = 1e-13
    """First segments, in parts of the region, below which rounding gives the direction."""
    most_crossings: int = 10_000
    """Intersections that are listed."""


@dataclass(frozen=True)
class SectionMap:
    """Images and preimages on a section."""

    events: int = 256
    """Rows of the table of events of a step; it is emptied as often as it is full."""
    steps: int = 40
    """Steps of Newton's method to a preimage."""
    halvings: int = 8
    """Halvings of such a step that does not lead closer."""
    same: float = 64.0
    """Errors of the map, in units of the tolerance, within which a point is met."""
    near: float = 100.0
    """Times the distance ``same`` up to which a point is met where round-off, or steps that change, leave no more."""
    settled: int = 4
    """Steps that may follow a residual within reach of the tolerance and none of which makes it smaller."""
    zero: float = 1e-13
    """Singular value, as a part of the largest, below which rank is lost where an event may lose it."""
    grid: int = 96
    """Starts along every axis from which preimages across a jump are guessed."""
    guesses: int = 8
    """Of these starts those with the nearest images, which are tried."""
    around: int = 9
    rounds: int = 4
    """Starts along every axis around each guess, and how often the search is repeated around the nearest of them."""


@dataclass(frozen=True)
class Precision:
    """What accuracy costs."""

    counted: int = 16
    timed: int = 64
    """Units over which steps and evaluations are counted, and of a run that is timed."""
    round_s: float = 0.02
    longest_s: float = 0.02
    """Time that one cell is meant to take in one round: short runs are repeated, long ones have fewer units."""
    undisturbed: float = 0.95
    """Share of a run's time for which it must have had the processor to count, if half of the runs had. Other work on
    the machine would otherwise lengthen long runs more often than short ones, and so one method more than another."""
    steps_at_one: float = 20.0
    """Steps a period of a method with fixed steps: this times tolerance^(-1/4), 200 at 1e-4."""
    longest_horizon: int = 3000
    """Units over which a trajectory is followed, at most, until it cannot be trusted."""
    same: float = 1.1
    """Ratio of two times within which they count as the same: as far as a busy machine lets one measure."""
    contradicts: float = 1e5
    rounding: float = 1e-11
    """An error of `contradicts` times the tightest tolerance, or times `rounding` if that is tighter, that has hardly
    fallen on the way there is no error of accuracy: the method and its reference compute different motions."""
    target: float = 1e-6
    """Distance, in sizes of the states, at which a chaotic trajectory has left the true one."""
    horizon_starts: int = 3
    """Starts of which the median of that time is taken."""
    cycle_steps: int = 4
    """Steps of Newton's method of each method to its own cycle."""
    safety: float = 0.8
    """Part of the step that the error of the last one allows."""
    guard_digits: int = 20
    """Further digits in which special functions are worked out."""
    apart: int = 25
    """Distance of the starts whose difference makes a tangent, in digits."""
    columns: int = 12
    tolerance: float = 1e-26
    other_columns: int = 10
    other_tolerance: float = 1e-24
    """Columns of the extrapolation and the local error of the reference, and of the second one that tells its error."""
    most_steps: int = 500
    """Steps of one arc; a field that needs more is too stiff for an explicit rule."""
    close: float = 1e-6
    """How far, in units, an event may lie from where doubles found it."""
    newton: int = 12
    """Steps of Newton's method to an event in extended precision."""
    max_period: int = 16
    """Longest cycle whose multipliers are measured, in forcing periods."""
    restarts: int = 32
    """Units of the survey that every method computes again."""
    start_newton: int = 6
    """Steps of Newton's method to a cycle."""


@dataclass(frozen=True)
class Edges:
    """Edges between basins."""

    parts: int = 9
    """Of a segment between two starts: the eight states between them run side by side, and none is its middle, which
    in a symmetric system lies on the edge itself."""
    least_steps: int = 1000
    """Steps within which two motions are to part, at least."""
    returns: float = 4.0
    """Distance to which the states of a cycle return, in parts of that at which two motions count as parted: in their
    middle each is off the edge by up to one half, and a stable direction adds as much."""
    positive: float = 3.0
    """Standard errors above zero from which an exponent counts as positive."""
    rank: float = 1e-13
    """Part of a derivative's norm below which a direction is lost."""


PLAN = Plan()
SECTIONS = Sections()
CYCLES = Cycles()
ATTRACTORS = Attractors()
WINDOWS = Windows()
COVARIANT = Covariant()
ESCAPES = Escapes()
BOUNDARIES = Boundaries()
SCALING = Scaling()
RECURRENCES = Recurrences()
TIES = Ties()
CURVES = Curves()
SECTION_MAP = SectionMap()
EDGES = Edges()
PRECISION = Precision()
