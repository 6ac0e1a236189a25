"""States on a Poincare section, the period found there, and the multipliers of the cycle."""

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from chaosdrill.analysis.arguments import Span
from chaosdrill.analysis.base import Job
from chaosdrill.analysis.recording import record
from chaosdrill.analysis.recurrence import CLOSE, find_period, sizes
from chaosdrill.dataset import Outcome
from chaosdrill.engine import layout
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run, event_rates, rate_names
from chaosdrill.engine.structure import examine

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem


def section(system: "HybridSystem", plan: Span, chosen: set[int] | None, max_period: int, job: Job) -> xr.Dataset:
    """States at every strobe, or before every event of the ``chosen`` transitions; see `poincare_section`."""
    numerics = job.numerics
    run = Run(system, plan.unit, numerics)
    outcome = plan.settle(run)
    first, count = run.strobes, plan.count if outcome == Outcome.OK else 0
    found = record(run, count, events=chosen is not None, report=job.report(plan.count))
    outcome = found.outcome if outcome == Outcome.OK else outcome
    if chosen is None:
        points, modes = found.samples[:, :-1], found.samples[:, -1]
        times = (first + 1 + np.arange(len(points))) * run.period
    else:
        crossings = found.of(chosen)
        points, modes, times = crossings.states_before(), crossings.events[:, layout.EVENT_MODE], crossings.times
    n = len(system.states)
    period = find_period(points[:, :n], max_period)
    multipliers = np.full(n, complex(np.nan, np.nan))
    if period and chosen is None and outcome == Outcome.OK:
        multipliers = cycle_multipliers(system, run, period, numerics)
    rates = event_rates(run) if outcome == Outcome.OK else dict.fromkeys(rate_names(system), np.nan)
    if period and outcome == Outcome.OK:
        length = period * run.period if chosen is None else float(times[-1] - times[-1 - period])
        rates |= cycle_rates(system, run, length, numerics, sizes(points[np.newaxis, -period:, :n])[0])
    variables = {
        "section": (("iterate", "state"), points[:, :n]),
        "mode": ("iterate", modes.astype(np.int8)),
        "period": ((), np.int32(period)),
        "multiplier_real": ("multiplier", multipliers.real),
        "multiplier_imag": ("multiplier", multipliers.imag),
        "outcome": ((), np.int8(Outcome.PERIODIC if period and outcome == Outcome.OK else outcome)),
        **{name: ((), value) for name, value in rates.items()},
    }
    if chosen is None:
        variables |= {name: ("iterate", points[:, n + i]) for i, name in enumerate(system.quadratures)}
    if plan.periodic:
        variables["forcing_period"] = ((), plan.unit)
    coords = {
        "iterate": np.arange(len(points), dtype=np.int32),
        "time": ("iterate", times),
        "state": list(system.state_names),
        "multiplier": np.arange(1, n + 1, dtype=np.int32),
    }
    return xr.Dataset(variables, coords=coords)


def cycle_rates(
    system: "HybridSystem", run: Run, length: float, numerics: Numerics, size: np.ndarray
) -> dict[str, float]:
    """Mean rates over one cycle from the present strobe of a run; none if it does not come back.

    Parameters
    ----------
    system : HybridSystem
    run : Run
    length : float
        Duration of the cycle, of a forced system a number of its periods but for round-off.
    numerics : Numerics
    size : ndarray, shape (n,)
        What distances between states are relative to.
    """
    periods = max(1, round(length / run.period))
    forced = system.time is not None or abs(length - periods * run.period) <= CLOSE * run.period
    cycle = Run(system, run.period if forced else length, numerics)
    cycle.continue_from(run)
    outcome, _ = cycle.advance(periods if forced else 1)
    if outcome != Outcome.OK or cycle.mode != run.mode or (np.abs(cycle.x - run.x) > CLOSE * size).any():
        return {}
    part = run.period / cycle.period if system.period is not None else 1.0
    rates = event_rates(cycle)
    rates = {name: value * (part if name.endswith("_per_period") else 1.0) for name, value in rates.items()}
    return {name: value for name, value in rates.items() if name != "closest_grazing"}


def cycle_multipliers(system: "HybridSystem", run: Run, period: int, numerics: Numerics) -> np.ndarray:
    """Eigenvalues of the tangent map over a cycle that starts at the present strobe of a run, by descending modulus."""
    n = len(system.states)
    deficient = examine(system).deficient
    whole_map = Run(system, run.period, numerics, tangents=np.eye(n), orthonormalise=False)
    ranked = Run(system, run.period, numerics, tangents=np.eye(n), deficient=deficient)
    whole_map.continue_from(run)
    ranked.continue_from(run)
    if whole_map.advance(period)[0] != Outcome.OK or ranked.advance(period)[0] != Outcome.OK:
        return np.full(n, complex(np.nan, np.nan))
    values = np.linalg.eigvals(whole_map.vectors.T).astype(complex)
    values = values[np.argsort(-np.abs(values), kind="stable")]
    values[ranked.live :] = 0
    return values
