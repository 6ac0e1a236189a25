"""Whether the table ``system.definition`` of a scene is a hybrid system."""

from collections.abc import Mapping
from typing import Any

from chaosdrill.errors import ChaosdrillError
from chaosdrill.names import remedy
from chaosdrill.scene.lines import Path
from chaosdrill.scene.problems import Problem

AT: Path = ("system", "definition")


def check_definition(
    definition: Mapping[str, Any], parameters: Mapping[str, Any], effects: Mapping[str, Any]
) -> tuple[tuple[str, ...], list[Problem]]:
    """Check a definition with the parameters that stand beside it.

    Returns
    -------
    states : tuple of str
        Those that it names.
    problems : list of Problem
        All of them; a parameter that nothing depends on is one, since it is likely misspelt.
    """
    from chaosdrill.model.definition import make_system
    from chaosdrill.model.definition_reading import read_definition

    reading, faults = read_definition(definition, parameters)
    problems = [Problem((*AT, *fault.path), fault.message) for fault in faults]
    if effects:
        problems.append(Problem(("system", "effects"), "a definition is not assembled from effects; leave them out"))
    if not faults:
        unused = [name for name in parameters if name not in reading.used]
        known = sorted(reading.used & parameters.keys())
        problems += [
            Problem(("system", "parameters", name), f"no expression of the definition names it; {remedy(name, known)}")
            for name in unused
        ]
        numbers = [value for value in parameters.values() if isinstance(value, int | float)]
        if len(numbers) == len(parameters):
            try:
                make_system(reading, parameters, {})
            except ChaosdrillError as fault:
                problems.append(Problem(AT, str(fault)))
    given = definition.get("states")
    states = [name for name in given if isinstance(name, str)] if isinstance(given, list) else []
    return tuple(states), problems
