"""One step seen from outside of the method: how far, which event first, the state anywhere in it, and its end."""

import math

from chaosdrill.codegen.kinds import int64
from chaosdrill.engine import guards, taylor
from chaosdrill.engine import layout as at
from chaosdrill.engine.checked import ending
from chaosdrill.engine.events import take
from chaosdrill.engine.jit import inlined
from chaosdrill.engine.polynomial import values
from chaosdrill.engine.records import time_of, unit
from chaosdrill.engine.tangents import orthonormalise
from chaosdrill.engine.tuning import STEPS, TANGENTS


@inlined
def expand(functions, method, tables, settings, t, state, scratch):
    """Expand at the present state; returns the length of the step."""
    if settings.stepping == at.BY_SERIES:
        return taylor.expand(functions, tables, settings, t, state, scratch.workspace, scratch)
    return method.stepper.expand(method.place, method.p, t)


@inlined
def locate(functions, method, tables, settings, te, j, ties, h, t, state, scratch):
    """The first event that the polynomials of guards tell, made exact by methods that can: (time or -1, guard, ties,
    length of the step).

    A method without polynomials finds it here.
    """
    if settings.stepping == at.FIXED or (settings.stepping != at.BY_SERIES and te > 0.0):
        te, j, ties = method.stepper.locate(method.place, method.p, te, h, t)
        if te != te:
            h = te
    if settings.stepping != at.BY_SERIES and settings.stepping != at.FIXED and te > 0.0:
        row = state.x.size + settings.quadratures
        count = tables.active[state.run[0].mode, 0]
        te, j, ties = guards.earliest(functions, tables, settings, state, scratch.workspace, row, count, h, t, scratch)
    return te, j, ties, h


@inlined
def evaluate(method, settings, t, s, scratch):
    """States, then integrals of the quadratures since the start of the step, at s, into scratch."""
    if settings.stepping == at.BY_SERIES:
        values(scratch.workspace, scratch.out.size, s, scratch.out)
    else:
        method.stepper.evaluate(method.place, method.p, t, s)


@inlined
def instant_after(run, count, s):
    """First sample, ``count`` a period, later than s, both from the start of the step."""
    index = int((run.time + s) * count / run.period)
    instant = s
    while not instant > s:
        whole = index // count
        instant = (whole * run.period + (index - whole * count) * (run.period / count)) - run.time
        index += 1
    return instant


@inlined
def left_of(run, target):
    """Time to the last strobe of a run, from the start of the step, where a step may get there; else infinity.

    A step that begins just before a strobe may pass two.
    """
    rest = run.period - run.time
    ahead = target - run.strobes
    if ahead <= 1:
        return rest
    return rest + run.period if ahead == 2 else math.inf


@inlined
def up_to_strobe(run, target, te, early, happens):
    """Where a step ends that reaches to te, and whether its event happens there: not at the last strobe of a run.

    An event up to ``early`` before a strobe coincides with it, and comes after it.
    """
    left = left_of(run, target)
    if te + early >= left:
        return min(te, left), False
    return te, happens


@inlined
def instant_in_row(run, row):
    """The instant that a row of a buffer holds, as a number of periods and a rest, from the start of the step."""
    return (row[0] - run.strobes) * run.period + row[1] - run.time


@inlined
def write(method, settings, t, state, s, row, scratch):
    """Write the state at s, with the integrals and the mode, into a row."""
    n, out = state.x.size, scratch.out
    evaluate(method, settings, t, s, scratch)
    for i in range(n):
        row[i] = out[i]
    for i in range(n, out.size):
        row[i] = (state.sums[0, i - n] + state.sums[1, i - n]) + out[i]
    row[out.size] = state.run[0].mode


@inlined
def record_instants(method, settings, t, state, te, early, samples, scratch):
    """Write the states at the instants that fall into the step over these instants, which the rows hold.

    As a sample, an instant up to ``early`` after the end of the step shows the state before the event there.
    """
    run = state.run[0]
    if settings.recording != at.INSTANTS:
        return
    while run.sample_rows < samples.shape[0]:
        row = samples[run.sample_rows]
        s = instant_in_row(run, row)
        if not s <= te + early:
            return
        write(method, settings, t, state, max(0.0, min(s, te)), row, scratch)
        run.sample_rows += 1
        run.steps_since = 0


@inlined
def record(method, settings, t, state, te, early, samples, scratch):
    """Write the samples that fall into the step and count strobes; returns the time of the last strobe in it, or -1.

    A sample up to ``early`` after the end of the step coincides with the event there, and shows the state before it.
    """
    run = state.run[0]
    count = settings.samples
    offset = 0.0
    strobe = -1.0
    while True:
        index = run.sample + 1
        s = (run.period if index == count else index * (run.period / count)) - run.time + offset
        if not s <= te + early:
            return strobe
        if settings.recording == at.EVENLY:
            write(method, settings, t, state, min(s, te), samples[run.sample_rows], scratch)
            run.sample_rows += 1
        run.sample = index
        run.steps_since = 0
        if index == count:
            run.sample = 0
            pass_strobe(settings, run)
            offset += run.period
            strobe = s


@inlined
def pass_strobe(settings, run):
    run.strobes += 1
    run.steps_since = 0
    # without a period a strobe is where somebody has cut the run
    if settings.absolute_time == 0:
        run.events_in_period = 0


@inlined
def add_to(sums, i, term):
    """Add to a compensated sum (Neumaier 1974): row 0 holds the sum, row 1 what it has lost, row 2 the terms' sizes."""
    old = sums[0, i]
    new = old + term
    sums[1, i] += (old - new) + term if abs(old) >= abs(term) else (term - new) + old
    sums[0, i] = new
    sums[2, i] += abs(term)


@inlined
def advance(method, settings, t, state, s, scratch):
    """Move state, tangents and quadratures to s."""
    run, x, out = state.run[0], state.x, scratch.out
    n = x.size
    if settings.stepping == at.BY_SERIES:
        values(scratch.workspace, out.size, s, out)
        taylor.evaluate_vectors(scratch.workspace, s, run.live, state.vectors)
    else:
        method.stepper.advance(method.place, method.p, t, s)
    for i in range(n):
        x[i] = out[i]
    for i in range(n, out.size):
        add_to(state.sums, i - n, out[i])


@inlined
def _split(a):
    """A number as a sum of two with half of the digits each (Dekker 1971, doi:10.1007/BF01397083)."""
    c = 134217729.0 * a
    high = c - (c - a)
    return high, a - high


@inlined
def keep_time(settings, run, te, strobe):
    """Set the time to the end of a step; its last strobe, or -1, is given."""
    if strobe >= 0.0:
        run.time = te - strobe
        if settings.absolute_time == 1:
            # whole periods as an exact product: no time is lost however many they are
            number = float(run.strobes)
            run.whole = number * run.period
            a, b = _split(number)
            c, d = _split(run.period)
            run.rest = ((a * c - run.whole) + a * d + b * c) + b * d
    else:
        run.time += te


@inlined
def end_step(functions, tables, settings, te, strobe, j, ties, backs, outcome, state, buffer, scratch):
    """What follows when state and tangents are at the end of a step: the event of guard j, if that is not -1.

    Returns DONE, or the outcome that ends the run: ``outcome`` is that which the state has by itself.
    """
    run = state.run[0]
    keep_time(settings, run, te, strobe)
    if strobe >= 0.0:
        numbers = True
        for i in range(state.x.size):
            state.extent[i] = max(state.extent[i], abs(state.x[i]))
            for v in range(run.live):
                numbers &= abs(state.vectors[v, i]) < math.inf
        for i in range(settings.quadratures):
            numbers &= abs(state.sums[0, i]) < math.inf
        if outcome == at.DONE and not numbers:
            outcome = at.NONFINITE
    run.fresh = at.ONGOING
    run.longest = max(run.longest, te)
    if te > STEPS.smallest * run.longest:
        run.stalls = 0
    elif j >= 0:
        run.stalls += 1
    run.steps += 1
    run.steps_since += 1
    run.qr_since += 1
    if outcome != at.DONE:
        return outcome
    if run.steps_since > settings.max_steps and settings.stepping != at.FIXED:
        return at.STEP_UNDERFLOW
    guards.pass_sides(functions, tables, state, backs, te, time_of(run), scratch.gradient)
    orthonormal = settings.orthonormalise == 1
    if j >= 0:
        run.steps_since = 0
        if run.stalls > settings.max_stalls:
            return at.STALLED
        run.ties += ties
        thrown = guards.is_thrown(tables, state, j)
        if orthonormal and (thrown or tables.marks[run.mode, j] & at.LOSES_RANK):
            # a tangent may wait for an event that the last one has caused
            if thrown and run.rank_check == at.CHECKED:
                run.rank_check = at.AT_EVENT
            orthonormalise(functions, tables, state, scratch)
        largest = take(functions, tables, settings, j, time_of(run), state, buffer, scratch)
        if run.events_in_period > settings.max_events:
            return at.EVENT_LIMIT
        if largest == math.inf:
            # more events in one instant than there are transitions are rebounds without end, the last without a speed
            return at.STALLED if run.stalls > tables.transitions.shape[0] else at.NONFINITE
        if largest > TANGENTS.large:
            run.qr_since = run.qr_wait
    if orthonormal and (run.rank_check >= at.CHECKED or run.qr_since >= run.qr_wait):
        orthonormalise(functions, tables, state, scratch)
    return at.DONE


@unit(int64)
def stop(functions, tables, settings, h, t, state, buffer, scratch):
    """What comes of a step h that has no length or is no number: DONE where the event of a guard is due, or an outcome.

    There is no series to be evaluated; the event is taken where the run stands.
    """
    outcome, j = ending(functions, tables, settings, h, t, state, scratch)
    if j >= 0:
        outcome = end_step(functions, tables, settings, 0.0, -1.0, j, 0, scratch.backs, at.DONE, state, buffer, scratch)
    return outcome
