"""Numbers that bound the work on scenes, with their reasons; none of them changes a result."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Tuning:
    """What a scene of a stranger may ask for before anything is run."""

    bytes: int = 1_000_000
    """Size of a scene: larger ones hold something else."""
    silence_s: float = 60.0
    """Silence of the writer of a pipe after which it is given up: to write a scene takes seconds."""
    key_parts: int = 64
    """Parts of a dotted key: the time of tomllib grows with the square of its length."""
    digits: int = 400
    """Digits of a number: no double is longer, and Python reads integers of some thousands of digits at most."""
    key_parts_set: int = 16
    """Parts of a key that is set on the command line: no table of a scene is so deep."""
    faults_shown: int = 50
    """Faults of a scene that a message lists, more than anybody reads."""
    pieces: int = 120
    """Pieces of a drive: every piece is at least one mode, and a system has at most 127."""
    sliding_operations: int = 200
    """Operations of one field beside a switching surface: the sliding mode is a fraction of both, which is
    simplified."""
    sliding_power: int = 8
    """Exponent of a sum in it, which is expanded; such sums must not be nested."""


TUNING = Tuning()
