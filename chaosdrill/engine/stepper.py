"""What a method offers that steps by evaluations of the right-hand side: five functions of fixed signature.

The engine calls them by their addresses, so that it is compiled once, and a method when it is first used. The Taylor
method is part of the engine itself: three calls a step would cost it a third of its speed. They are given the address
of the `Machine`, the run, and the time at the start of the step.

* ``expand`` length of the next step; guards that have a polynomial on it fill rows of the workspace, behind those of
  states and integrals
* ``locate`` first event of the step: (time or -1, guard, ties); where guards have polynomials, ``times`` holds what
  they say, which is made exact
* ``evaluate`` states and quadratures at s, into ``out``
* ``advance`` the same, and tangents in place
* ``escape`` when the step leaves the bounds, and beyond which: (time or -1, bound); the same for all of them
"""

from functools import cache
from importlib import import_module
from typing import Any

from chaosdrill.engine.jit import Layout, Record, compiled
from chaosdrill.engine.layout import Machine
from chaosdrill.engine.methods import METHODS
from chaosdrill.engine.records import STEPPER_SIGNATURES, Stepper, machine_type


class _Absent:
    """A function that is never called."""

    address = 0


_MACHINE = Layout(machine_type)


def offered(function: Any) -> Any:
    """Compile one of the functions that a method has of its own, by its name."""
    return compiled(STEPPER_SIGNATURES[function.__name__])(function)


@cache
def stepper(method: str) -> Stepper:
    """The functions of a method."""
    if METHODS[method].series:
        return Stepper(*[_Absent] * len(Stepper._fields))
    # the series method needs neither
    from chaosdrill.engine.fences import escape

    module = import_module(f"chaosdrill.engine.{method}")
    return Stepper(*(getattr(module, name) for name in STEPPER_SIGNATURES if name != "escape"), escape=escape)


def machine(
    functions: Any, method: str, settings: Any, tables: Any, states: Any, scratch: Any, *, search: Any = _Absent
) -> Record:
    """What compiled functions need for runs of a system, in memory; ``flow`` needs no ``search``, see `Machine`."""
    held = Machine(functions, stepper(method), search, settings, tables, states, scratch)
    return Record(_MACHINE, held)
