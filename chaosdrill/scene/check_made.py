"""What a scene makes of a system: of two fields and a surface, with drives, noise, over half of its motion.

All use the grammar of definitions and the functions of the Python interface; every fault keeps its line.
"""

from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields
from typing import Any

from chaosdrill.errors import ChaosdrillError, SettingsError
from chaosdrill.model.tables import UNNAMED
from chaosdrill.names import names_in, remedy
from chaosdrill.scene.tuning import TUNING
from chaosdrill.settings import Faults, KeyPath

SIDES = ("above", "below")
SLIDING = "sliding"
SHARED = ("name", "description", "states", "time", "period", "quadratures", "bounds", "labels")
OF_FILIPPOV = (*SHARED, "surface", *SIDES)
OF_DRIVE = ("pieces", "table", "period")


def as_definition(table: Mapping[str, Any]) -> dict[str, Any]:
    """Two fields and a surface as a definition of two modes, by which every fault in them is found."""
    found = {key: table[key] for key in SHARED if key in table}
    found["modes"] = {side: table[side] for side in SIDES if side in table}
    if "above" in table:
        # an integrand may have a value of its own there
        found["modes"][SLIDING] = table["above"]
    surface = table.get("surface")
    expression = next(iter(surface.values()), None) if isinstance(surface, Mapping) else surface
    if expression is not None and set(SIDES) <= table.keys():
        named = {"name": "surface", "source": "above", "target": "below", "guard": expression, "direction": -1}
        found["transitions"] = [named]
    return found


def placed(path: KeyPath) -> KeyPath | None:
    """Position in the table of a fault of that definition; None for a fault that also occurs elsewhere."""
    match path:
        case ("modes", side, *rest):
            return None if side == SLIDING else (side, *rest)
        case ("transitions", *_):
            return ("surface",)
    return path


def filippov_faults(table: Mapping[str, Any]) -> Faults:
    """What is wrong with the keys of the table."""
    for key in table:
        if key not in OF_FILIPPOV:
            yield (key,), f"unknown key; {remedy(key, OF_FILIPPOV)}"
    for key in ("surface", *SIDES):
        if key not in table:
            yield (key,), f"missing; expected surface, {' and '.join(SIDES)}"
    surface = table.get("surface")
    if isinstance(surface, Mapping) and len(surface) != 1:
        yield ("surface",), f"expected an expression, or one name with its expression, received {len(surface)} names"


def filippov_system(table: Mapping[str, Any], parameters: Mapping[str, float], initial: Mapping[str, Any]) -> Any:
    """The system of a table without faults; raises `ChaosdrillError` if the system cannot be built, with the reason."""
    from chaosdrill.model.filippov import filippov
    from chaosdrill.model.parts import TIME
    from chaosdrill.model.text import read_open_text

    given: dict[str, Any] = {"name": UNNAMED, **table, "parameters": parameters, "initial": initial}
    if "time" not in given and TIME not in (*parameters, *names_in(table["states"])):
        texts = _texts({key: table[key] for key in ("surface", *SIDES, "quadratures") if key in table})
        if any(symbol.name == TIME for text in texts for symbol in read_open_text(text).free_symbols):
            given["time"] = TIME
    return filippov(**given)


def begun_by(table: Mapping[str, Any]) -> tuple[str, ...]:
    """Names of the states that two fields may start from: their own, and that which is made of the surface."""
    surface = table["surface"]
    return (*names_in(table["states"]), *(map(str, surface) if isinstance(surface, Mapping) else ()))


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, Mapping):
        for one in value.values():
            yield from _texts(one)
    elif isinstance(value, str):
        yield value


def too_large(definition: Any) -> Faults:
    """Fields that would take too long to combine: those of many operations, and with powers of long sums."""
    from chaosdrill.model.definition import operations

    for mode, field in definition.modes.items():
        if (count := operations(definition, mode)) > TUNING.sliding_operations:
            what = "products, powers and functions (these count twice)"
            yield ("modes", mode), f"has {count} {what}; at most {TUNING.sliding_operations} are combined"
        for state, rate in field.items():
            yield from _expanded(("modes", mode, str(state)), rate)
    for index, transition in enumerate(definition.transitions):
        yield from _expanded(("transitions", index, "guard"), transition.guard)


def _expanded(path: KeyPath, expression: Any) -> Faults:
    import sympy

    for power in expression.atoms(sympy.Pow):
        if power.base.is_Add and power.exp.is_Integer and power.exp > 1:
            nested = any(one.base.is_Add for one in power.base.atoms(sympy.Pow))
            if nested or power.exp > TUNING.sliding_power:
                what = f"a power of a sum beyond {TUNING.sliding_power}, or within another one, which would be expanded"
                yield path, f"takes {what}"


def drive_faults(drive: Any, names: Mapping[str, Any], used: set[str]) -> Faults:
    """Faults of one drive; the parameters in its expressions are added to ``used``.

    ``drive``: the value in the scene. ``names``: symbols of states, parameters and time.
    """
    from chaosdrill.model.drives import PHASE, SHAPES

    if not isinstance(drive, Mapping):
        yield (), f"expected a table with pieces or a table of values, received {drive!r:.60}"
        return
    for key in drive:
        if key not in OF_DRIVE:
            yield (key,), f"unknown key; {remedy(key, OF_DRIVE)}"
    if ("pieces" in drive) == ("table" in drive):
        yield (), "give pieces or a table of values, one of them"
    if "period" in drive:
        yield from _read(("period",), drive["period"], names, used)
    pieces = drive.get("pieces")
    if isinstance(pieces, str) and pieces not in SHAPES:
        yield ("pieces",), f"unknown drive {pieces!r:.60}; {remedy(pieces, SHAPES)}"
    elif isinstance(pieces, Mapping):
        yield from _long(("pieces",), pieces)
        for start, shape in list(pieces.items())[: TUNING.pieces]:
            yield from _read(("pieces", start), start, names, used)
            yield from _read(("pieces", start), shape, {**names, PHASE.name: PHASE}, used)
    elif pieces is not None and not isinstance(pieces, str):
        yield ("pieces",), f"expected one of {list(SHAPES)} or a table of phases, received {pieces!r:.60}"
    values = drive.get("table")
    if isinstance(values, list | Mapping):
        yield from _long(("table",), values)
        listed = list(enumerate(values) if isinstance(values, list) else values.items())
        for place, value in listed[: TUNING.pieces]:
            if isinstance(values, Mapping):
                yield from _read(("table", place), place, {}, used)
            if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < float("inf"):
                yield ("table", place), f"expected a finite number, received {value!r:.60}{_pointed(value)}"
    elif values is not None:
        yield ("table",), f"expected a list of numbers, or a table of phases, received {values!r:.60}"


def _long(path: KeyPath, values: Any) -> Faults:
    if len(values) > TUNING.pieces:
        yield path, f"has {len(values)} pieces; at most {TUNING.pieces} can be modes of a system"


def _pointed(value: Any) -> str:
    """What to do where a phase became two keys of TOML."""
    return "; a phase with a point stands in quotes" if isinstance(value, Mapping) else ""


def _read(path: KeyPath, value: Any, names: Mapping[str, Any], used: set[str]) -> Faults:
    """Faults of an expression, with the names that it holds."""
    from chaosdrill.model.grammar import ExpressionError
    from chaosdrill.model.text import read_text

    if isinstance(value, int | float) and not isinstance(value, bool):
        value = repr(value)
    if not isinstance(value, str):
        yield path, f"expected an expression in quotes, received {value!r:.60}{_pointed(value)}"
        return
    try:
        used |= {symbol.name for symbol in read_text(value, names).free_symbols}
    except ExpressionError as fault:
        yield path, str(fault)


def noise_faults(noise: Mapping[str, Any], known: Mapping[str, Any]) -> Faults:
    """Faults of a table of noise; ``known`` are the parameters of the system."""
    from chaosdrill.model.noise import DISTRIBUTIONS

    seed = _seed(noise)
    if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed < 2**53:
        yield ("seed",), f"must be a whole number from 0 to 2**53 - 1, received {seed!r:.60}"
    drawn = {name: one for name, one in noise.items() if name != "seed" or isinstance(one, Mapping)}
    if not drawn:
        yield (), "names no parameter; give one, as in [system.noise.e]"
    for name, one in drawn.items():
        if name not in known:
            yield (name,), f"there is no parameter {name!r:.60} to draw; {remedy(name, known)}"
        elif not isinstance(one, Mapping):
            yield (name,), f"expected a table with distribution and at, received {one!r:.60}"
        elif (title := one.get("distribution")) not in DISTRIBUTIONS:
            told = "missing" if title is None else f"unknown distribution {title!r:.60}"
            yield (name, "distribution"), f"{told}; {remedy(str(title), DISTRIBUTIONS)}"
        else:
            wanted = {field.name: field.default is MISSING for field in fields(DISTRIBUTIONS[title])}
            keys = (*wanted, "distribution", "at")
            yield from (((name, key), f"unknown key; {remedy(key, keys)}") for key in one if key not in keys)
            missing = [key for key, needed in wanted.items() if needed and key not in one]
            yield from (((name, key), f"missing; {title} has {', '.join(wanted)}") for key in missing)
            if not missing:
                try:
                    distribution_of(one)
                except SettingsError as fault:
                    yield (name,), str(fault)


def distribution_of(table: Mapping[str, Any]) -> Any:
    """The distribution of a table of noise; raises `SettingsError` for impossible numbers."""
    from chaosdrill.model.noise import DISTRIBUTIONS

    made = DISTRIBUTIONS[table["distribution"]]
    return made(**{field.name: table[field.name] for field in fields(made) if field.name in table})


def noise_parameters(noise: Mapping[str, Any]) -> dict[str, float]:
    """Parameters that replace those drawn by a valid table of noise."""
    if not noise:
        return {}
    from chaosdrill.model.noise import added_parameters

    return added_parameters(distributions_of(noise), _seed(noise))


def distributions_of(noise: Mapping[str, Any]) -> dict[str, Any]:
    """The distributions of a valid table of noise, by parameter."""
    return {name: distribution_of(one) for name, one in noise.items() if isinstance(one, Mapping)}


def _seed(noise: Mapping[str, Any]) -> int:
    # a parameter of this name may be drawn
    seed = noise.get("seed", 0)
    return 0 if isinstance(seed, Mapping) else seed


def noisy_system(system: Any, noise: Mapping[str, Any]) -> Any:
    """The system with its noise."""
    if not noise:
        return system
    distributions = distributions_of(noise)
    at = {name: noise[name]["at"] for name in distributions if "at" in noise[name]}
    return system.with_noise(distributions, at=at, seed=_seed(noise))


def driven_system(system: Any, drives: Mapping[str, Mapping[str, Any]]) -> Any:
    """The system with its drives; raises `DriveFault` with the name of an impossible one."""
    for name, drive in drives.items():
        from chaosdrill.model.drives import driven

        try:
            system = driven(system, name, **drive)
        except ChaosdrillError as fault:
            raise DriveFault(name, str(fault)) from fault
    return system


def halved_system(system: Any, symmetry: Mapping[str, str]) -> Any:
    """The system over half of its motion, as by `chaosdrill.halved`; itself without a symmetry."""
    if not symmetry:
        return system
    from chaosdrill.model.halved import halved

    return halved(system, symmetry)


class DriveFault(ChaosdrillError):
    """A drive that is impossible for the system."""

    def __init__(self, drive: str, message: str) -> None:
        super().__init__(message)
        self.drive = drive
