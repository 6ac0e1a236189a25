"""A definition that was spoilt in any way is a system, or one ModelError that names places; never anything else."""

import copy
import json

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import chaosdrill as cd
from chaosdrill import systems
from chaosdrill.errors import ChaosdrillError
from chaosdrill.model.definition import build_defined, write_definition

SOUND = [systems.build("impact-oscillator"), systems.build("bouncing-ball"), cd.drill(contact="newton")]
TEXTS = st.sampled_from(
    [
        "",
        "x",
        "free",
        "9**9**9",
        "1/0",
        "v > 1",
        "cos(t)",
        "True",
        "`",
        "(" * 500,
        "inf",
        "nan",
        "mode",
        "a/b",
        "\n",
        "é",
    ]
)
LEAVES = st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), TEXTS, st.text(max_size=5))
VALUES = st.recursive(
    LEAVES,
    lambda c: st.lists(c, max_size=3) | st.dictionaries(TEXTS | st.text(max_size=3), c, max_size=3),
    max_leaves=4,
)


def places(value, path=()):
    """Paths of everything inside of plain data."""
    inside = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in inside:
        yield (*path, key)
        yield from places(inner, (*path, key))


def attempt(*arguments, **numbers):
    """The system and no fault, or no system and the fault."""
    try:
        return build_defined(*arguments, **numbers), ""
    except ChaosdrillError as fault:
        return None, str(fault)


@settings(max_examples=200, suppress_health_check=[HealthCheck.too_slow])
@given(st.data())
def test_any_change(data):
    system = data.draw(st.sampled_from(SOUND))
    definition = copy.deepcopy(write_definition(system))
    numbers = {"parameters": dict(system.parameters), "initial": dict(system.initial)}
    for _ in range(data.draw(st.integers(1, 3))):
        whole = {"definition": definition, **numbers}
        path = data.draw(st.sampled_from([path for path in places(whole) if len(path) > 1]))
        holder = whole
        for key in path[:-1]:
            holder = holder[key]
        way = data.draw(st.sampled_from(["value", "key", "gone", "twice"]))
        if way == "value" or isinstance(holder, list):
            holder[path[-1]] = data.draw(VALUES)
        elif way == "key":
            holder[data.draw(TEXTS)] = holder.pop(path[-1])
        elif way == "gone":
            del holder[path[-1]]
        else:
            holder[data.draw(TEXTS)] = copy.deepcopy(holder[path[-1]])
    made, fault = attempt(definition, **numbers)
    if made is None:
        assert 0 < len(fault) < 50_000
        return
    assert json.loads(json.dumps(write_definition(made), allow_nan=False)) == write_definition(made)


@given(VALUES)
def test_anything_else(value):
    made, fault = attempt(value, {"k": 1.0})
    assert made is None
    assert "definition" in fault
