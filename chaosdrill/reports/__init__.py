"""Reports: all that an archive tells, in one page that needs nothing else."""

from chaosdrill.reports.report import Report, report

__all__ = ["Report", "report"]
