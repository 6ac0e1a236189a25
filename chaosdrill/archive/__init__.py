"""Archives: NetCDF-4 files that are written whole or not at all, opened, described and verified."""

from chaosdrill.archive.cite import cite
from chaosdrill.archive.compare import Check, Difference, compare
from chaosdrill.archive.describe import info
from chaosdrill.archive.events import cut, join
from chaosdrill.archive.read import open_archive as open
from chaosdrill.archive.run import run
from chaosdrill.archive.verify import Verification, verify
from chaosdrill.archive.write import check_writable, save, writing

__all__ = [
    "Check",
    "Difference",
    "Verification",
    "check_writable",
    "cite",
    "compare",
    "cut",
    "info",
    "join",
    "open",
    "run",
    "save",
    "verify",
    "writing",
]
