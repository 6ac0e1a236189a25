"""Variables of single runs: `trajectory`, `poincare-section`, `lyapunov-spectrum`."""

from chaosdrill.dataset.schema.shared import (
    EXPONENT,
    FORCING,
    GRAZING,
    ITERATE,
    MULTIPLIER,
    OUTCOME,
    STATE,
    STATE_LABEL,
    rates,
)
from chaosdrill.dataset.schema.variable import QUADRATURE, Table, axis, may, need

TRAJECTORY: Table = (
    axis("time", "time", "f8", "model time", "Dimensionless time of each sample.", True),
    STATE,
    STATE_LABEL,
    need("state", "time state", "f8", "state", "States of the hybrid system at the sample times."),
    need("mode", "time", "i1", "mode", "Mode that holds at the sample time.", flags="mode"),
    may(QUADRATURE, "time", "f8", "quadrature", "Integral along the flow from the start of the record."),
    need("event_time", "event", "f8", "time of the event", "Times do not decrease; equal times are ties."),
    need("event_kind", "event", "i1", "transition taken", "Which transition it was.", flags="transition"),
    need("event_speed", "event", "f8", "normal speed", "Rate of the guard at the crossing; small means grazing."),
    may("event_mode_before", "event", "i1", "mode before the event", "Mode left.", flags="mode"),
    may("event_mode_after", "event", "i1", "mode after the event", "Mode entered.", flags="mode"),
    need("event_state_before", "event state", "f8", "state before the event", "Projected onto the guard."),
    need("event_state_after", "event state", "f8", "state after the event", "After the reset."),
    need("outcome", "", "i1", "outcome", *OUTCOME),
    FORCING,
)

POINCARE_SECTION: Table = (
    STATE,
    STATE_LABEL,
    ITERATE,
    need("section", "iterate state", "f8", "state on the section", "At the strobe: at forcing phase zero."),
    axis("time", "iterate", "f8", "model time of the crossing", "Dimensionless; counted from the start.", True),
    may("phase", "iterate", "f8", "forcing phase of the crossing", "In parts of a forcing period, 0 to 1."),
    may("mode", "iterate", "i1", "mode on the section", "Mode that holds at the crossing.", flags="mode"),
    may(QUADRATURE, "iterate", "f8", "quadrature", "Integral along the flow from the start of the record."),
    may("period", "", "i4", "period found", "In iterates of the section; 0 when none was found."),
    MULTIPLIER,
    may("multiplier_real", "multiplier", "f8", "multiplier, real part", "Eigenvalues of the cycle's tangent map."),
    may("multiplier_imag", "multiplier", "f8", "multiplier, imaginary part", "NaN when no period was found."),
    *rates(""),
    may("closest_grazing", "", "f8", "smallest normal speed", GRAZING),
    need("outcome", "", "i1", "outcome", *OUTCOME),
    FORCING,
)

LYAPUNOV_SPECTRUM: Table = (
    EXPONENT,
    need("lyapunov_exponent", "exponent", "f8", "Lyapunov exponent", "Per unit of model time; -inf is rank loss."),
    need("lyapunov_error", "exponent", "f8", "standard error of the exponent", "From blocks of several lengths."),
    need("lyapunov_history", "block exponent", "f8", "running mean of the exponents", "Up to the block's end."),
    axis("block_time", "block", "f8", "model time at the block's end", "Counted from the end of the transient."),
    need("kaplan_yorke_dimension", "", "f8", "Kaplan-Yorke dimension", "From the exponents; holds with -inf too."),
    *rates(""),
    axis("transition_name", "transition", "str", "name of the transition", "Label of the dimension transition."),
    may("event_count", "transition", "i8", "number of events", "How often each transition was taken."),
    may("tie_count", "", "i8", "number of ties", "Events that fell on the same instant as the one before."),
    need("closest_grazing", "", "f8", "smallest normal speed", GRAZING),
    may("rank", "", "i4", "live tangents", "Rank of the tangent map's product: the number of finite exponents."),
    need("outcome", "", "i1", "outcome", *OUTCOME),
    FORCING,
)
