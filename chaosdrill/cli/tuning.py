"""Numbers that tune what commands print and how they end, with their reasons; no result depends on them."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Tuning:
    """How long an interrupt waits, and how much of a result is printed."""

    patience_s: float = 2.0
    """Seconds after which a message mentions the second Ctrl-C: most pieces of work end before."""
    retry_s: float = 0.05
    """Seconds after which an interrupt that came within the compiler is tried again."""
    short_list: int = 8
    """Entries of a list that stands on one line of a summary."""
    lines: int = 60
    """Lines about orbits and branches, which a terminal shows without scrolling far; the archive has all."""


TUNING = Tuning()
