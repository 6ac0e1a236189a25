"""Numbers that bound a page, with their reasons; none of them is a result."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Tuning:
    """How much of an archive a page shows: it is one file that a browser reads as a whole."""

    pictures: int = 100
    """Pictures, of which each takes about a second and some hundred kilobytes."""
    svg_bytes: int = 500_000
    """Size above which a picture is stored as PNG, whose size does not grow with the number of its points."""
    whole_charts: int = 2
    """Interactive charts of the largest size; more charts share it."""
    section_bytes: int = 6_000_000
    """Sections in one chart."""
    grid_bytes: int = 6_000_000
    """Everything else in it."""
    systems: int = 10
    """Systems of an archive without a scene: more, as of a sweep by hand, differ in numbers alone."""
    equations: int = 200
    """Equations above which a system is not written out: a notebook stores them for every such cell."""
    rows: int = 200
    """Rows of a table."""
    intervals: int = 60
    """Rows of a table of intervals, which beyond that are those of noise."""
    title: int = 200
    """Letters of a title."""
    argument: int = 200
    """Letters of an argument."""
    text: int = 20_000
    """Letters of any other text."""
    narrow: int = 24
    """Letters in a narrow column; longer texts need more width."""
    digits: int = 12
    """Digits of numbers from which a run can be begun again: states and parameters."""
    trusted: float = 1e-6
    """Error up to which a chaotic trajectory counts as known."""


TUNING = Tuning()
