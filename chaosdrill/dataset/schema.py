"""One table of every variable that an analysis may put out.

Attributes, checks, documentation and tests all follow from ``SCHEMA``: kind of analysis -> name -> ``Variable``.

Three things depend on the system at hand and stand in the table as placeholders: ``SWEEP`` (each swept parameter, or
each state that spans a grid of initial states, as a dimension and as its coordinate), ``QUADRATURE`` (each integral
that the system carries along), and the states (as the dimension ``state`` with the coordinate ``state_name``, since a
variable ``state`` with more dimensions exists too).
"""

from dataclasses import dataclass

SWEEP = "{sweep}"
QUADRATURE = "{quadrature}"


@dataclass(frozen=True)
class Variable:
    """Declaration of one variable.

    Parameters
    ----------
    name : str
        Name in the dataset, or ``SWEEP`` / ``QUADRATURE`` for one that the system or the sweep names.
    dims : tuple of str
        Dimensions in order; ``SWEEP`` stands for all swept parameters, or states of a grid, in order.
    dtype : str
        NumPy code that is stored; ``"str"`` for text.
    units : str
        UDUNITS text; ``"1"`` for dimensionless, which model time is too.
    long_name, doc : str
        Name for axes, and one sentence of explanation (stored as the attribute ``comment``).
    flags : {"", "outcome", "mode", "transition"}
        Whose names the codes stand for.
    coordinate : bool
        Whether it is stored as a coordinate.
    required : bool
        Whether every dataset of the kind has it.
    clocked : bool
        Whether a clock measured it, so that a second run gives other values and no comparison can ask for the same.
    """

    name: str
    dims: tuple[str, ...]
    dtype: str
    units: str
    long_name: str
    doc: str
    flags: str = ""
    coordinate: bool = False
    required: bool = False
    clocked: bool = False


def _need(name: str, dims: str, dtype: str, long_name: str, doc: str, units: str = "1", flags: str = "") -> Variable:
    return Variable(name, tuple(dims.split()), dtype, units, long_name, doc, flags, required=True)


def _may(name: str, dims: str, dtype: str, long_name: str, doc: str, units: str = "1", flags: str = "") -> Variable:
    return Variable(name, tuple(dims.split()), dtype, units, long_name, doc, flags)


def _axis(name: str, dims: str, dtype: str, long_name: str, doc: str, required: bool = False) -> Variable:
    return Variable(name, tuple(dims.split()), dtype, "1", long_name, doc, coordinate=True, required=required)


def _clocked(name: str, dims: str, long_name: str, doc: str) -> Variable:
    return Variable(name, tuple(dims.split()), "f8", "s", long_name, doc, required=True, clocked=True)


_STATE = _axis("state_name", "state", "str", "name of the state", "Label of each entry of the dimension state.", True)
_STATE_LABEL = _axis("state_long_name", "state", "str", "long name of the state", "What each state is, for people.")
_EXPONENT = _axis("exponent", "exponent", "i4", "index of the exponent", "Exponents are in descending order, from 1.")
_ITERATE = _axis("iterate", "iterate", "i4", "index of the iterate", "Number of the crossing of the section, from 0.")
_SEED = _axis("seed", "seed", "i4", "index of the seed", "Number of the initial state that the point started from.")
_SEED_NAME = _axis("seed_name", "seed", "str", "name of the seed", "How it starts: fixed, random, forward, backward.")
_SPECTRA = f"{SWEEP} seed exponent"
_CELL = "method tolerance"
_TABLED = "attractor_number"
_FORCING = _may("forcing_period", "", "f8", "forcing period", "Period of the forcing, in units of model time.")
_OUTCOME = ("How the run ended; what each code means is in flag_meanings.", "1", "outcome")
_GRAZING = "Smallest over all events; tangents grow without bound as it goes to zero. Infinite without events."

_RATES = (
    ("progression_rate", "mean progression rate", "Penetration per unit of model time, averaged over the run."),
    ("progression_error", "standard error of the progression rate", "From blocks of several lengths."),
    ("events_per_period", "events per forcing period", "All state-changing events, averaged over the run."),
    ("impacts_per_period", "impacts per forcing period", "Events of the class impact, averaged over the run."),
    ("slips_per_period", "slip onsets per forcing period", "Events of the class slip, averaged over the run."),
    ("events_per_time", "events per unit of time", "For systems without a forcing period."),
    ("impacts_per_time", "impacts per unit of time", "For systems without a forcing period."),
    ("slips_per_time", "slip onsets per unit of time", "For systems without a forcing period."),
)


def _rates(dims: str) -> tuple[Variable, ...]:
    """The mean rates, one number a run, and the progression rate in SI units for scenes given in SI."""
    si = _may("progression_rate_si", dims, "f8", "mean progression rate", "For scenes given in SI units.", "m h-1")
    return (*(_may(name, dims, "f8", long_name, doc) for name, long_name, doc in _RATES), si)


_TABLE: dict[str, tuple[Variable, ...]] = {
    "trajectory": (
        _axis("time", "time", "f8", "model time", "Dimensionless time of each sample.", True),
        _STATE,
        _STATE_LABEL,
        _need("state", "time state", "f8", "state", "States of the hybrid system at the sample times."),
        _need("mode", "time", "i1", "mode", "Mode that holds at the sample time.", flags="mode"),
        _may(QUADRATURE, "time", "f8", "quadrature", "Integral along the flow from the start of the record."),
        _need("event_time", "event", "f8", "time of the event", "Times do not decrease; equal times are ties."),
        _need("event_kind", "event", "i1", "transition taken", "Which transition it was.", flags="transition"),
        _need("event_speed", "event", "f8", "normal speed", "Rate of the guard at the crossing; small means grazing."),
        _may("event_mode_before", "event", "i1", "mode before the event", "Mode left.", flags="mode"),
        _may("event_mode_after", "event", "i1", "mode after the event", "Mode entered.", flags="mode"),
        _need("event_state_before", "event state", "f8", "state before the event", "Projected onto the guard."),
        _need("event_state_after", "event state", "f8", "state after the event", "After the reset."),
        _need("outcome", "", "i1", "outcome", *_OUTCOME),
        _FORCING,
    ),
    "poincare-section": (
        _STATE,
        _STATE_LABEL,
        _ITERATE,
        _need("section", "iterate state", "f8", "state on the section", "At the strobe: at forcing phase zero."),
        _axis("time", "iterate", "f8", "model time of the crossing", "Dimensionless; counted from the start.", True),
        _may("phase", "iterate", "f8", "forcing phase of the crossing", "In parts of a forcing period, 0 to 1."),
        _may("mode", "iterate", "i1", "mode on the section", "Mode that holds at the crossing.", flags="mode"),
        _may(QUADRATURE, "iterate", "f8", "quadrature", "Integral along the flow from the start of the record."),
        _may("period", "", "i4", "period found", "In iterates of the section; 0 when none was found."),
        _axis("multiplier", "multiplier", "i4", "index of the multiplier", "In descending order of modulus, from 1."),
        _may("multiplier_real", "multiplier", "f8", "multiplier, real part", "Eigenvalues of the cycle's tangent map."),
        _may("multiplier_imag", "multiplier", "f8", "multiplier, imaginary part", "NaN when no period was found."),
        *_rates(""),
        _may("closest_grazing", "", "f8", "smallest normal speed", _GRAZING),
        _need("outcome", "", "i1", "outcome", *_OUTCOME),
        _FORCING,
    ),
    "lyapunov-spectrum": (
        _EXPONENT,
        _need("lyapunov_exponent", "exponent", "f8", "Lyapunov exponent", "Per unit of model time; -inf is rank loss."),
        _need("lyapunov_error", "exponent", "f8", "standard error of the exponent", "From blocks of several lengths."),
        _need("lyapunov_history", "block exponent", "f8", "running mean of the exponents", "Up to the block's end."),
        _axis("block_time", "block", "f8", "model time at the block's end", "Counted from the end of the transient."),
        _need("kaplan_yorke_dimension", "", "f8", "Kaplan-Yorke dimension", "From the exponents; holds with -inf too."),
        *_rates(""),
        _axis("transition_name", "transition", "str", "name of the transition", "Label of the dimension transition."),
        _may("event_count", "transition", "i8", "number of events", "How often each transition was taken."),
        _may("tie_count", "", "i8", "number of ties", "Events that fell on the same instant as the one before."),
        _need("closest_grazing", "", "f8", "smallest normal speed", _GRAZING),
        _may("rank", "", "i4", "live tangents", "Rank of the tangent map's product: the number of finite exponents."),
        _need("outcome", "", "i1", "outcome", *_OUTCOME),
        _FORCING,
    ),
    "bifurcation-diagram": (
        _axis(SWEEP, SWEEP, "f8", "swept parameter", "Values that the sweep ran through.", True),
        _STATE,
        _STATE_LABEL,
        _SEED,
        _SEED_NAME,
        _ITERATE,
        _EXPONENT,
        _need("section", f"{SWEEP} seed iterate state", "f8", "state on the section", "NaN where there is no result."),
        _need("period", f"{SWEEP} seed", "i2", "period found", "In iterates of the section; 0 when none was found."),
        _may("lyapunov_exponent", _SPECTRA, "f8", "Lyapunov exponent", "Per unit of model time; -inf is rank loss."),
        _may("lyapunov_error", _SPECTRA, "f8", "standard error of the exponent", "From blocks of several lengths."),
        *_rates(f"{SWEEP} seed"),
        _may("closest_grazing", f"{SWEEP} seed", "f8", "smallest normal speed", _GRAZING),
        _need("outcome", f"{SWEEP} seed", "i1", "outcome", *_OUTCOME),
        _may("initial_state", "seed state", "f8", "initial state", "State from which each seed starts."),
        _may("forcing_period", SWEEP, "f8", "forcing period", "Period of the forcing at each point of the sweep."),
    ),
    "parameter-chart": (
        _axis(SWEEP, SWEEP, "f8", "swept parameter", "Values that the sweep ran through.", True),
        _STATE,
        _STATE_LABEL,
        _SEED,
        _SEED_NAME,
        _EXPONENT,
        _need("period", f"{SWEEP} seed", "i2", "period found", "In iterates of the section; 0 when none was found."),
        _may("lyapunov_exponent", _SPECTRA, "f8", "Lyapunov exponent", "Per unit of model time; -inf is rank loss."),
        _may("lyapunov_error", _SPECTRA, "f8", "standard error of the exponent", "From blocks of several lengths."),
        *_rates(f"{SWEEP} seed"),
        _may("closest_grazing", f"{SWEEP} seed", "f8", "smallest normal speed", _GRAZING),
        _need("attractor_count", SWEEP, "i2", "number of attractors", "Different ones among the seeds; 0: none found."),
        _need("outcome", f"{SWEEP} seed", "i1", "outcome", *_OUTCOME),
        _may("initial_state", "seed state", "f8", "initial state", "State from which each seed starts."),
        _may("forcing_period", SWEEP, "f8", "forcing period", "Period of the forcing at each point of the chart."),
    ),
    "basins": (
        _axis(SWEEP, SWEEP, "f8", "initial state", "Values of the state from which the runs start.", True),
        _STATE,
        _STATE_LABEL,
        _EXPONENT,
        _axis("attractor_number", _TABLED, "i4", "number of the attractor", "Place in the table, from 1.", True),
        _need("attractor", SWEEP, "i2", "attractor", "Number of the attractor that a start leads to; 0: none."),
        _need("outcome", SWEEP, "i1", "outcome", *_OUTCOME),
        _need("attractor_period", _TABLED, "i2", "period of the attractor", "In iterates of the section, or 0."),
        _need("attractor_outcome", _TABLED, "i1", "kind of the attractor", *_OUTCOME),
        _may("attractor_exponent", f"{_TABLED} exponent", "f8", "Lyapunov exponent", "Per unit of model time."),
        _may("attractor_error", f"{_TABLED} exponent", "f8", "standard error of the exponent", "From blocks."),
        _may("attractor_rate", _TABLED, "f8", "mean progression rate", "Penetration per unit of model time."),
        _need("attractor_state", f"{_TABLED} state", "f8", "state on the attractor", "A point of it on the section."),
        _need("fraction", _TABLED, "f8", "fraction of the basin", "Part of the starts that lead to the attractor."),
        _need("fraction_error", _TABLED, "f8", "standard error of the fraction", "sqrt(p(1 - p)/N) for N starts."),
        _FORCING,
    ),
    "work-precision": (
        _axis("quantity", "quantity", "str", "quantity", "What the error is an error of.", True),
        _axis("method", "method", "str", "method", "Numerical method.", True),
        _axis("tolerance", "tolerance", "f8", "tolerance", "Asked of the method; see steps_per_period too.", True),
        _STATE,
        _STATE_LABEL,
        _need("error", f"quantity {_CELL}", "f8", "error", "NaN if not measured, infinite if events differ."),
        _need("reference_error", "quantity", "f8", "error of the reference", "What two computations of it differ by."),
        _clocked("wall_time", _CELL, "time a period", "Median over the runs; a unit of time if not forced."),
        _clocked("wall_time_spread", _CELL, "spread of the time a period", "Distance of the quartiles of the runs."),
        _need("steps", _CELL, "f8", "steps a period", "Mean; events end steps. A unit of time if not forced."),
        _need("evaluations", _CELL, "f8", "evaluations a period", "Of the right-hand side; a jet counts as its order."),
        _need(
            "steps_per_period", _CELL, "i4", "fixed steps a period", "Or a part of duration; 0: chosen by the method."
        ),
        _need("exponent_error_spread", _CELL, "f8", "standard error of the exponent's error", "Over the restarts."),
        _need("horizon", _CELL, "f8", "trusted time", "Until a chaotic trajectory is 1e-6 off; infinite if it stays."),
        _need("horizon_expected", "tolerance", "f8", "expected trusted time", "ln(1e-6/tolerance)/exponent, in chaos."),
        _need("outcome", _CELL, "i1", "outcome", *_OUTCOME),
        _need("period", "", "i4", "period of the cycle", "In forcing periods; 0 off a cycle."),
        _need("lyapunov_exponent", "", "f8", "leading Lyapunov exponent", "Of the surveyed stretch of the attractor."),
        _need("lyapunov_error", "", "f8", "standard error of the exponent", "Statistical; from blocks, not numerics."),
        _need("start", "state", "f8", "start", "State from which all methods start, at the strobe."),
        _FORCING,
    ),
}

SCHEMA: dict[str, dict[str, Variable]] = {kind: {v.name: v for v in table} for kind, table in _TABLE.items()}
