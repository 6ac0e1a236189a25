"""Functions in the place of a method's own where the engine steps by itself."""

from chaosdrill.engine.stepper import offered


@offered
def expand(
    field, variation, guard, guard_error, first, count, marks, settings, run, t, c, x, scale, vectors, ws, stages,
    gradient,
):  # fmt: skip
    return 0.0


@offered
def locate(
    field, variation, guard, guard_error, first, te, h, t, tables, settings, run, c, x, sides, ws, stages,
    gradient, errors, times, backs, out,
):  # fmt: skip
    return -1.0, -1, 0


@offered
def evaluate(field, variation, t, c, x, s, run, stages, out):
    pass


@offered
def advance(field, variation, t, c, x, s, vectors, run, stages, out):
    pass
