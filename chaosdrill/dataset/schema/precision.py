"""Variables of `work-precision`."""

from chaosdrill.dataset.schema.shared import FORCING, OUTCOME, STATE, STATE_LABEL
from chaosdrill.dataset.schema.variable import Table, axis, clocked, need

_CELL = "method tolerance"

WORK_PRECISION: Table = (
    axis("quantity", "quantity", "str", "quantity", "What the error is an error of.", True),
    axis("method", "method", "str", "method", "Numerical method.", True),
    axis("tolerance", "tolerance", "f8", "tolerance", "Asked of the method; see steps_per_period too.", True),
    STATE,
    STATE_LABEL,
    need("error", f"quantity {_CELL}", "f8", "error", "NaN if not measured, infinite if events differ."),
    need("reference_error", "quantity", "f8", "error of the reference", "What two computations of it differ by."),
    clocked("wall_time", _CELL, "time a period", "Median over the runs; a unit of time if not forced."),
    clocked("wall_time_spread", _CELL, "spread of the time a period", "Distance of the quartiles of the runs."),
    need("steps", _CELL, "f8", "steps a period", "Mean; events end steps. A unit of time if not forced."),
    need("evaluations", _CELL, "f8", "evaluations a period", "Of the right-hand side; a jet counts as its order."),
    need("steps_per_period", _CELL, "i4", "fixed steps a period", "Or a part of duration; 0: chosen by the method."),
    need("exponent_error_spread", _CELL, "f8", "standard error of the exponent's error", "Over the restarts."),
    need("horizon", _CELL, "f8", "trusted time", "Until a chaotic trajectory is 1e-6 off; infinite if it stays."),
    need("horizon_expected", "tolerance", "f8", "expected trusted time", "ln(1e-6/tolerance)/exponent, in chaos."),
    need("outcome", _CELL, "i1", "outcome", *OUTCOME),
    need("period", "", "i4", "period of the cycle", "In forcing periods; 0 off a cycle."),
    need("lyapunov_exponent", "", "f8", "leading Lyapunov exponent", "Of the surveyed stretch of the attractor."),
    need("lyapunov_error", "", "f8", "standard error of the exponent", "Statistical; from blocks, not numerics."),
    need("start", "state", "f8", "start", "State from which all methods start, at the strobe."),
    FORCING,
)
