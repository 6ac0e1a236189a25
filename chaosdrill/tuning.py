"""Numbers that tune what is shown and read, with their reasons; no result depends on them."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Tuning:
    """What messages show, how often progress is shown, and what files of others may hold."""

    # messages
    letters: int = 100
    """Letters of a name that a message shows."""
    names_shown: int = 100
    """Names that a message shows."""
    nearly: float = 0.85
    """Ratio of equal letters above which a name is meant, even if another one stands in it as a word."""
    close: float = 0.7
    """Ratio above which a name is meant that begins with another letter."""
    least_part: int = 4
    """Letters of a word that suggests the names which contain it,"""
    most_meant: int = 5
    """if they are no more than these."""

    # progress
    redraw_s: float = 0.1
    """Seconds between two looks of a bar: faster ones cannot be read."""
    line_s: float = 10.0
    """Seconds between two lines where no bar can be drawn."""
    window_s: float = 10.0
    """Seconds of which the rate is taken, but for the last line, which has the mean of all its time."""
    delay_s: float = 1.0
    """Seconds after which work is shown without being asked for."""
    worth_s: float = 1.0
    """Seconds of compilation that are worth a word in the last line."""

    # files
    old_s: float = 30 * 86400.0
    """Seconds after which an untouched draft counts as abandoned, on whichever machine it began."""
    most_links: int = 40
    """Links that lead one to the next, as many as Linux follows."""
    json_bytes: int = 2**26
    """Size of a file of JSON that a stranger may have written,"""
    json_depth: int = 64
    """and how deep its lists and tables may be."""

    # arguments
    listed: int = 10**8
    """Entries of an array that is given for a list."""


TUNING = Tuning()
