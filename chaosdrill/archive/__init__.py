"""Archives: NetCDF-4 files that are written whole or not at all, opened, described and verified."""

from chaosdrill.archive.compare import Difference, compare
from chaosdrill.archive.describe import info
from chaosdrill.archive.read import open_archive as open
from chaosdrill.archive.run import run
from chaosdrill.archive.verify import Verification, verify
from chaosdrill.archive.write import check_writable, save

__all__ = ["Difference", "Verification", "check_writable", "compare", "info", "open", "run", "save", "verify"]
