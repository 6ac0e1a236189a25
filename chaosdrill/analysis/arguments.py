"""What the analyses have in common before they start: their arguments are checked and become counts of periods."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.errors import SettingsError
from chaosdrill.typed import FUNCTION, PATH, refuse

if TYPE_CHECKING:
    from chaosdrill.engine.run import Run
    from chaosdrill.model import HybridSystem

Progress = Callable[[int, int, dict[str, int] | None], None]
"""Called with (done, total, outcomes so far)."""


SLICE = 2000
"""Periods of a transient between two moments at which an interruption is heard."""

SLICES = 64
"""Parts of a transient given as time."""

LARGEST = 2**53
"""Largest count: the integers up to here are exact as doubles."""

_UNRELATED = {"system", "progress", "workers", "scheduler", "store"}

MOST_NUMBERS = 2_000_000_000
"""Doubles that a record may hold, 16 GB."""


@dataclass(frozen=True)
class Span:
    """How long to run: ``count`` units of length ``unit`` after a transient.

    The unit is the forcing period, or a part of ``duration`` for systems without one.
    """

    unit: float
    count: int
    transient: float
    periodic: bool

    @property
    def length(self) -> float:
        """Time after the transient."""
        return self.unit * self.count

    def settle(self, run: "Run") -> Any:
        """Run the transient and start all averages; returns the outcome."""
        from chaosdrill.dataset import Outcome

        outcome = Outcome.OK
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


def span(system: "HybridSystem", periods: Any, duration: Any, transient: Any, *, units: int = 1) -> Span:
    """Check periods or duration and transient of an analysis; ``units`` parts make a duration."""
    period = system.forcing_period()
    if (periods is None) == (duration is None):
        wanted = "periods" if period is not None else "duration"
        raise SettingsError(
            f"{system.name}: give {wanted}= and only that (received periods={periods!r}, {duration=!r})"
        )
    if period is None and periods is not None:
        raise SettingsError(
            f"{system.name} has no forcing period: give duration= in units of time, not periods={periods!r}"
        )
    if period is not None and duration is not None:
        about = real(duration) / period
        hint = f" (about {max(1, round(about))})" if 0 < about < np.inf else ""
        raise SettingsError(
            f"{system.name} has the forcing period {period:.6g}: give periods=, not {duration=!r}{hint}"
        )
    if period is not None:
        count = whole("periods", periods, 1)
        return Span(period, count, whole("transient", transient, 0), True)
    length, settle = positive("duration", duration), real(transient)
    if not 0 <= settle < np.inf:
        raise SettingsError(f"transient is {transient!r}; it must be a finite time >= 0")
    return Span(length / units, units, settle, False)


def whole(name: str, value: Any, least: int, most: int = LARGEST) -> int:
    """An integer from ``least`` to ``most``, or an error that names the argument."""
    number = real(value)
    if number != np.floor(number) or not least <= number < np.inf:
        raise SettingsError(f"{name} is {value!r}; it must be an integer >= {least}")
    if number > most:
        raise SettingsError(f"{name} is {value!r}; it must be an integer from {least} to {most}")
    return int(value)


def positive(name: str, value: Any) -> float:
    """A finite number above 0, or an error that names the argument."""
    number = real(value)
    if not 0 < number < np.inf:
        raise SettingsError(f"{name} is {value!r}; it must be a finite number > 0")
    return number


def real(value: Any) -> float:
    """The value as a float; NaN for what is no real number, texts and truth values among it."""
    if isinstance(value, (str, bytes, bool, np.bool_)) or (isinstance(value, np.ndarray) and value.ndim):
        return float("nan")
    try:
        return float(value)
    except OverflowError:
        return float("inf")
    except (TypeError, ValueError):
        return float("nan")


def check_record(samples: int, columns: int, names: str) -> None:
    """Refuse a record that no memory holds, before it is reserved.

    Parameters
    ----------
    samples : int
        Rows of the record.
    columns : int
        Numbers in a row.
    names : str
        The arguments that make the record shorter, as in ``"periods or samples"``.

    Raises
    ------
    SettingsError
        If the record would hold more than ``MOST_NUMBERS`` numbers.
    """
    if samples * columns > MOST_NUMBERS:
        raise SettingsError(
            f"the record would hold {samples} samples of {columns} numbers ({8e-9 * samples * columns:.3g} GB); "
            f"at most {MOST_NUMBERS} numbers fit: give fewer {names}"
        )


def tangent_count(system: "HybridSystem", exponents: Any) -> int:
    """Number of exponents asked for; all by default."""
    n = len(system.states)
    count = n if exponents is None else whole("exponents", exponents, 0)
    if count > n:
        raise SettingsError(f"exponents is {exponents!r}; {system.name} has {n} states, so at most {n}")
    return count


def section_transitions(system: "HybridSystem", at: str) -> set[int] | None:
    """Indices of the transitions at which the section is taken; None for the strobe."""
    if isinstance(at, str) and at == "strobe":
        if system.period is None:
            names = sorted({t.name for t in system.transitions})
            raise SettingsError(f"at is 'strobe', but {system.name} has no forcing period; choose an event: {names}")
        return None
    found = {i for i, t in enumerate(system.transitions) if isinstance(at, str) and at in (t.name, t.kind)}
    if not found:
        names = sorted({t.name for t in system.transitions} | {str(t.kind) for t in system.transitions})
        raise SettingsError(f"at is {at!r}; expected 'strobe' or an event of {system.name}: {names}")
    return found


def no_forcing(system: "HybridSystem") -> str:
    """What to do about a system without forcing where lengths are counted in forcing periods."""
    events = sorted({t.name for t in system.transitions})
    section = f"at={events[0]!r}" if events else "at= a transition that marks a section, of which it has none yet"
    return (
        f"define it with a period, any time such as that of one turn, and give {section} (lengths are counted in that "
        "time, exponents are per unit of time as ever), or take a trajectory, a section at events, a spectrum, an "
        "orbit or a branch, which need none"
    )


def settings(values: dict[str, Any]) -> dict[str, Any]:
    """Arguments as provenance keeps them, without what does not change the numbers.

    Every analysis begins with this, so that it is here that what is no system is refused, and what cannot be called or
    name a folder.

    Raises
    ------
    SettingsError
        If ``values["system"]`` is no system, ``"progress"`` no function, or ``"store"`` no name.
    """
    from chaosdrill.model import HybridSystem

    system = values["system"]
    if not isinstance(system, HybridSystem):
        named = f"chaosdrill.build({system!r:.60})" if isinstance(system, str) else "chaosdrill.drill()"
        raise SettingsError(
            f"system is {system!r:.60}; it must be a HybridSystem: your own, the system of a scene, as in "
            f"load_scene(path).system, or one that has a name, as in {named}"
        )
    for name, kind in (("progress", FUNCTION), ("store", PATH)):
        if values.get(name) is not None:
            refuse(SettingsError, name, values[name], kind)
    return {key: value for key, value in values.items() if key not in _UNRELATED}
