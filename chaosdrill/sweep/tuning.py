"""Numbers that tune how tasks are shared out and kept, with their reasons; no result depends on them."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Tuning:
    """What steers chunks, schedulers and the folders of results."""

    # chunks
    chunk_s: float = 1.0
    """Seconds that a chunk is to take: long beside what it costs to hand it out and keep it, short enough to lose."""
    last_chunk_s: float = 0.05
    """Seconds of the last chunks of a sweep, by which workers may end apart."""
    first_units: int = 8
    """Units of the first chunks, where there are many, or one worker: kernels step this many in the time of one."""
    growth: int = 8
    """A chunk has at most this many times as many units as the largest one before it."""
    most_units: int = 4096
    """Units of one chunk."""
    chunk_bytes: int = 2**24
    """Results of one chunk, of which several are under way at once."""
    least_cost_s: float = 1e-9
    """Seconds that a unit counts at least, where the clock has seen none."""
    ahead: int = 2
    """Chunks under way for each that can run at once, so that no worker waits for the next one."""

    # schedulers
    answer_s: float = 10.0
    """Seconds within which a scheduler is to answer."""
    count_s: float = 1.0
    """Seconds between two looks at how many workers there are."""

    # folders
    result_bytes: int = 16_000_000_000
    """Size of the results of a sweep: a slip of the pen must not fill a disk."""
    looks: int = 16
    """How often results are read, on average over all of them, where chunks overlap."""
    differences_shown: int = 12
    """Differences between two sweeps that a message names."""
    letters_shown: int = 60
    """Letters of each."""


TUNING = Tuning()
