"""The types that compiled code has of what `chaosdrill.engine.layout` names, and when a run ends early."""

import inspect
import math
from collections import namedtuple
from collections.abc import Callable
from functools import cached_property
from typing import Any, get_type_hints

from chaosdrill.codegen.kinds import (
    UNCOMPILED,
    Kind,
    NamedTuple,
    Pointer,
    RecordOf,
    Signature,
    Tuple,
    boolean,
    float64,
    int64,
    void,
)
from chaosdrill.codegen.signatures import LANE_SIGNATURES, SIGNATURES, Functions, LaneFunctions, matrix, vector
from chaosdrill.engine import jit
from chaosdrill.engine.jit import Written, at_address, inlined, inner
from chaosdrill.engine.lanes import magnitude
from chaosdrill.engine.layout import (
    DONE,
    ESCAPED,
    NONFINITE,
    SETTINGS,
    LaneRoom,
    Machine,
    Results,
    Scratch,
    State,
    States,
    Tables,
)

STEPPER_SIGNATURES = {
    "expand": float64(int64, int64, float64),
    "locate": Tuple((float64, int64, int64))(int64, int64, float64, float64, float64),
    "evaluate": void(int64, int64, float64, float64),
    "advance": void(int64, int64, float64, float64),
    "escape": Tuple((float64, int64))(int64, int64, float64, float64),
}
"""Signatures of a method's functions, see ``engine.stepper``."""

SEARCH_SIGNATURE = Tuple((float64, int64, int64, float64))(int64, int64, float64, float64)
"""``first_event(place, p, h, t)``: time of it or -1, -2 for a start that is refused; guard; ties; length of the step"""

FLOW_SIGNATURE = int64(int64, int64, matrix, matrix)
"""``flow(place, p, samples, events)``: how the call ends"""

Stepper = namedtuple("Stepper", STEPPER_SIGNATURES)
"""A method's functions, see ``engine.stepper``."""


def _pointers(functions: type, signatures: dict[str, Signature], prefix: str = "") -> NamedTuple:
    return NamedTuple([Pointer(prefix + name, one) for name, one in signatures.items()], functions)


def _type_of(fields: type, **others: Kind) -> NamedTuple:
    """The type of a named tuple whose fields are annotated with theirs; those of ``others`` are given."""
    hints = get_type_hints(fields, include_extras=True) | others
    return NamedTuple([_kind_of(one) for one in hints.values()], fields)


def _kind_of(hint: Any) -> Kind:
    if isinstance(hint, Kind):
        return hint
    return hint.__metadata__[0] if hasattr(hint, "__metadata__") else _type_of(hint)


functions_type = _pointers(Functions, SIGNATURES)
lane_functions_type = _pointers(LaneFunctions, LANE_SIGNATURES, "lane_")
states_type, results_type, lane_room_type = map(_type_of, (States, Results, LaneRoom))
machine_type = _type_of(
    Machine,
    functions=functions_type,
    stepper=_pointers(Stepper, STEPPER_SIGNATURES),
    search=Pointer("search", SEARCH_SIGNATURE),
)


class _InMemory(Kind):
    """A record that is read where it is; of `States`, that of one run."""

    def __init__(self, kind: NamedTuple, *, one: bool = False) -> None:
        super().__init__(kind.name)
        self._kind, self._one = kind, one

    @cached_property
    def real(self) -> Any:
        from chaosdrill.engine.front_end import InMemory, OneOf

        found = InMemory(self._kind.real)
        return OneOf(found) if self._one else found


_ARGUMENTS: dict[str, Kind] = {
    "functions": _InMemory(functions_type),
    "tables": _InMemory(_type_of(Tables)),
    "settings": RecordOf(SETTINGS),
    "state": _InMemory(states_type, one=True),
    "scratch": _InMemory(_type_of(Scratch)),
    "scale": vector,
    "buffer": matrix,
    **dict.fromkeys(("h", "t", "hardest", "root"), float64),
    **dict.fromkeys(("j", "order", "side", "transition", "with_tangents"), int64),
    **dict.fromkeys(("sure", "plain"), boolean),
}


def unit(result: Kind) -> Callable[[Any], Any]:
    """As ``rare``, for what is compiled by itself, once for all that call it: its arguments have their usual names."""

    def wrap(function: Any) -> Any:
        names = inspect.signature(function).parameters
        for name in names:
            if name not in _ARGUMENTS:
                raise TypeError(f"{function.__module__}.{function.__name__} has an argument of no known kind: {name}")
        return jit.unit(function, Signature(result, [_ARGUMENTS[name] for name in names]))

    return wrap


machine_at = at_address(machine_type)
"""The `Machine` at an address."""


def _state_of(states: States, p: int) -> State:
    return State(*(rows[p : p + 1] if name == "run" else rows[p] for name, rows in states._asdict().items()))


state_of: Any = _state_of if UNCOMPILED else Written("state_of")
"""``state_of(states, p)``: run p of many."""


@inlined
def within(x, n, bounds):
    """Whether all n states are numbers within their bounds, of one run or of each lane."""
    found = x[0] < math.inf
    for i in range(n):
        found = found & (magnitude(x[i]) < math.inf) & (x[i] >= bounds[0, i]) & (x[i] <= bounds[1, i])
    return found


@inner
def state_outcome(x, bounds):
    """What a state comes to, which integrals may follow: within its bounds these only have to be numbers."""
    n = bounds.shape[1]
    numbers = True
    for i in range(n, x.size):
        numbers &= abs(x[i]) < math.inf
    if within(x, n, bounds):
        return DONE if numbers else NONFINITE
    for i in range(n):
        if not math.isfinite(x[i]):
            return NONFINITE
    return ESCAPED


@inlined
def time_of(run):
    """The time at which a run stands."""
    return (run.origin + run.whole) + (run.rest + run.time)
