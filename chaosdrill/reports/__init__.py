"""Reports: the contents of an archive on one page that needs nothing else.

Each part gives HTML of one dataset, or nothing where the dataset has none of it. What fails in a part is named on the
page and hides nothing else.
"""

from chaosdrill.reports.report import Report, report

__all__ = ["Report", "report"]
