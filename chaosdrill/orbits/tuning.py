"""Numbers that tune the search for orbits and their continuation, with their reasons; none of them is physics."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Tuning:
    """What steers the numerics of this package; distances of orbits are in the norm of `Problem.weights`."""

    sized_units: int = 4
    """Forcing periods, or characteristic times, over which it is looked how large the states are."""
    off_linear: float = 0.25
    """Part of the linear response by which a motion beside another may be off: then the next order of the response,
    which a pitchfork or a fold lives on, is about as large."""
    range_powers: tuple[float, ...] = (-960.0, -120.0, 120.0, 500.0)
    """Binary powers between which displacements of states that stay zero are tried: usually 1e-36 to 1e36, and beyond
    from where doubles have all their digits to where their squares have."""
    range_stride: float = 5.0
    """Binary powers from one displacement to the next: the first that is not linear is not so large that a motion on a
    fifth power is a thousand times as fast."""
    range_precision: float = 1e-4
    """Binary powers to which the farthest linear displacement is known: steps are then as long in any unit."""
    smallest_size: float = 0.1
    """Part of that size by which a state counts at least, where it is smaller along an orbit."""

    rounded: float = 1e-13
    """Part of what changes of other states by their sizes make of a state below which its value is their rounding."""

    # Newton's method
    residual: float = 3e-13
    """Residual at which an orbit is found: what is left when all equations hold to rounding."""
    residual_of_steps: float = 1e-2
    """Part of the tolerance that may be left of a residual: steps change with the state, and with them their errors."""
    newton_steps: int = 30
    """Steps that Newton's method may take from a guess."""
    linear: float = 0.1
    """Part of a shortened step by which the rest of the way may change where equations count as linear."""
    sharp_events: float = 1e-3
    """Error of an event's time, as a part of the segment before it, up to which it counts as met."""
    sharper_steps: int = 3
    """Further steps that an orbit gets for it; near grazing it may be out of reach."""
    off_guard: float = 1e-9
    """Way to a guard, as a part of an orbit's duration, from which on an event at the end of no time is not on it."""
    smallest_pivot: float = 1e-11
    """Pivot, where the largest entry of a row is 1, above round-off: entries are known to about 1e-13 at best."""
    smallest_singular_value: float = 1e-10
    """Singular value, as a part of the largest, below which linearised equations depend on each other."""
    dependent_by: float = 0.05
    """The same, as a part of the accuracy of a motion: at most 0.01 of it is left where a quantity is conserved."""
    closes: float = 1e-9
    """Residual of a guess that closes, so that its equations tell whether it is one of a family."""
    closes_by: float = 100.0
    """Times the accuracy of a motion that it may be, since it is not known any better."""
    of_family: float = 10.0
    """Times that residual, the singular value of a guess that closes, as a part of the largest, below which it may be
    one."""
    beside_family: float = 1e-3
    """Distance of another orbit of a family, in the norm of the weights, that shows that it is one."""
    reach_beside: float = 0.2
    """Longest correction by one step beside a known orbit, in the norm of the weights."""
    tangent_error: float = 1e-13
    """Error of an entry of a tangent map, relative to its largest one."""
    coarser: float = 10.0
    """Times the tolerance, for steps whose errors are several times as large."""
    coarser_steps: float = 1.5
    """Times the length of fixed steps for the same: five times the error of order four."""
    rounding: float = 1e-15
    """Residual that rounding leaves at least."""
    rounding_of_maps: float = 10.0
    """Times that, and the largest derivative, that the residual of a map may be when it becomes no smaller."""
    hidden: float = 8.0
    """Times the part by which coarser steps change the numbers of an orbit, for errors that two of them may share: so
    999 of 1,000 derivatives of closed forms are within their errors (six times: 998)."""
    states_to_parameters: float = 0.2
    """What a change of a state by its size counts along a branch, where one of the parameter by its range counts 1."""
    response: float = 0.01
    """What a branch changes the states by at its start, at least, where it changes the parameter by 1: the usual part
    in wide ranges. In a narrow one they count for more."""
    least_response: float = 1e-8
    """Below this, round-off may be all that changes them."""
    unit: float = 1.0
    """Longest step of systems without a period."""

    # initial guesses
    characteristic_units: int = 32
    """Units over which the motion is looked at."""
    characteristic_samples: int = 8
    """Samples a unit."""
    characteristic_rounds: int = 8
    """Times that the unit is improved, at most."""
    characteristic_steps: int = 2000
    """Steps that the motion may take in all units together before they are too long."""
    characteristic_ratio: float = 2.0
    """Ratio of two successive units that is good enough."""
    most_events: int = 4096
    """Events of one orbit; more are chatter that is not completed."""
    returns_recorded: int = 256
    """Periods over which the nearest returns are looked for."""
    sooner: float = 3.0
    """Times the distance after a period within which a state is back after a part of it that counts."""
    places: int = 8
    """Places from which an orbit near an attractor is looked for."""
    return_units: tuple[int, ...] = (32, 256, 2048)
    """Characteristic times within which a system without a period is to return, each tried where none before did."""
    slower_unit: float = 8.0
    """Factor of the characteristic time after which a motion that may be slow is looked at again."""
    drifts: float = 1e-6
    """Change of the way of a state within equal times, as a part of it, up to which it drifts, and of a guard's value
    in which parts of several states are left to move it."""
    slow_steps: int = 200_000
    """Steps up to which a motion that has not returned is followed for longer, a second or so."""
    transient_parts: int = 64
    """Parts of a transient given as a time."""
    return_samples: int = 64
    """Samples a unit, where a path without events is searched for its return."""
    to_plane: int = 6
    """Corrections of the time of a return by the flow, which differs from that at the start by the distance."""
    left: float = 0.2
    """Part of the extent of a state by which a motion without events has left its start, and is back."""
    back: float = 0.05
    """Part of the spread of the states within which a state counts as back."""

    # one orbit
    guesses: int = 6
    """Times that the events of a guess are read again, at most."""
    reaches: tuple[float, ...] = (0.5, 0.1)
    """Longest corrections by one step with which Newton's method is tried, one after the other."""
    converging: float = 1e-2
    """Residual below which Newton's method is given more time."""
    same_point: float = 1e-7
    """Difference relative to the size of the states below which two points of an orbit are one."""
    most_turns: int = 64
    """Times that an orbit of a smooth flow may have been gone through, at most."""
    slip_at_rest: float = 1e-3
    """Part of the duration that a slip without motion takes at most."""
    at_rest: float = 1e-9
    """Part of its size by which a state moves at least along an orbit, if it is not a point at rest."""
    phases: int = 16
    """Phases of the forcing at which the Jacobian about a rest is compared: harmonics up to half of them are seen."""
    watched_units: int = 64
    """Periods, or characteristic times, over which a state that only grows is distinguished from one that returns."""
    watched_samples: int = 16
    """Samples in each of them: with a wrong period a motion to and fro is seen later and later on its way."""
    repeats: float = 1e-6
    """Part of its size by which a state differs at most after a number of periods after which the motion repeats."""
    path_parts: int = 8
    """Parts of a segment with which its path begins."""
    path_halvings: int = 16
    """Times that a part is halved at most: a spike is seen that takes a millionth of its segment."""
    chord: float = 5e-4
    """Distance of a path from straight lines between its points, in parts of its extent, that is not seen."""
    same_instant: float = 1e-12
    """Part of the duration by which two instants differ that are one."""
    evenly: float = 0.4
    """Part of its whole way, to and fro, by which such a state goes on in either half of that."""

    # all orbits up to a period
    record: int = 3000
    """Strobes, events or maxima recorded from each start."""
    random_starts: int = 500
    """Random starts beside the given ones."""
    short_record: int = 8
    """Record of a random start, in units of the longest period that is looked for."""
    wider: float = 0.5
    """Part of the extent of the recorded states by which the box of random starts reaches beyond them on every side."""
    open_rounds: int = 3
    """Times that random starts are drawn where motions escape: each time from the box of what is known by then."""
    beside_lasting: tuple[float, float] = (-2.5, -0.5)
    """Orders of magnitude of the distances, in extents, of starts beside states from which the motion went on."""
    turn_samples: int = 128
    """Samples from one maximum of a smooth motion to the next."""
    pieces: int = 256
    """Pieces of motions, from one recorded state to the next, of which rounds are made where motions do not return."""
    pieces_of_one: tuple[int, int] = (16, 64)
    """Pieces by one sequence of events, however many or few such sequences there are: at least, and at most."""
    words: int = 1000
    """Orders in which pieces may follow each other in a round that are tried."""
    event_units: int = 16
    """Units of the characteristic time in which an event is waited for."""
    attempts: int = 300
    """Attempts in a row that find nothing new, after which a period is left."""
    attempts_beyond: float = 1.0
    """As many attempts in a row as this times those that led to the last new orbit, if they are more."""
    same_orbit: float = 1e-6
    """Difference relative to the extent of the motion below which two orbits are one."""
    path_samples: int = 4096
    """Samples along an orbit without events on which the start of another one is looked for."""
    path_closer: int = 4
    """Times that the nearest place of a path is looked for in a shorter part of it."""
    path_distance: float = 1e-4
    """Distance from the path, relative to the extent of the motion, within which it passes a point."""
    taken: float = 0.3
    """Part of the distance of a return within which a known orbit lies that probably is the one it leads to."""

    # multipliers and checks
    graded: float = 1e-3
    """Part of the norm of the tangent map below which a multiplier is not read off the map as a whole."""
    graded_along: float = 1e-6
    """The same along branches, where many trials between two points ask for multipliers."""
    strained: float = 1e4
    """Norm of the tangent map of an autonomous system, in parts of its largest multiplier, above which multipliers are
    those of its pieces across the flow: of the map as a whole they have half of their digits left."""
    graded_rounds: int = 12
    """Rounds of simultaneous iteration, at most: multipliers less than 15-fold apart are then taken together, whose
    block keeps 13 digits."""
    graded_near: float = 0.1
    """Ratio of two moduli above which multipliers that the map as a whole shows are taken together from the start."""
    graded_turned: float = 1e-14
    """What is left of a wrong direction when two multipliers count as distinct."""
    piece_condition: float = 1e4
    """Condition number of a piece of a segment that is not cut any further."""
    piece_halvings: int = 10
    """Times that a segment is halved, at most."""
    growth_halvings: int = 6
    """Times that it is halved to see where in it deviations grow: a canard takes a tenth of its orbit."""
    exponent_rounds: int = 200
    """Rounds that tangents are given to turn into their directions."""
    exponent_turned: float = 1e-12
    """What is left of a wrong direction after the rounds between multipliers that are distinct."""
    smallest_logarithm: float = -700.0
    """Logarithm of a multiplier that is near the smallest double."""
    same_logarithm: float = 1e-9
    """Difference of logarithms of multipliers, or of their product, that counts as none, at the best."""
    quadrature_pieces: int = 4
    """Pieces of a segment in the first quadrature."""
    quadrature_error: float = 1e-11
    """Difference between a piece and its halves, relative to max(1, integral), that is negligible."""
    quadrature_halvings: int = 48
    """Times that a piece is halved, at most: a jump of a stiff motion takes so short a part."""
    step_error: float = 1e-15
    """What a step adds to the difference after a shot, beside the tolerance."""
    slack: float = 1e3
    """Steps, and how unevenly they count, in the difference after a period that round-off and the tolerance explain."""
    named_events: int = 12
    """Events that are all named where a run meets others; of longer orbits the first that differs."""
    closed: float = 1e-3
    """Largest difference after a period of an orbit that counts as closed, whatever explains it."""
    fast_growth: float = 1e4
    """Growth of small deviations over a period above which it is verified in parts."""
    most_parts: int = 256
    """Parts of a shot, at most."""

    # continuation
    predictor_points: int = 4
    """Points through which the predictor goes."""
    first_step: float = 0.1
    """First step, as a part of the longest."""
    shortest_first: float = 1e-6
    """First step, as a part of the longest, after which orbits that do not exist are taken to begin at once."""
    prediction_error: float = 1e-5
    """Error of prediction, in the norm of the weights, to which steps are adapted."""
    bend: float = 0.97
    """Cosine of the largest angle between the curve's directions at two points."""
    farthest: float = 0.05
    """Distance from its prediction at which an orbit does not belong to the curve, and longest correction by
    one step of Newton's method."""
    aside: float = 0.5
    """The same as a part of the step: the predicted direction is off by less than the curve may bend, whose sine is
    about a quarter."""
    straight_on: float = 0.01
    """Part of the last step below which the tangent alone predicts the next point."""
    again: float = 0.125
    """First step, in parts of one that has led over a sharp fold, where the way there is followed again."""
    shortest_step: float = 1e-7
    """Part of the longest step below which the curve is lost."""
    apart: float = 1e-8
    """Distance of two points from which on they give the curve's direction."""
    bisections: int = 60
    """Halvings of the step in which the events change, or two halves of an orbit come together."""
    section_points: int = 10
    """Points for which one plane across the flow serves, before the flow may come to lie in it."""
    aside_between: float = 3.0
    """The way by an orbit between two others, as a part of the distance of these, from which on it is another one."""
    plane_samples: int = 64
    """Parts of an orbit without events between which it may cross a plane more than once unseen."""
    same_frequency: float = 0.3
    """Part by which the frequency of an orbit may differ from that at the Hopf point that it shrinks to."""
    collapsed: float = 1e-4
    """Part of the first duration below which an orbit that shrinks onto a point is followed no further: there rounding
    moves the parameter by less than it is known by extrapolation."""
    beside_centre: float = 1e-3
    """Part of the parameter's range from a centre at which its family is taken to end there."""
    same_limit: float = 1e-10
    """Part of the parameter's range by which a point that orbits shrink to may lie beyond the range."""
    end_of_curve: float = 1e-3
    """Part of two steps of a curve within which a tangency comes to be of third order that does so at its end."""
    same_power: float = 0.3
    """Part of one by which the power with which the squares of amplitudes shrink may be off a whole number."""
    secant_steps: int = 12
    """Steps of the secant method, at most."""
    secant_step: float = 1e-13
    """Step of the secant method that counts as none."""
    secant_noise: float = 1e-11
    """Step from which on the slope is kept, since differences of the function may be round-off."""
    difference: float = 1e-5
    """Distance over which the function is differenced at the first point."""

    # special points
    straight: float = 1e-9
    """Residual between two points of a branch up to which the line between them is the branch."""
    missed_multiplier: float = 1e-3
    """Distance of a multiplier from the value that it is to have at a special point, at most."""
    same_crossing: float = 1e-6
    """Part of a step within which multipliers cross together: nearly equal ones are known to the root of the
    round-off."""
    sharp_nodes: int = 8
    """Points beside a crossing of branches from whose polynomial its place is taken."""
    sharp_reaches: tuple[float, ...] = (0.8, 0.4, 0.2, 0.1)
    """How far they reach, in parts of the step; the best is taken."""
    jump: float = 0.1
    """What is left of a function where its sign changes, as a part of its values beside, if it jumps there."""
    real: float = 1e-6
    """Imaginary part of a multiplier, as a part of it, up to which it may be one of two equal real ones."""
    singular: float = 0.1
    """Smallest singular value of the equations, relative to that of the neighbours, where two branches cross."""
    hardly_singular: float = 0.5
    """The same, up to which it is looked at again, at a sharper place."""
    finer: int = 2
    """Times that a step is taken in smaller ones where what happens in it is not found."""
    finer_parts: int = 24
    """Smaller steps for one."""
    guard_samples: int = 512
    """Instants of a segment at which guards are looked at."""
    touching: float = 1e-6
    """Greatest value of a guard, and speed at an event, that count as zero at a border: as parts of those before."""
    before_touch: float = 0.99
    """Part of the last step before a touch up to which special points are looked for: multipliers go with one over the
    speed at it, so that they are a hundred times as large there as at the beginning of the step."""
    far_touch: float = 0.05
    """Greatest value of a guard, as a part of how much it varies on the segment, beyond which it is no touch."""
    touch_probe: float = 1e-5
    """First difference of two instants, as a part of the orbit, in the search for the greatest value."""
    touch_settled: float = 1e-9
    """Change of the instant, as a part of the orbit, at which the value is exact: it changes with the square."""
    touch_steps: int = 20
    """Steps of the secant method, at most."""

    # normal forms
    difference_distances: tuple[float, ...] = (0.1, 0.05, 0.025, 0.0125, 0.00625, 0.003125, 0.0015625, 0.00078125)
    """Distances of differences, in sizes of the states: the nonlinearity may show at any of them."""
    least_distances: int = 4
    """How many of these are to have values: two tell no error, and a third one no order."""
    halved_distances: int = 6
    """Smaller distances, by halves, where fewer have: a population must not become negative."""
    sign_known: float = 1e-3
    """Error of a coefficient along a curve, as a part of it, at which its sign is known."""
    difference_safety: float = 3.0
    """Times the difference of two extrapolations that their error is: the best of many is chosen by luck as well."""
    converged_path: float = 1e-9
    """Correction of an event's time, as a part of the period, at which only round-off is left if none is smaller."""
    mean_places: int = 32
    """Places along an orbit at which the mean square of a deviation is taken first; then at twice as many each time."""
    mean_known: float = 1e-9
    """Change of the root mean square, as a part of it, at which it is known: as well as coefficients are at best."""
    most_places: int = 512
    """Such places at most: the equations at them take the square of their number."""
    resonant: float = 1e-4
    """Distance of a low power of a multiplier from 1 at which another normal form holds."""
    crossing_known: float = 1e-3
    """Error of the orbit at a point where branches cross, in sizes of the states: with a symmetry the third root of
    its residual, and the terms that it mixes in."""

    most_returns: int = 1000
    """Returns after a grazing event until one multiplier tells them all: their ratio goes with the number."""

    # changes of the event sequence
    border_steps: tuple[float, ...] = (0.0, 1e-5, -1e-5, 1e-4, -1e-4, 1e-3, -1e-3, 1e-2, -1e-2)
    """Lengths along a new branch at which its first orbit is tried."""
    reflected_steps: tuple[float, ...] = (1e-8, -1e-8, 1e-7, -1e-7, 1e-6, -1e-6)
    """Lengths tried before these where only an event passes the reflection of a symmetry, and the branch is smooth."""
    loose: float = 1e-6
    """Singular value of the equations, as a part of the largest, below which what makes it zero at a border is near:
    further off, the direction of a branch is known to a part of 1e-7."""
    border_beside: tuple[float, ...] = (0.0, 1e-11, -1e-11, 1e-9, -1e-9, 1e-7, -1e-7, 1e-5, -1e-5)
    """Changes of the parameter, relative, at which the events of the system's own path are read."""
    border_near: float = 0.1
    """Distance from the border, in the norm of the weights, within which an orbit belongs to it."""
    begins: float = 1e-5
    """Distance from a border to which the orbits of a branch that begins there are followed back."""
    root_near: float = 10.0
    """Distance from a border, in roots of its error, within which an orbit begins there."""
    way_back: tuple[float, ...] = (0.5, 0.125, 0.03)
    """Steps back to a border, as parts of the distance from it, of which the first that leads nearer is taken."""
    nearer: float = 0.7
    """What such a step leaves of the way, at most."""
    border_tried: int = 60
    """Sequences of events that are tried behind a border."""
    same_cycle: float = 0.02
    """Difference of durations, as a part of the whole, within which two cycles of the same events are one."""
    border_probe: float = 1e-5
    """Step along a new branch that shows which way leads away from the border."""
    passing_samples: tuple[int, int, int] = (64, 5, 8)
    """Instants of a segment at which it is looked how near an orbit passes, times that they are laid closer, and places
    of its whole length beside which they are."""
    end_of_stay: float = 1e-6
    """Part of a stay, from either end, within which what is met belongs to the event there."""
    tangential: float = 1e-3
    """Speed relative to how fast a guard changes on the way below which a guard is met tangentially."""
    known_from: float = 1e-12
    """Smallest part of a step before a border at which it is seen how well orbits are known."""
    known_tried: int = 12
    """Orbits at which it is seen: their distance from the border within a tenth of itself."""
    same_path: float = 1e-4
    """Distance in the norm of the weights within which two sequences of events follow one path at a border."""
    ahead: float = 1e-3
    """Step along the branch behind a border to an orbit whose new events are not as slow as can be."""
    shifts: tuple[float, ...] = (1e-4, -1e-4, 1e-5, -1e-5, 1e-6, -1e-6)
    """Changes of the second parameter, as parts of its range, at which a first point beyond is looked for: behind
    a touch orbits change with the root of the distance, and far ones are not reached."""
    joined: float = 5e-3
    """Distance, and part of the ranges, within which that point belongs to the border."""

    # branches
    most_borders: int = 200
    """Borders that one branch may cross."""
    meeting: float = 1e-6
    """Distance in the norm of the weights at which two orbits of the same events are one."""
    at_bounds: float = 1e-3
    """Distance from a bound, in parts of the range of a branch's orbits, within which the last one is at it: bounds may
    be far apart, or infinite."""
    longer: float = 3.0
    """Growth of the duration along a segment of an orbit that approaches a point at rest."""
    halves: float = 0.05
    """Difference between the halves of a doubled orbit, as a part of the largest, at which it ends as one."""
    opened: float = 2.0
    """Times the difference between the halves at the end of a branch that an orbit has from which the way to the
    doubling is taken: rounding makes little of what is left."""
    together: float = 0.01
    """Difference between them, as a part of those at two orbits on either side, at which they coincide in between."""
    no_effect: float = 1e-12
    """Slope of what makes an orbit over the parameter below which a parameter does nothing to it."""
    upright: float = 1e-6
    """Part of the direction of a branch that changes the parameter, below which it is asked whether it ever changes."""
    family_ways: tuple[float, ...] = (0.1, 0.01, 0.001)
    """Ways along a branch over which it must not change: the longest on which there are orbits."""
    family_step: float = 0.5
    """Longest step along orbits at one value of the parameter, in the norm of the weights: they may reach to bounds."""
    steps_between_doublings: int = 20
    """Steps in the distance between two doublings, from which on those of the branches that follow grow."""
    steps_beyond_doublings: int = 8
    """Steps in the way along a branch from the doubling at which it was born."""
    beside_special: float = 0.01
    """Part of the longest step by which a branch is started beside a special point."""
    near_special: float = 1e-2
    """Distance of a multiplier from 1 or -1 at which a first orbit may be near a special point."""
    doubling_distances: tuple[float, ...] = (1e-3, 3e-3, 3e-4, 1e-2, 1e-4, 3e-2)
    """Distances from the doubling at which the doubled orbit is tried, in the norm of the weights."""
    most_together: int = 4
    """Multipliers that are 1 together, at most, where the branches that cross are followed: with each there are three
    times as many directions."""
    most_axes: int = 3
    """Axes, at most, between which the first directions lie."""
    most_ways: int = 400
    """Directions, at most, in which these branches are looked for: between all pairs of many there are too many."""
    branch_near: float = 0.3
    """Part of that distance, or its inverse, in which an orbit of one of several branches through a point is found: the
    way there is at an angle to the branch."""
    branch_apart: float = 0.99
    """Cosine of the angle between two of these branches below which they are two."""
    doubling_shorter: int = 4
    """How often a distance is shortened over which the parameter changes too much."""
    repeated: float = 1e-6
    """Difference relative to the size of the states below which two turns of an orbit are one."""
    doubling_apart: float = 0.01
    """Difference between the two halves of a doubled orbit, as a part of that distance, at least."""
    grazing_speed: float = 1e-9
    """Speed at a guard below which it counts as met tangentially, in parts of `Problem.paces`."""
    clear: float = 1e-4
    """Speed at a guard, in parts of `Problem.paces`, part of an orbit's duration that a segment takes, and way from the
    ends of a branch, below which a run cannot judge an orbit."""
    checked: int = 4
    """Points of a segment that the ordinary engine follows as well, at most."""

    # functions of an orbit
    function_pieces: int = 64
    """Pieces of a segment in a quadrature, at most; what more would change is part of the error."""
    function_error: float = 1e-13
    """Part of an integral by which twice as many pieces may change it for these to be enough."""
    function_grid: int = 64
    """Parts of a segment at whose ends a greatest value is looked for first."""
    function_narrowest: float = 1e-8
    """Part of a segment at which the greatest value is known to round-off: it changes with the square."""
    function_shift: float = 1e-6
    """Part of the size of a state by which it is changed to see what its error does to a function."""
    function_nodes: int = 9
    """Points of a branch from whose polynomial an optimum is taken."""
    function_step: float = 1e-3
    """Step of the differences, in the norm of the weights, whose vanishing makes an optimum."""


TUNING = Tuning()
