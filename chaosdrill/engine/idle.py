"""Functions in the place of a method's own where the engine steps by itself."""

from chaosdrill.engine.stepper import offered


@offered
def expand(
    field,
    variation,
    guard,
    first,
    count,
    marks,
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
    stages,
    gradient,
):
    return 0.0


@offered
def locate(
    field,
    variation,
    guard,
    first,
    count,
    directions,
    marks,
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
    stages,
    gradient,
    times,
    out,
):
    return -1.0, -1, 0


@offered
def evaluate(field, variation, t, c, x, s, carried, stages, out):
    pass


@offered
def advance(field, variation, t, c, x, s, vectors, carried, carried_f, stages, out):
    pass
