"""One step seen from outside of the method: how far, which event first, and the state anywhere in it."""

from chaosdrill.engine import guards, rk4, taylor
from chaosdrill.engine.jit import inlined, inner
from chaosdrill.engine.layout import (
    AFTER,
    BEFORE,
    ENDS,
    EVENTS_IN_PERIOD,
    FIRED,
    FRESH,
    GRADIENT,
    IMAGE,
    LIVE,
    METHOD,
    MODE,
    MOVED,
    NONE,
    ONGOING,
    ORDER,
    OUT,
    PERIOD,
    POLYNOMIAL,
    PROVEN,
    QUADRATURES,
    RECORD,
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
    functions, settings_i, settings_f, watch, marks, local, t, c, x, vectors, carried, carried_f, sides, armed, scratch
):
    """Expand at the present state: (length of the step, time of the first event in it or -1, guard, ties)."""
    mode = carried[MODE]
    count = watch[mode, 0]
    if settings_i[METHOD] == TAYLOR:
        ws = scratch[WORKSPACE]
        first = x.size + settings_i[QUADRATURES]
        h = taylor.expand(functions, first + count, first, settings_i, settings_f, t, c, x, vectors, carried, ws)
        if carried[FRESH] != ONGOING or h > 1.3 * carried_f[PROVEN]:
            place, rate, slope = scratch[IMAGE], scratch[BEFORE], scratch[AFTER]
            h = taylor.proven_step(functions, h, settings_i, settings_f, t, c, x, carried, ws, place, rate, slope)
            carried_f[PROVEN] = h
        floor = 0.0
        for i in range(x.size):
            floor = max(floor, abs(x[i]))
        polynomials = (scratch[POLYNOMIAL], scratch[SHIFTED], scratch[STACK], scratch[ENDS], scratch[TIMES])
        te, j, ties = guards.first_event(
            ws,
            first,
            watch[mode, 1:],
            count,
            marks[mode],
            settings_i[ORDER],
            h,
            2e-15 * floor,
            carried[FRESH],
            carried[FIRED],
            sides,
            armed,
            polynomials,
        )
    else:
        h = rk4.next_step(settings_f, local)
        te, j, ties = rk4.first_event(
            functions,
            watch[mode, 1:],
            count,
            marks[mode],
            t,
            c,
            x,
            h,
            settings_f,
            carried,
            carried[FRESH],
            carried[FIRED],
            sides,
            armed,
            scratch[NONE],
            scratch[OUT],
            scratch[GRADIENT],
            scratch[STAGES],
        )
    return h, te, j, ties


@inner
def evaluate(functions, settings_i, t, c, x, s, carried, scratch):
    """States, then integrals of the quadratures since the start of the step, at s, into scratch."""
    out = scratch[OUT]
    if settings_i[METHOD] == TAYLOR:
        taylor.evaluate(scratch[WORKSPACE], out.size, settings_i[ORDER], s, out)
    else:
        rk4.move(functions, carried[MODE], t, c, x, s, scratch[NONE], 0, out, scratch[NONE], scratch[STAGES])


@inlined
def record(functions, settings_i, settings_f, local, t, c, x, sums, te, carried, samples, scratch):
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
            evaluate(functions, settings_i, t, c, x, s, carried, scratch)
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
def advance(functions, settings_i, t, c, x, s, sums, vectors, carried, scratch):
    """Move state, tangents and quadratures to s; quadratures by a compensated sum (Neumaier 1974)."""
    n = x.size
    out = scratch[OUT]
    live = carried[LIVE]
    if settings_i[METHOD] == TAYLOR:
        taylor.evaluate(scratch[WORKSPACE], out.size, settings_i[ORDER], s, out)
        taylor.evaluate_vectors(scratch[WORKSPACE], settings_i[ORDER], s, live, vectors)
    else:
        moved = scratch[MOVED]
        rk4.move(functions, carried[MODE], t, c, x, s, vectors, live, out, moved, scratch[STAGES])
        for v in range(live):
            for i in range(n):
                vectors[v, i] = moved[v, i]
    for i in range(n):
        x[i] = out[i]
    for i in range(n, out.size):
        old = sums[0, i - n]
        new = old + out[i]
        sums[1, i - n] += (old - new) + out[i] if abs(old) >= abs(out[i]) else (out[i] - new) + old
        sums[0, i - n] = new
