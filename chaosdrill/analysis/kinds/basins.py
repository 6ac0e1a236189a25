"""Basins of attraction: the attractor of each initial state of a grid."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from chaosdrill.analysis.arguments import Axes
from chaosdrill.analysis.base import POINTS, Dataset, HybridSystem, Job, Points, analysis
from chaosdrill.analysis.starts import STARTS
from chaosdrill.dataset.schema import (
    EXPONENT,
    INITIAL_STATE,
    RUN,
    RUN_NUMBER,
    STARTS_OF_RUNS,
    STATES,
    SWEEP,
    axis,
    forcing,
    may,
    need,
    of_attractors,
    outcome,
    rates_of_attractors,
    table,
)
from chaosdrill.settings import Faults, setting

_TABLED = "attractor_number"

VARIABLES = table(
    axis(SWEEP, SWEEP, "f8", "initial state", "Values of the state from which the runs start.", True),
    RUN_NUMBER,
    *STATES,
    INITIAL_STATE,
    may("initial_mode", RUN, "i1", "initial mode", "Mode in which a run starts.", flags="mode"),
    EXPONENT,
    axis("attractor_number", _TABLED, "i4", "number of the attractor", "Place in the table, from 1.", True),
    need("attractor", STARTS_OF_RUNS, "i2", "attractor", "Number of the attractor that a start leads to; 0: none."),
    outcome(STARTS_OF_RUNS),
    *of_attractors(_TABLED),
    *rates_of_attractors(_TABLED),
    *forcing(),
    bars={"attractor_exponent": "attractor_error"},
    average=("attractor_rate_si",),
    sampled=("attractor_state",),
)


@dataclass(frozen=True, kw_only=True)
class Basins(Points):
    """Settings of `basins`."""

    without_noise: ClassVar[str] = ""
    meanings: ClassVar[Mapping[str, str]] = {
        "system": "System with its parameters; its initial state gives the states that the grid does not span, "
        "and the mode unless regions do."
    }

    grid: dict[str, Any] | None = setting(
        Axes("state", 2, 2, "basins are drawn over two states; attractors follows random starts in any number of them"),
        None,
        positional=True,
        doc='``{"y": np.linspace(-1, 1, 400), "w": np.linspace(0, 1, 300)}``.',
    )
    initial: Any = setting(
        STARTS,
        None,
        doc="Initial states in any number of dimensions: an array (run, state) or a list of rows, in the order "
        "of the states; a list of mappings; columns by name, in a mapping, a `pandas.DataFrame` or an "
        "`xarray.Dataset`; or an `xarray.DataArray` with a dimension ``state``. By name ``mode`` can also be "
        "given, and omitted states are the system's own. With a grid the list follows its cells, whose last "
        "state varies fastest.",
    )

    @classmethod
    def beside(cls, table: Mapping[str, Any]) -> Faults:
        """Initial states in one way at least; and the lengths."""
        yield from super().beside(table)
        if not {"grid", "initial"} & table.keys():
            yield ("grid",), "missing; give two states with their values, or a list of initial states (initial)"

    @classmethod
    def misfits(cls, table: Mapping[str, Any], system: HybridSystem) -> Faults:
        """As for every run, plus a state that the initial mode keeps constant."""
        from chaosdrill.engine.setup import constrained_states

        yield from super().misfits(table, system)
        if not system.names_mode:
            return
        mode = str(system.initial["mode"])
        pinned = constrained_states(system)[system.mode_names.index(mode)]
        held = [name for name, one in zip(system.state_names, pinned, strict=True) if one]
        for name in table.get("grid", {}).keys() & set(held):
            words = f"mode {mode!r}, the initial one, leaves it no freedom; give another state, or another initial mode"
            yield ("grid", name), f"{words}: {list(system.modes)}"


@analysis(
    "basins",
    Basins,
    "which attractor each initial state of a grid or a list leads to, and the part that does",
    VARIABLES,
    cites=POINTS,
)
def basins(system: HybridSystem, given: Basins, job: Job) -> Dataset:
    """Attractors reached from a grid or a list of initial states, and the share of these that leads to each.

    Two runs are assigned to the same attractor if their kind and period agree and their section points have the same
    moments: for cycles within 2e-5 of their size, at any phase; for other attractors within a fifth of their extent,
    with leading exponents that agree within eight standard errors. Equilibria are compared like cycles, since Newton's
    method refines them to rounding error. Attractors are numbered by the size of their basins. The fractions are those
    of the starts; their standard error sqrt(p (1 - p) / N) is that of N states drawn at random, from the box of a grid.

    Returns
    -------
    xarray.Dataset
        Over both states of the grid, or over ``run`` with ``initial``, ``attractor`` (its number, 0 for none) and
        ``outcome``, in the latter case with ``initial_state`` (run, state) and ``initial_mode``; over
        ``attractor_number``: ``attractor_period``, ``attractor_outcome``, ``attractor_exponent`` and
        ``attractor_error`` (exponent), ``attractor_rate`` of the penetration, ``attractor_work_rate`` of a quadrature
        ``work``, with their errors, ``attractor_state`` (state), ``fraction`` and ``fraction_error``.
    """
    from chaosdrill.analysis.grids.sweeps import over_states

    return over_states(system, given, job)
