"""The types that compiled code has of what `chaosdrill.engine.layout` names, and when a run ends early."""

import math
from collections import namedtuple
from typing import Any, get_type_hints

from chaosdrill.codegen.kinds import Kind, NamedTuple, Pointer, Signature, Tuple, float64, int64, uint64, void
from chaosdrill.codegen.signatures import LANE_SIGNATURES, SIGNATURES, Functions, LaneFunctions, matrix
from chaosdrill.engine.jit import at_address, inlined, inner
from chaosdrill.engine.lanes import magnitude
from chaosdrill.engine.layout import DONE, ESCAPED, NONFINITE, LaneRoom, Machine, Results, State, States

STEPPER_SIGNATURES = {
    "expand": float64(int64, int64, float64),
    "locate": Tuple((float64, int64, int64))(int64, int64, float64, float64, float64),
    "evaluate": void(int64, int64, float64, float64),
    "advance": void(int64, int64, float64, float64),
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

machine_at = at_address(machine_type)
"""The `Machine` at an address."""


def _state_of():
    """The function of that name, as long as `State` has fields: numba has no loop over those of several types."""
    rows = (f"states.{name}[{'p : p + 1' if name == 'run' else 'k'}]" for name in State._fields)
    names = {"__name__": __name__, "State": State, "uint64": uint64}
    # every array would look whether a number with a sign counts from its end
    exec(f"def state_of(states, p):\n    k = uint64(p)\n    return State({', '.join(rows)})", names)
    return inlined(names["state_of"])


state_of = _state_of()
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
    """What a state comes to, which integrals may follow: these only have to be numbers."""
    n = bounds.shape[1]
    numbers = True
    for i in range(n, x.size):
        numbers &= abs(x[i]) < math.inf
    if numbers and within(x, n, bounds):
        return DONE
    for i in range(x.size):
        if not math.isfinite(x[i]):
            return NONFINITE
    return ESCAPED


@inlined
def time_of(run):
    """The time at which a run stands."""
    return (run.origin + run.whole) + (run.rest + run.time)
