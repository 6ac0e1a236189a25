"""Reports: the contents of an archive on one page that needs nothing else.

Each part gives the HTML of one dataset, or nothing if the dataset lacks its variables. A failure in a part is named on
the page and hides nothing else.
"""

from chaosdrill.reports.report import Report, report

__all__ = ["Report", "report"]
