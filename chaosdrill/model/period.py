"""Whether a system repeats after its declared period: one decision, for a definition and for the numbers of a run.

A definition is looked at by its expressions, at a few places; a run by its compiled functions, at more.
"""

import math
import random
from collections.abc import Callable, Mapping, Sequence
from decimal import Decimal
from typing import Any

from chaosdrill.model.tuning import TUNING
from chaosdrill.model.values import Definition

Values = Callable[[list[float], float], Sequence[float]]
"""Values of the compared expressions at states and a time; NaN where undefined."""


def strays(
    values: Values, states: int, rounding: Callable[[], float], period: float, count: int = TUNING.places_of_runs
) -> bool:
    """Whether a value is another one a period later, at one of a number of places; what is no number tells nothing.

    ``rounding``: gives what the ``period`` may be off by, as `rounding_of`, and is asked only where it matters.
    """
    rng = random.Random(20260104)
    for sample in range(count):
        x = [rng.uniform(*TUNING.drawn_below_one) * TUNING.sizes[sample % len(TUNING.sizes)] for _ in range(states)]
        t = rng.uniform(0, period)
        here, later = values(x, t), values(x, t + period)
        within = [values(x, t + share * period) for share in TUNING.later]
        seen = list(zip(here, later, *within, strict=True))
        off = [_off(TUNING.repeats, *one) for one in seen]
        if any(one > 0 for one in off) and (most := rounding()):
            rounded = [_off(TUNING.repeats_rounded, *one) for one in seen]
            if most < math.inf:
                ends = values(x, t + period - most), values(x, t + period + most)
                moved = [max(abs(a - now), abs(b - now)) for now, a, b in zip(later, *ends, strict=True)]
                rounded = [max(r, one - by) for r, one, by in zip(rounded, off, moved, strict=True)]
            off = rounded
        if any(one > 0 for one in off):
            noise = [0.0] * len(off)
            for _ in range(TUNING.nudges):
                beside = [value * _nudge(rng) for value in x]
                now = t * _nudge(rng)
                for first, second in ((here, values(beside, now)), (later, values(beside, now + period))):
                    noise = [max(n, abs(b - a)) for n, a, b in zip(noise, first, second, strict=True)]
            if any(one > TUNING.cancelled * n for one, n in zip(off, noise, strict=True)):
                return True
    return False


def rounding_of(period: Any, parameters: Mapping[str, Any]) -> float:
    """What a period may be off by: what half a unit of the last digit of its numbers and parameters moves it by.

    Infinite for a multiple of one number or parameter, of which it is not known how it was written.
    """
    import sympy

    _, of = period.as_coeff_Mul()
    if of == 1 or of.is_Symbol:
        return math.inf
    total = 0.0
    numbers = {number: float(number) for number in period.atoms(sympy.Float)}
    numbers |= {p: float(parameters[p.name]) for p in period.free_symbols if p.name in parameters}
    for number, value in numbers.items():
        free = sympy.Dummy(real=True)
        slope = value_of(period.xreplace({number: free}).diff(free).xreplace({free: number}), parameters)
        halves = (_half_unit(value * times) / times for times in TUNING.multiples)
        # a number of few digits is meant as it stands
        total += abs(slope) * max((h for h in halves if h <= TUNING.repeats_rounded * abs(value)), default=0.0)
    return total


def _half_unit(number: float) -> float:
    """Half a unit of the last digit of a number."""
    return 10.0 ** int(Decimal(f"{number:.15g}").normalize().as_tuple().exponent) / 2


def _off(part: float, here: float, later: float, *within: float) -> float:
    """By how much a value differs a period later beyond what is allowed; 0 where one is no number."""
    if not all(map(math.isfinite, (here, later, *within))):
        return 0.0
    moves = max(abs(value - here) for value in within)
    return abs(later - here) - part * moves - TUNING.rounded * abs(here)


def _nudge(rng: random.Random) -> float:
    return 1.0 + rng.randint(-TUNING.nudge, TUNING.nudge) * 2.0**-52


def is_periodic(found: Definition, expression: Any) -> bool:
    """Whether an expression is proved to repeat after the declared period, whatever the parameters."""
    if found.time not in expression.free_symbols:
        return True
    import sympy

    from chaosdrill.model.python import Called

    if expression.has(Called):
        return False

    def turned(argument: Any) -> Any:
        spread = sympy.expand(argument)
        turns = spread.coeff(sympy.pi)
        # two decimal numbers may have a rounded product
        whole = turns.is_Float and abs(turns - round(turns)) <= TUNING.rounded * abs(turns)
        return spread - turns * sympy.pi + round(turns) * sympy.pi if whole else spread

    later = expression.xreplace({found.time: found.time + found.period})
    later = later.replace(lambda e: isinstance(e, sympy.Function), lambda e: e.func(*map(turned, e.args)))
    return bool(sympy.expand(later - expression) == 0)


def wrong_period(found: Definition, numbers: Mapping[str, Any]) -> str | None:
    """Say why the declared period is wrong: not positive, or not a period of an expression that depends on time.

    One that also names a state which never changes (a parameter among the states) is left to the run, which knows it.
    """
    if found.period is None:
        return None
    from chaosdrill.model.exponents import differences, expressions
    from chaosdrill.model.places import parameter

    known = found.period.free_symbols <= set(map(parameter, numbers))
    period = value_of(found.period, numbers) if known else math.nan
    if not 0 < period < math.inf:
        named = {s.name: numbers[s.name] for s in found.period.free_symbols}
        at = f" at {named}" if named else ""
        return f"the period {found.period} is not a positive number{at}; leave it out if nothing depends on time"
    for expression in differences(expressions(found)):
        if not repeats(found, expression, numbers):
            declared = f"{found.period} = {period:.12g}" if not found.period.is_Number else f"{period:.12g}"
            return (
                f"{expression} does not repeat after the declared period {declared}; correct the period, as in "
                "2*pi/omega, or leave it out"
            )
    return None


def repeats(found: Definition, expression: Any, numbers: Mapping[str, Any]) -> bool:
    """Whether an expression repeats after the period, if there is one; true where a state that never changes is in it.

    ``numbers``: values of the parameters, at which the period is positive.
    """
    import sympy

    from chaosdrill.model.derive import frozen_states
    from chaosdrill.model.places import parameter
    from chaosdrill.model.text import double

    if found.period is None or found.time not in expression.free_symbols:
        return True
    if expression.free_symbols.intersection(frozen_states(found)):
        return True
    values = {parameter(name): value for name, value in numbers.items()}
    fixed = (f for f in expression.atoms(sympy.Function) if f.free_symbols <= set(values))
    known = {f: sympy.Float(number) for f in fixed if math.isfinite(number := value_of(f, numbers))}
    plain = expression.xreplace(known)

    def value(x: list[float], instant: float) -> list[float]:
        here = {**values, **dict(zip(found.states, x, strict=True)), found.time: instant}
        seen = double(plain, here, _mix)
        return [math.nan if seen is None else seen]

    period = value_of(found.period, numbers)
    strayed = strays(value, len(found.states), lambda: rounding_of(found.period, numbers), period, len(TUNING.sizes))
    return not strayed or is_periodic(found, expression)


def _mix(*arguments: float) -> float:
    """A function that repeats if its arguments do, as every special one."""
    return sum((place + 2) * argument for place, argument in enumerate(arguments))


def value_of(expression: Any, parameters: Mapping[str, float]) -> float:
    """Value of an expression of parameters; NaN without a real value."""
    try:
        return float(expression.subs({p: parameters[p.name] for p in expression.free_symbols}))
    except (TypeError, OverflowError):
        return math.nan
