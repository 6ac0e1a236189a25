"""Arguments that the analyses of periodic orbits have in common."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.analysis.arguments import real, whole
from chaosdrill.errors import SettingsError

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

LONGEST_PERIOD = 1000
"""Longest period of an orbit, in forcing periods: longer ones have too many unknowns to be solved together."""


def check_start(start: Any, known: Sequence[str]) -> None:
    """Refuse a start that is not known."""
    if not isinstance(start, str) or start not in known:
        raise SettingsError(f"start is {start!r}; expected one of {list(known)}")


def orbit_period(system: "HybridSystem", period: Any) -> int:
    """The period of an orbit in forcing periods, checked."""
    count = whole("period", period, 1, LONGEST_PERIOD)
    if system.period is None and count != 1:
        raise SettingsError(
            f"period is {period!r}, but {system.name} has no forcing period to count in; leave it out: "
            "an orbit is one round there, however many turns it takes"
        )
    system.forcing_period()
    return count


def settling(system: "HybridSystem", transient: Any) -> int:
    """Forcing periods to run before an orbit is looked for; without forcing units of time, rounded up."""
    if system.period is not None:
        return whole("transient", transient, 0)
    time = real(transient)
    if not 0 <= time < np.inf:
        raise SettingsError(f"transient is {transient!r}; it must be a finite time >= 0")
    return whole("transient", np.ceil(time), 0)
