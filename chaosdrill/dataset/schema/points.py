"""Variables of many points: `bifurcation-diagram`, `parameter-chart`, `basins`."""

from chaosdrill.dataset.schema.shared import (
    EXPONENT,
    FORCING,
    FORCING_SI,
    GRAZING,
    ITERATE,
    OUTCOME,
    SEED,
    SEED_NAME,
    SI,
    STATE,
    STATE_LABEL,
    rates,
)
from chaosdrill.dataset.schema.variable import SWEEP, Table, axis, may, need

_SPECTRA = f"{SWEEP} seed exponent"
_TABLED = "attractor_number"

BIFURCATION_DIAGRAM: Table = (
    axis(SWEEP, SWEEP, "f8", "swept parameter", "Values that the sweep ran through.", True),
    STATE,
    STATE_LABEL,
    SEED,
    SEED_NAME,
    ITERATE,
    EXPONENT,
    need("section", f"{SWEEP} seed iterate state", "f8", "state on the section", "NaN where there is no result."),
    need("period", f"{SWEEP} seed", "i2", "period found", "In iterates of the section; 0 when none was found."),
    may("lyapunov_exponent", _SPECTRA, "f8", "Lyapunov exponent", "Per unit of model time; -inf is rank loss."),
    may("lyapunov_error", _SPECTRA, "f8", "standard error of the exponent", "Twice it covers the truth in 95 %."),
    *rates(f"{SWEEP} seed"),
    may("closest_grazing", f"{SWEEP} seed", "f8", "smallest normal speed", GRAZING),
    need("outcome", f"{SWEEP} seed", "i1", "outcome", *OUTCOME),
    may("initial_state", "seed state", "f8", "initial state", "State from which each seed starts."),
    may("forcing_period", SWEEP, "f8", "forcing period", "Period of the forcing at each point of the sweep."),
    may("forcing_period_si", SWEEP, "f8", "forcing period", SI, "s"),
)

PARAMETER_CHART: Table = (
    axis(SWEEP, SWEEP, "f8", "swept parameter", "Values that the sweep ran through.", True),
    STATE,
    STATE_LABEL,
    SEED,
    SEED_NAME,
    ITERATE,
    EXPONENT,
    may("section", f"{SWEEP} seed iterate state", "f8", "state on the section", "The last points; NaN: no result."),
    need("period", f"{SWEEP} seed", "i2", "period found", "In iterates of the section; 0 when none was found."),
    may("lyapunov_exponent", _SPECTRA, "f8", "Lyapunov exponent", "Per unit of model time; -inf is rank loss."),
    may("lyapunov_error", _SPECTRA, "f8", "standard error of the exponent", "Twice it covers the truth in 95 %."),
    *rates(f"{SWEEP} seed"),
    may("closest_grazing", f"{SWEEP} seed", "f8", "smallest normal speed", GRAZING),
    need("attractor_count", SWEEP, "i2", "number of attractors", "Different ones among the seeds; 0: none found."),
    need("outcome", f"{SWEEP} seed", "i1", "outcome", *OUTCOME),
    may("initial_state", "seed state", "f8", "initial state", "State from which each seed starts."),
    may("forcing_period", SWEEP, "f8", "forcing period", "Period of the forcing at each point of the chart."),
    may("forcing_period_si", SWEEP, "f8", "forcing period", SI, "s"),
)

BASINS: Table = (
    axis(SWEEP, SWEEP, "f8", "initial state", "Values of the state from which the runs start.", True),
    STATE,
    STATE_LABEL,
    EXPONENT,
    axis("attractor_number", _TABLED, "i4", "number of the attractor", "Place in the table, from 1.", True),
    need("attractor", SWEEP, "i2", "attractor", "Number of the attractor that a start leads to; 0: none."),
    need("outcome", SWEEP, "i1", "outcome", *OUTCOME),
    need("attractor_period", _TABLED, "i2", "period of the attractor", "In iterates of the section, or 0."),
    need("attractor_outcome", _TABLED, "i1", "kind of the attractor", *OUTCOME),
    may("attractor_exponent", f"{_TABLED} exponent", "f8", "Lyapunov exponent", "Per unit of model time."),
    may("attractor_error", f"{_TABLED} exponent", "f8", "standard error of the exponent", "From blocks."),
    may("attractor_rate", _TABLED, "f8", "mean progression rate", "Penetration per unit of model time."),
    may("attractor_rate_si", _TABLED, "f8", "mean progression rate", SI, "m h-1"),
    need("attractor_state", f"{_TABLED} state", "f8", "state on the attractor", "A point of it on the section."),
    need("fraction", _TABLED, "f8", "fraction of the basin", "Part of the starts that lead to the attractor."),
    need("fraction_error", _TABLED, "f8", "standard error of the fraction", "sqrt(p(1 - p)/N) for N starts."),
    FORCING,
    FORCING_SI,
)
