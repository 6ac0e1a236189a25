"""How long runs are, and how much of them memory holds."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from chaosdrill.errors import SettingsError

if TYPE_CHECKING:
    from chaosdrill.engine.run import Run

SLICE = 2000
"""Periods of a transient between two moments at which an interruption is heard."""

SLICES = 64
"""Parts of a transient given as time."""

MOST_NUMBERS = 2_000_000_000
"""Doubles that a record may hold, 16 GB."""


@dataclass(frozen=True)
class Span:
    """How long to run: ``count`` units of length ``unit`` after a transient.

    The unit is the forcing period, or a part of ``duration`` for systems without one.
    """

    unit: float
    count: int
    transient: float  # units of a forced system, else a time
    periodic: bool  # whether the unit is a forcing period
    outcome: int = 0  # what ended the run that measures how long a number of section points takes; 0: nothing
    measured: bool = False  # whether it is as long as a number of section points takes
    message: str = ""  # what ended that run and where, as `Run.stopped` tells

    @property
    def length(self) -> float:
        """Time after the transient."""
        return self.unit * self.count

    def settle(self, run: "Run") -> Any:
        """Run the transient and start all averages; returns the outcome."""
        from chaosdrill.dataset import Outcome

        outcome = Outcome(self.outcome)
        if self.periodic:
            left = int(self.transient)
            while left and outcome == Outcome.OK:
                outcome, _ = run.advance(min(left, SLICE))
                left -= min(left, SLICE)
        elif self.transient > 0:
            run.change_period(self.transient / SLICES)
            for _ in range(SLICES):
                if outcome == Outcome.OK:
                    outcome, _ = run.advance(1)
            run.change_period(self.unit)
        run.forget()
        return outcome


def check_record(samples: int, columns: int, names: str) -> None:
    """Refuse a record that no memory holds, before it is reserved.

    ``samples``: rows of the record. ``columns``: numbers in a row. ``names``: the arguments that make the record
    shorter, as in ``"periods or samples"``.

    Raises `SettingsError` if the record would hold more than ``MOST_NUMBERS`` numbers.
    """
    if samples * columns > MOST_NUMBERS:
        raise SettingsError(
            f"the record would hold {samples} samples of {columns} numbers ({8e-9 * samples * columns:.3g} GB); "
            f"at most {MOST_NUMBERS} numbers fit: give fewer {names}"
        )
