"""Numbers that tune when two archives agree, with their reasons."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Tuning:
    """How far results of two machines or versions may be apart; errors that are stored count beside these."""

    stated: float = 1e-8
    """Relative error within which cycles and multipliers agree, at tolerances of 1e-11 and less."""
    per_tolerance: float = 1e3
    """That error over the tolerance of the method, at larger tolerances."""
    deviations: float = 8.0
    """Standard errors within which averages agree: errors rest on few frequencies; five are exceeded once in 10,000."""
    bar: float = 30.0
    """Factor within which the error bars of two runs agree: with so few frequencies ten is passed in one of 500."""
    magnitude: float = 10.0
    """Factor within which orders of magnitude agree."""
    round_off: float = 1e-9
    """Size below which they are round-off."""
    average: float = 0.1
    """Part of an average without an error, and of 1, within which two agree."""
    jump: float = 1e4
    """Growth of the distance of two runs from one sample to the next that is no divergence but a jump."""
    least_distance: float = 1e-15
    """Distance, in the sizes of the states, that counts before it: their rounding."""
    margin: float = 0.25
    """Part of the range of a record by which another one may leave it after they have diverged."""


TUNING = Tuning()
