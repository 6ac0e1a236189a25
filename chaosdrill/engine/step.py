"""One step seen from outside of the method: how far, which event first, and the state anywhere in it.

``stepper`` holds the functions of ``engine.stepper``, in that order.
"""

from chaosdrill.engine import guards, taylor
from chaosdrill.engine.jit import inlined, inner
from chaosdrill.engine.layout import (
    AFTER,
    BEFORE,
    ENDS,
    EVALUATIONS,
    EVENTS_IN_PERIOD,
    FIRED,
    FRESH,
    GRADIENT,
    LIVE,
    METHOD,
    MODE,
    ON_GUARD,
    ONGOING,
    ORDER,
    OUT,
    PERIOD,
    POLYNOMIAL,
    PROVEN,
    QUADRATURES,
    RECORD,
    RK4,
    SAMPLE,
    SAMPLE_ROWS,
    SAMPLES,
    SHIFTED,
    STACK,
    STAGES,
    STROBES,
    TAYLOR,
    TIMES,
    WORKSPACE,
)


@inlined
def prepare(
    functions,
    stepper,
    settings_i,
    settings_f,
    watch,
    marks,
    local,
    t,
    c,
    x,
    vectors,
    carried,
    carried_f,
    sides,
    armed,
    scratch,
):
    """Expand at the present state: (length of the step, time of the first event in it or -1, guard, ties)."""
    mode = carried[MODE]
    count = watch[mode, 0]
    directions = watch[mode, 1:]
    method = settings_i[METHOD]
    ws = scratch[WORKSPACE]
    first = x.size + settings_i[QUADRATURES]
    if method == TAYLOR:
        h = taylor.expand(functions, first + count, settings_i, settings_f, t, c, x, vectors, carried, ws)
        carried[EVALUATIONS] += settings_i[ORDER]
        if carried[FRESH] != ONGOING or h > 1.3 * carried_f[PROVEN]:
            spare = (scratch[OUT], scratch[BEFORE], scratch[AFTER])
            h = taylor.proven_step(functions, h, settings_i, settings_f, t, c, x, carried, ws, spare)
            carried_f[PROVEN] = h
        if taylor.has_unproven(marks[mode], count):
            h = taylor.proven_guards(
                functions[5],
                h,
                first,
                count,
                marks[mode],
                settings_f,
                t,
                c,
                x,
                carried,
                ws,
                scratch[BEFORE],
                scratch[GRADIENT],
            )
    else:
        h = stepper[0](
            functions[3],
            functions[4],
            functions[5],
            first,
            count,
            marks[mode],
            settings_i,
            settings_f,
            local,
            t,
            c,
            x,
            vectors,
            carried,
            carried_f,
            ws,
            scratch[STAGES],
            scratch[GRADIENT],
        )
    te = -1.0
    j = -1
    ties = 0
    if method != RK4:
        floor = 0.0
        for i in range(x.size):
            floor = max(floor, abs(x[i]))
        polynomials = (scratch[POLYNOMIAL], scratch[SHIFTED], scratch[STACK], scratch[ENDS], scratch[TIMES])
        te, j, ties = guards.first_event(
            ws,
            first,
            directions,
            count,
            marks[mode],
            settings_i[ORDER],
            h,
            settings_f[ON_GUARD] * floor,
            carried[FRESH],
            carried[FIRED],
            sides,
            armed,
            polynomials,
        )
    if method == RK4 or (method != TAYLOR and te > 0.0):
        te, j, ties = stepper[1](
            functions[3],
            functions[4],
            functions[5],
            first,
            count,
            directions,
            marks[mode],
            settings_f,
            te,
            h,
            t,
            c,
            x,
            carried,
            sides,
            armed,
            ws,
            scratch[STAGES],
            scratch[GRADIENT],
            scratch[TIMES],
            scratch[OUT],
        )
    return h, te, j, ties


@inner
def evaluate(functions, stepper, settings_i, t, c, x, s, carried, scratch):
    """States, then integrals of the quadratures since the start of the step, at s, into scratch."""
    out = scratch[OUT]
    if settings_i[METHOD] == TAYLOR:
        taylor.evaluate(scratch[WORKSPACE], out.size, s, out)
    else:
        stepper[2](functions[3], functions[4], t, c, x, s, carried, scratch[STAGES], out)


@inlined
def record(functions, stepper, settings_i, settings_f, local, t, c, x, sums, te, carried, samples, scratch):
    """Write the samples that fall into the step and count strobes; returns the time of the last strobe in it, or -1."""
    n = x.size
    out = scratch[OUT]
    count = settings_i[SAMPLES]
    period = settings_f[PERIOD]
    offset = 0.0
    strobe = -1.0
    while True:
        index = carried[SAMPLE] + 1
        s = (period if index == count else index * (period / count)) - local + offset
        if not s <= te:
            return strobe
        if settings_i[RECORD] == 1:
            evaluate(functions, stepper, settings_i, t, c, x, s, carried, scratch)
            row = samples[carried[SAMPLE_ROWS]]
            for i in range(n):
                row[i] = out[i]
            for i in range(n, out.size):
                row[i] = (sums[0, i - n] + sums[1, i - n]) + out[i]
            row[out.size] = carried[MODE]
            carried[SAMPLE_ROWS] += 1
        carried[SAMPLE] = index
        if index == count:
            carried[SAMPLE] = 0
            carried[STROBES] += 1
            carried[EVENTS_IN_PERIOD] = 0
            offset += period
            strobe = s


@inlined
def add_to(sums, i, term):
    """Add to a compensated sum (Neumaier 1974): row 0 holds the sum, row 1 what it has lost."""
    old = sums[0, i]
    new = old + term
    sums[1, i] += (old - new) + term if abs(old) >= abs(term) else (term - new) + old
    sums[0, i] = new


@inlined
def advance(functions, stepper, settings_i, t, c, x, s, sums, vectors, carried, carried_f, scratch):
    """Move state, tangents and quadratures to s."""
    n = x.size
    out = scratch[OUT]
    live = carried[LIVE]
    if settings_i[METHOD] == TAYLOR:
        taylor.evaluate(scratch[WORKSPACE], out.size, s, out)
        taylor.evaluate_vectors(scratch[WORKSPACE], s, live, vectors)
    else:
        stepper[3](functions[3], functions[4], t, c, x, s, vectors, carried, carried_f, scratch[STAGES], out)
    for i in range(n):
        x[i] = out[i]
    for i in range(n, out.size):
        add_to(sums, i - n, out[i])
