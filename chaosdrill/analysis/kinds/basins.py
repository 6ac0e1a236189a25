"""Basins of attraction: which attractor each initial state of a grid leads to."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from chaosdrill.analysis.arguments import Axes
from chaosdrill.analysis.base import POINTS, Points, analysis
from chaosdrill.dataset.schema import (
    EXPONENT,
    PENETRATION,
    QUADRATURE,
    SI,
    STATES,
    SWEEP,
    axis,
    forcing,
    may,
    mean_rate,
    need,
    outcome,
    table,
)
from chaosdrill.errors import SettingsError
from chaosdrill.settings import setting

if TYPE_CHECKING:
    import xarray as xr

    from chaosdrill.analysis.base import Job
    from chaosdrill.model import HybridSystem

_TABLED = "attractor_number"

VARIABLES = table(
    axis(SWEEP, SWEEP, "f8", "initial state", "Values of the state from which the runs start.", True),
    *STATES,
    EXPONENT,
    axis("attractor_number", _TABLED, "i4", "number of the attractor", "Place in the table, from 1.", True),
    need("attractor", SWEEP, "i2", "attractor", "Number of the attractor that a start leads to; 0: none."),
    outcome(SWEEP),
    need("attractor_period", _TABLED, "i2", "period of the attractor", "In iterates of the section, or 0."),
    outcome(_TABLED, "attractor_outcome", "kind of the attractor"),
    may("attractor_exponent", f"{_TABLED} exponent", "f8", "Lyapunov exponent", "Per unit of model time."),
    may("attractor_error", f"{_TABLED} exponent", "f8", "standard error of the exponent", "From blocks."),
    *mean_rate(PENETRATION, _TABLED, "attractor"),
    *mean_rate(QUADRATURE, _TABLED, "attractor"),
    may("attractor_rate_si", _TABLED, "f8", "mean progression rate", SI, "m h-1"),
    need("attractor_state", f"{_TABLED} state", "f8", "state on the attractor", "A point of it on the section."),
    need("fraction", _TABLED, "f8", "fraction of the basin", "Part of the starts that lead to the attractor."),
    need("fraction_error", _TABLED, "f8", "standard error of the fraction", "sqrt(p(1 - p)/N) for N starts."),
    *forcing(),
    bars={"attractor_exponent": "attractor_error", "fraction": "fraction_error"},
    average=("attractor_rate_si",),
    sampled=("attractor_state",),
)


@dataclass(frozen=True, kw_only=True)
class Basins(Points):
    """Settings of `basins`."""

    grid: dict[str, Any] = setting(Axes("state", 2, 2, "basins are drawn over two states"), positional=True)

    def agree(self, system: "HybridSystem") -> None:
        """Refuse a state that the initial mode holds at one value."""
        super().agree(system)
        from chaosdrill.model.derive import pinned_states

        mode = str(system.initial["mode"])
        held = [system.state_names[i] for i in pinned_states(system, mode)]
        for name in self.grid:
            if name in held:
                raise SettingsError(
                    f"grid names {name!r}, which mode {mode!r}, the initial one, leaves no freedom; give another "
                    f"state, or another initial mode: {list(system.modes)}"
                )


@analysis(
    "basins",
    Basins,
    "which attractor each initial state of a grid leads to, and the part that does",
    VARIABLES,
    cites=POINTS,
)
def basins(system: "HybridSystem", given: Basins, job: "Job") -> "xr.Dataset":
    """Attractors reached from a grid of initial states, and the part of the grid that leads to each.

    Two runs are on one attractor if their kind and period are the same and their section points have the same moments:
    cycles within 2e-5 of their size, whatever the phase at which they are found; attractors that are no cycles within a
    fifth of their extent, with leading exponents that agree within eight standard errors; points at rest as cycles,
    since Newton's method gives them to the last digit. Attractors are numbered by the size of their basins. The
    fractions are those of the cells: their standard error sqrt(p (1 - p) / N) is that of N states drawn at random from
    the box.

    Parameters
    ----------
    system : HybridSystem
        System with its parameters; its initial state gives the mode, and the states that the grid does not span.
    grid : mapping of two states to values
        ``{"y": np.linspace(-1, 1, 400), "w": np.linspace(0, 1, 300)}``.
    periods, duration, transient : int or float
        As in `parameter_chart`; no section is kept.
    at, max_return, exponents, max_period, patience, workers, scheduler, store : optional
        As in `bifurcation_diagram`.
    method, tolerance, steps, max_events, max_stalls, progress : optional
        As in `trajectory`; ``progress`` gets the outcomes counted so far.

    Returns
    -------
    xarray.Dataset
        Over both states ``attractor`` (its number, 0 for none) and ``outcome``; over ``attractor_number``:
        ``attractor_period``, ``attractor_outcome``, ``attractor_exponent`` and ``attractor_error`` (exponent),
        ``attractor_rate`` of the penetration, ``attractor_work_rate`` of a quadrature ``work``, and their errors;
        ``attractor_state`` (state), ``fraction`` and ``fraction_error``.

    Raises
    ------
    SettingsError
        An argument that cannot be used, or a ``store`` that holds chunks of another call.
    ArchiveError
        If the ``store`` cannot be written, or another call uses it.
    ChaosdrillError
        If the scheduler cannot be reached or is lost, or if its workers have other versions.
    """
    from chaosdrill.analysis.sweeps import over_states

    return over_states(system, given, job)
