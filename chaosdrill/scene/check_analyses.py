"""Whether the analyses that a scene asks for exist and fit its system."""

import re
from collections.abc import Mapping
from typing import Any

from chaosdrill.dataset.schema import RESERVED
from chaosdrill.names import remedy
from chaosdrill.scene.check_system import CheckedSystem, check_limits, check_state
from chaosdrill.scene.kinds import KINDS, Analysis
from chaosdrill.scene.lines import Path
from chaosdrill.scene.numerics import Numerics
from chaosdrill.scene.problems import Problem
from chaosdrill.scene.strict import validate

_RANDOM = ("count", "seed", "mode")

_GROUP = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")


def check_numerics(raw: Mapping[str, Any]) -> tuple[Numerics | None, list[Problem]]:
    """Check the table ``numerics``."""
    from chaosdrill.analysis.registry import FIXED_STEP, METHODS

    numerics, problems = validate(Numerics, raw, ("numerics",))
    method = raw.get("method", "taylor")
    if isinstance(method, str):
        if method not in METHODS:
            fault = f"unknown method {method!r:.60}; {remedy(method, METHODS)}"
            problems.append(Problem(("numerics", "method"), fault))
        elif "steps" in raw and method not in FIXED_STEP:
            fault = f"{method} chooses its own steps; leave it out, or choose {' or '.join(FIXED_STEP)}"
            problems.append(Problem(("numerics", "steps"), fault))
    return numerics, problems


def check_analyses(raw: Mapping[str, Any], system: CheckedSystem) -> tuple[dict[str, Analysis], list[Problem]]:
    """Check every table ``analysis.NAME``."""
    analyses: dict[str, Analysis] = {}
    problems: list[Problem] = []
    for name, table in raw.items():
        at: Path = ("analysis", name)
        if not _GROUP.fullmatch(name):
            problems.append(Problem(at, "the name is to be letters, digits, '_', '.' and '-', at most 64"))
        if not isinstance(table, Mapping):
            continue
        kind = table.get("kind")
        if not isinstance(kind, str) or kind not in KINDS:
            fault = "missing" if kind is None else f"unknown kind {kind!r:.60}"
            problems.append(Problem((*at, "kind"), f"{fault}; {remedy(str(kind), KINDS)}"))
            continue
        analysis, faults = validate(KINDS[kind], table, at)
        problems += (
            faults + _check_sweep(table, system, at) + _check_states(table, system, at) + _check_methods(table, at)
        )
        if analysis is not None:
            analyses[name] = analysis
    return analyses, problems


def _check_methods(table: Mapping[str, Any], at: Path) -> list[Problem]:
    """Methods are to exist, and there are as many counts of steps as tolerances."""
    from chaosdrill.analysis.registry import METHODS

    methods, tolerances, steps = (table.get(key) for key in ("methods", "tolerances", "steps"))
    problems = [
        Problem((*at, "methods", index), f"unknown method {name!r:.60}; {remedy(name, METHODS)}")
        for index, name in enumerate(methods if isinstance(methods, list) else [])
        if isinstance(name, str) and name not in METHODS
    ]
    if isinstance(steps, list) and not (isinstance(tolerances, list) and len(steps) == len(tolerances)):
        problems.append(Problem((*at, "steps"), "give tolerances too, as many as there are steps, one for each"))
    return problems


def _check_sweep(table: Mapping[str, Any], system: CheckedSystem, at: Path) -> list[Problem]:
    """The swept parameter is to exist, and all of its values are to be possible."""
    sweep = table.get("sweep")
    if not isinstance(sweep, Mapping) or system.known is None:
        return []
    problems = []
    for name, values in sweep.items():
        place = (*at, "sweep", name)
        if name not in system.known:
            problems.append(Problem(place, f"unknown parameter; {remedy(name, system.known)}"))
            continue
        if name in RESERVED:
            problems.append(Problem(place, "is the name of a result too, and cannot be swept; rename the parameter"))
        ends = [values.get("start"), values.get("stop")] if isinstance(values, Mapping) else values
        for value in ends if isinstance(ends, list) else []:
            faults = check_limits(system.model, {name: value}, (*at, "sweep"))
            problems += faults
            if faults:
                break
        if isinstance(values, Mapping):
            problems += _check_start(table, name, ends, system, place)
    return problems


def _check_start(
    table: Mapping[str, Any], name: str, ends: list[Any], system: CheckedSystem, place: Path
) -> list[Problem]:
    """A branch starts at the system's own value of the parameter, which is to lie between the limits."""
    if table["kind"] != "continuation" or not all(isinstance(end, int | float) for end in ends):
        return []
    own = system.parameters.get(name, (system.known or {})[name])
    if not isinstance(own, int | float) or min(ends) == max(ends) or min(ends) <= own <= max(ends):
        return []
    fault = f"the branch starts where the system is, at {name} = {own:g}, which is not between start and stop"
    return [Problem(place, fault)]


def _check_states(table: Mapping[str, Any], system: CheckedSystem, at: Path) -> list[Problem]:
    """Seeds and grids are to name states, and there are no more exponents than states."""
    if system.states is None:
        return []
    problems = []
    seeds = table.get("seeds")
    for index, seed in enumerate(seeds if isinstance(seeds, list) else []):
        if isinstance(seed, Mapping):
            problems += check_state(seed, system.states, (*at, "seeds", index))
    random, grid = table.get("random"), table.get("grid")
    places = [("random", key) for key in random if key not in _RANDOM] if isinstance(random, Mapping) else []
    places += [("grid", key) for key in grid] if isinstance(grid, Mapping) else []
    problems += [
        Problem((*at, *place), f"unknown state; {remedy(place[1], system.states)}")
        for place in places
        if place[1] not in system.states
    ]
    problems += [
        Problem((*at, *place), "is the name of a result too, and cannot span a grid; rename the state")
        for place in places
        if place[0] == "grid" and place[1] in RESERVED
    ]
    exponents = table.get("exponents")
    if isinstance(exponents, int) and exponents > len(system.states):
        fault = f"the system has {len(system.states)} states and as many exponents, received {exponents}"
        problems.append(Problem((*at, "exponents"), fault))
    return problems
