"""Output variables, outcomes and provenance."""

from chaosdrill.dataset.branches import BranchEnd, Special
from chaosdrill.dataset.label import describe, described_again, label
from chaosdrill.dataset.outcomes import Outcome, count_outcomes
from chaosdrill.dataset.provenance import provenance
from chaosdrill.dataset.schema import SCHEMA

__all__ = [
    "SCHEMA",
    "BranchEnd",
    "Outcome",
    "Special",
    "count_outcomes",
    "describe",
    "described_again",
    "label",
    "provenance",
]
