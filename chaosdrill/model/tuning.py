"""Numbers that tune how systems are read and compared, with their reasons; none of them is physics."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Tuning:
    """What bounds the work on expressions, and where numbers count as equal."""

    # texts
    letters: int = 10_000
    """Letters of one expression."""
    letters_together: int = 200_000
    """Letters of all expressions of a definition."""
    depth: int = 60
    """Parentheses, calls and operators inside each other; Python's own stack ends at some hundreds."""
    faults: int = 200
    """Faults of a definition after which no more are looked for: nobody reads more."""
    factors: int = 100
    """Factors of one product."""
    compared_parts: int = 200
    """Operations in what is compared, or in the argument of a function with kinks: sympy looks for the sign of it."""
    parts_of_mod: int = 30
    """The same for a remainder, of which sympy looks for more."""
    exponent: int = 1000
    """Largest numerator and denominator of a rational exponent."""
    bits: int = 4096
    """Bits of a whole number, and of numerator and denominator of a fraction."""
    written_fraction: int = 1000
    """Denominator in an exponent above which a fraction is written as the decimal number that it was read from."""
    far: float = 200.0
    """Logarithm of a number beside an exponential from which on the two are one: their product may be any double."""
    bounded: int = 200
    """Exponent at which an exponential ends within a function that has ended before, whatever factor down to 1e-70 is
    between them; three of its rates may be multiplied before they are no doubles."""
    passes: int = 4
    """Times that quotients and logarithms are looked for again in what has been made of them."""
    rewritten: int = 12
    """Times that what a quotient or a sum has become is rewritten itself: of 24,000 nested ones 5 sufficed."""
    same_ratio: float = 1e-14
    """Relative difference up to which the numbers of two sums have one ratio: they are rounded."""
    multiplied_out: int = 2
    """Hyperbolic functions in a term, at most, that become exponentials, each two of them."""
    zeros: int = 8
    """Order of a zero, at most, that is taken out of both sides of a quotient."""
    rest_terms: int = 5
    """Terms of a Taylor series that are too many to be taken away from a function: the code of its rest ends before."""
    rest_factors: int = 3
    """Functions in a product, at most, each of which becomes two terms."""
    smallest_value: float = 1e-300
    """Size of a power or an exponential below which it may have lost digits, as it is then near the smallest double."""
    arguments_shown: int = 6
    """Arguments of a Python function that are written out in formulas."""
    operations: int = 1000
    """Operations of one mode. With 800 of these its code is compiled in 8 s, that for lanes in 23 s, growing in
    proportion."""
    recent_systems: int = 32
    """Number of recent systems whose derived code is kept for others with the same equations."""

    # surfaces
    same_constants: float = 1e-15
    """Relative difference up to which two rounded constants count as equal."""
    equal_sides: float = 1e-15
    """Part of the terms of a comparison below which its sides count as equal."""
    kinks: int = 5
    """Surfaces of kinks, at most: the modes double with each of them."""

    # random places at which expressions are compared: the more differ nowhere by chance
    drawn: tuple[float, float] = (0.1, 1.5)
    """Range of sizes of states, times and parameters: of either side of 1, and none near 0."""
    drawn_below_one: tuple[float, float] = (0.1, 0.9)
    """The same where functions may end at 1, as roots and arc sines do."""
    near_values: tuple[float, float] = (0.7, 1.3)
    """Range of a parameter, as a multiple of its value, where what is asked holds near its value only."""

    # what a mode holds
    samples: int = 12
    """Places at which expressions are tried, with states near 1."""
    fewest_samples: int = 4
    """Places that must lie where all expressions are numbers."""
    sized_samples: int = 64
    """Places with states of other sizes: in some units a tenth of them tells what a unit hides, and 64 miss it once in
    a thousand."""
    doublings: int = 80
    """Doublings of these sizes, and halvings: units of 1e-24 to 1e24."""
    beside: float = 2.0**-46
    """Part by which places, and numbers in expressions, differ that are the same but for rounding."""
    plainly_none: float = 1e-2
    """Part of its terms above which an expression is not zero, without a look at its rounding."""
    clear: float = 1e3
    """Multiple of what an expression changes by between them above which it is not zero."""
    newton_steps: int = 25
    """Steps that bring a place onto surfaces; one that needs more is left out."""
    on_surface: float = 1e-13
    """Part of its terms that is left of a surface where a place lies on it."""
    vanishing: float = 1e-12
    """Part of its terms that round-off may leave of an expression that is zero; a rounded number such as 1/0.6 stands
    for the exact one."""
    null_weight: float = 1e-9
    """Singular value, as a part of the largest, below which a direction is a candidate for a null one; the expressions
    decide."""
    null_digits: int = 9
    """Digits of the candidate's entries, which then become fractions: one less than round-off leaves."""
    null_pivot: float = 1e-6
    """Pivot below which an entry of the candidates is zero, far above what rounding to digits leaves."""
    null_samples: int = 4
    """Times that the entries are taken at random numbers."""
    null_precisions: tuple[int, int] = (60, 120)
    """Digits in which an expression is evaluated that may be zero: terms that cancel leave the first few right."""
    simplified: int = 500
    """Parts of an expression that is simplified, at most: it takes seconds for one that is larger."""

    # periods
    repeats: float = 1e-10
    """Part of what a value moves within a period by which it may differ after one: phases are rounded."""
    repeats_rounded: float = 1e-6
    """The same, at most, after a period of numbers or a parameter written with fewer digits than a double has, and part
    of a number that half a unit of its last digit is of at most, if it was rounded."""
    multiples: tuple[float, ...] = (0.125, 0.2, 0.25, 0.5, *range(1, 13))
    """Multiples of a number that it may have been written as, as 3.1415927 twice: 1 has few digits in all of them."""
    rounded: float = 1e-13
    """Part of a value that is round-off of what does not move."""
    nudges: int = 16
    """Places by a few rounding units beside one at which it is seen how much of a value is round-off of what
    cancels."""
    nudge: int = 8
    """The largest of these, in rounding units."""
    cancelled: float = 30.0
    """Times what they change a value by up to which it is round-off."""
    sizes: tuple[float, ...] = (1.0, 1e-8, 1e-16, 0.0)
    """Sizes of states at which it is looked, one after the other: beside a state near 1 a drive of 1e-16 is nothing."""
    later: tuple[float, ...] = (0.6180339887498949, 0.41421356237309503)
    """Parts of a period after which it is seen how much a value moves: of no harmonic are they whole turns."""
    places_of_runs: int = 12
    """Places at which the functions of a run are looked at."""

    # conserved quantities
    digits: int = 30
    """Digits of their values, so that none is lost to what cancels."""

    # roots that touch their branch points
    decomposed_parts: int = 200
    """Parts of an expression that is decomposed; larger ones are left to the run, as are those of the next two."""
    terms: int = 2000
    """Largest number of terms of a polynomial, from its degree and variables."""
    degree: int = 12
    """Degree of a polynomial that is factored further than into squares."""
    turns: int = 6
    """Highest multiple of an angle, or of an exponent, that is taken apart."""
    draws: int = 12
    """Sets of values of the other variables at which a change of sign is looked for; the first is zero."""
    drawn_decades: float = 6.0
    """Powers of ten on both sides of 1 from which these values are drawn."""
    decades: int = 30
    """Powers of ten on both sides of 1 at which signs are looked at: no unit is out of reach."""
    each_decade: int = 8
    """Places in each of them."""
    off_round: float = 1.0371
    """Factor of these places: no round number, at which a factor might be zero."""
    halvings: int = 60
    """Halvings of an interval in which a sign changes: more than a double has digits."""
    zeros_together: float = 1e-11
    """Part of a place within which two factors that change their signs do so together."""
    zeros_at_zero: tuple[float, ...] = tuple(10.0**k for k in range(-24, -2, 3))
    """Distances from zero within which they do."""
    straight_parts: tuple[float, ...] = (1.0, 0.8, 0.6, 0.4, 0.2)
    """Parts of such a distance at which a factor is compared with a straight line."""
    straight: float = 1e-2
    """How far it may be from one, relatively, for its zero to be told by its values."""


TUNING = Tuning()
