"""Whether the table ``system.definition`` of a scene is a hybrid system."""

from collections.abc import Mapping
from sys import float_info
from typing import TYPE_CHECKING, Any

from chaosdrill.errors import ChaosdrillError
from chaosdrill.names import remedy
from chaosdrill.scene.lines import Path
from chaosdrill.scene.problems import Problem

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem

AT: Path = ("system", "definition")


def check_definition(
    definition: Mapping[str, Any], parameters: Mapping[str, Any], effects: Mapping[str, Any]
) -> tuple[tuple[str, ...] | None, list[Problem]]:
    """Check a definition with the parameters that stand beside it.

    Returns
    -------
    states : tuple of str, or None
        Those that it names; None if they cannot be told.
    problems : list of Problem
        All of them; a parameter that nothing depends on is one, since it is likely misspelt.
    """
    from chaosdrill.model.definition import make_system
    from chaosdrill.model.definition_reading import read_definition

    reading, faults = read_definition(definition, parameters)
    problems = [Problem((*AT, *fault.path), fault.message) for fault in faults]
    if effects:
        problems.append(Problem(("system", "effects"), "a definition is not assembled from effects; leave them out"))
    of_pi = [
        Problem(place, "'pi' is the number 3.14159... in every expression; choose another name")
        for place, names in ((("system", "parameters", "pi"), parameters), *_named(definition))
        if "pi" in names
    ]
    if of_pi:
        # whatever names it means the number or that, and may be no fault at all
        problems = of_pi
    if not faults and not of_pi:
        unused = [name for name in parameters if name not in reading.used]
        known = sorted(reading.used & parameters.keys())
        problems += [
            Problem(("system", "parameters", name), f"not used in the definition; {remedy(name, known)}")
            for name in unused
        ]
        # a value that is no double is told where all parameters are
        if all(_is_double(value) for value in parameters.values()):
            try:
                problems += _too_large(make_system(reading, parameters, {}))
            except ChaosdrillError as fault:
                problems.append(Problem((*AT, *_in_lists(getattr(fault, "place", ()), definition)), str(fault)))
    return tuple(s.name for s in reading.fields["states"]) if reading.fields else None, problems


def _too_large(system: "HybridSystem") -> list[Problem]:
    """Modes that would be compiled for minutes, or not at all."""
    from chaosdrill.model.size import MOST_OPERATIONS, operations

    counts = {mode: operations(system, mode) for mode in system.modes}
    return [
        Problem(
            (*AT, "modes", mode),
            f"has {count} products, powers and functions (these count twice) in rates, quadratures and guards; at most "
            f"{MOST_OPERATIONS} can be compiled in reasonable time: use fewer, such as powers of one sine in place of "
            "sines of multiples, or leave out terms that hardly matter",
        )
        for mode, count in counts.items()
        if count > MOST_OPERATIONS
    ]


def _named(definition: Mapping[str, Any]) -> list[tuple[Path, list[Any]]]:
    """What a definition gives names to, besides the parameters."""
    states, time = definition.get("states"), definition.get("time")
    return [((*AT, "states"), states if isinstance(states, list) else []), ((*AT, "time"), [time])]


def _is_double(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= float_info.max


def _in_lists(place: Path, definition: Mapping[str, Any]) -> Path:
    """A place in the file: transitions stand in a list there, and go by their names in a system."""
    if place[:1] != ("transitions",):
        return place
    names = [entry["name"] for entry in definition["transitions"]]
    return ("transitions", names.index(place[1]), *place[2:])
