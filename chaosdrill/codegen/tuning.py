"""Numbers that tune the code that is written for a system, with their reasons; none of them is physics."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Tuning:
    """What code is written how; none of it changes more than rounding."""

    # files
    old_s: float = 30 * 86400.0
    """Seconds for which code is kept that nobody uses, as several versions of the package and of systems share a
    folder."""
    record_bytes: int = 2_000_000
    """Size of a record; a system with a larger one is derived again in every process."""

    # expressions
    multiplied: int = 4
    """Largest whole exponent that is written as products."""
    long_sum: int = 16
    """Terms of a sum, above which it stays a node of its own where it is part of another."""
    sums_alike: int = 8
    """Long sums that a new one is compared with, to be written as one of them and the difference."""
    product: int = 10
    """What a product of two series costs, in products of a number and a series."""

    # series
    products_in_line: int = 48
    """Products of series of a mode whose operations are written in line; of a larger one they stand in tables."""
    sums_in_line: int = 8 * 48
    """The same for terms of sums."""
    orders_in_pass: int = 4
    """Orders done in one pass."""
    chains: int = 4
    """Sums that a product of series is added up in, so that none waits for the one before it."""

    # functions side by side
    largest_angle: float = 1e5
    """Largest argument of a sine or cosine for which the reduction is exact enough."""
    largest_exponent: float = 700.0
    """Largest argument of an exponential that neither overflows nor is subnormal."""

    # events
    onto_guard: float = 100.0
    """Tolerances, in scales of the states, within which a state is put onto the guard that it has met."""
    hiding_degree: int = 9
    """Degree from which on a power may hide: the next lower ones show in one of the last eight terms of a series."""
    told_nodes: int = 200
    """Nodes of a derivative of a reset or an image, up to which it is told from its rounding. That of the composition
    of many maps would take longer to derive than anybody waits."""
    unknown_exponent: int = 10
    """The exponent that counts where it is a parameter."""


TUNING = Tuning()
