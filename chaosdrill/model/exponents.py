"""Parameters that stand in exponents, as n does in d**n.

Where such a parameter is a whole number the power is a polynomial, which has a Taylor series at d = 0 too; the code of
a system is therefore generated for the whole numbers that its exponents have.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import sympy

from chaosdrill.model.places import S, parameter, rewritten
from chaosdrill.model.special import positive_power
from chaosdrill.model.values import Definition, System


def exponent_parameters(system: System) -> tuple[str, ...]:
    """Names of the parameters in exponents of what moves, in the order of the system's parameters."""
    symbols = {parameter(name): name for name in system.parameters}
    found = set()
    for expression in expressions(system):
        for power in expression.atoms(sympy.Pow, positive_power):
            base, exponent = power.args
            if exponent.free_symbols <= symbols.keys() and not base.free_symbols <= symbols.keys():
                found |= {symbols[s] for s in exponent.free_symbols}
    return tuple(name for name in system.parameters if name in found)


def specialise(system: S, values: Mapping[str, int]) -> S:
    """The system with these numbers in place of the parameters in exponents, and nowhere else."""
    return rewritten(system, lambda expression: specialised(expression, values))


def specialised(expression: Any, values: Mapping[str, int]) -> Any:
    """The same for one expression."""
    numbers = {parameter(name): sympy.Integer(value) for name, value in values.items()}
    return sympy.sympify(expression).replace(
        lambda part: isinstance(part, sympy.Pow | positive_power) and part.args[1].free_symbols & numbers.keys(),
        lambda part: part.func(part.args[0], part.args[1].subs(numbers)),
    )


def expressions(system: Definition) -> Iterator[Any]:
    """Rates, quadratures, guards, resets and conditions."""
    yield from motion(system)
    for rates in system.quadratures.values():
        yield from rates.values()


def motion(system: Definition) -> Iterator[Any]:
    """All expressions that determine the motion: rates, guards, resets and conditions."""
    for rates in system.modes.values():
        yield from rates.values()
    for transition in system.transitions:
        yield from (transition.guard, *transition.reset.values(), *transition.conditions.values())


def differences(given: Iterable[Any]) -> Iterator[Any]:
    """Expressions, with conditions as numbers: the differences of what they compare."""
    for expression in given:
        relations = expression.atoms(sympy.core.relational.Relational)
        yield from (relation.lhs - relation.rhs for relation in relations) if relations else (expression,)
