"""Archives: NetCDF-4 files that are written whole or not at all, opened, checked, cut and joined.

A file format contains no analysis: running, verifying and comparing are in `chaosdrill.workflow`.
"""

from chaosdrill.archive.events import cut, join
from chaosdrill.archive.read import open_archive as open
from chaosdrill.archive.write import check_writable, save, writing

__all__ = ["check_writable", "cut", "join", "open", "save", "writing"]
