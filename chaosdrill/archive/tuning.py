"""Numbers that tune how archives are written and read, with their reasons; no result depends on them."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Tuning:
    """What steers files; bounds of what a stranger wrote stand in `chaosdrill.archive.inside`, which runs alone."""

    level: int = 4
    """Level of compression: higher ones take twice the time for some hundredths of the size."""
    digest_entries: int = 2**18
    """Entries of a variable that are brought into one form at once: 2 MB stay in the cache."""
    digest_bytes: int = 2**20
    """Bytes of a file that are read at once."""
    patience_s: float = 60.0
    """Seconds within which the process that reads must send something more. A file that keeps it busy ends earlier, by
    processor time (`inside`); a longer silence is that of the machine."""
    told_bytes: int = 2**28
    """Bytes of plain values that are sent at once."""
    files_each: int = 200
    """Files that one process reads; what the library keeps of each adds up."""


TUNING = Tuning()
