"""Check a scene: the names and numbers of its system, and whether its analyses fit."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path
from typing import Any

from chaosdrill import systems
from chaosdrill.analysis.base import Analysis, NumericsSettings
from chaosdrill.analysis.registry import function
from chaosdrill.analysis.starting_states import Start
from chaosdrill.annotations import Dataset
from chaosdrill.declared import ANALYSES, unfit
from chaosdrill.errors import ChaosdrillError, ModelError
from chaosdrill.model import HybridSystem
from chaosdrill.model.tuning import TUNING
from chaosdrill.names import remedy
from chaosdrill.scene import check_made
from chaosdrill.scene.defined import Recipe, checked_before, sliding, sliding_before
from chaosdrill.scene.lines import Problem, problems_of
from chaosdrill.settings import KeyPath, Known, Number, Settings, TableOf, Text, setting
from chaosdrill.systems.drill.effects import LIMITS
from chaosdrill.systems.drill.si import IN_SI, ReadSI, read_si

_GROUP = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")


@dataclass(frozen=True, kw_only=True)
class Document(Settings):
    """The tables of a scene; the inner ones are checked one by one, so that no fault hides another."""

    title: str | None = setting(Text(), None)
    system: dict[str, Any] = setting(TableOf(hint=", as [system] with model = 'lorenz'; chaosdrill list systems"))
    numerics: dict[str, Any] | None = setting(TableOf(), None)
    analysis: dict[str, dict[str, Any]] | None = setting(
        TableOf(TableOf(hint=", as [analysis.spectrum] with kind = 'lyapunov-spectrum'")), None
    )


@dataclass(frozen=True, kw_only=True)
class SystemTable(Settings):
    """The table ``system``, before its names are looked up."""

    model: str | None = setting(Text(), None)
    definition: dict[str, Any] | None = setting(TableOf(), None)
    filippov: dict[str, Any] | None = setting(TableOf(), None)
    map: dict[str, Any] | None = setting(TableOf(), None)
    drives: dict[str, dict[str, Any]] | None = setting(TableOf(), None)
    noise: dict[str, Any] | None = setting(TableOf(), None)
    symmetry: dict[str, str] | None = setting(TableOf(Text()), None)
    effects: dict[str, str] | None = setting(TableOf(Text()), None)
    parameters: dict[str, float] | None = setting(TableOf(Number()), None)
    initial: dict[str, float | str] | None = setting(Start(), None)
    si: dict[str, Any] | None = setting(TableOf(), None)


@dataclass
class CheckedSystem(Known):
    """Information on the system before it is built.

    Either ``model`` names a system of the library, or ``definition`` holds one, whose modes may have been made from two
    fields. ``used`` are parameters that only its ``drives`` name.
    """

    model: str = ""
    definition: dict[str, Any] | None = None
    drives: dict[str, Any] = field(default_factory=dict)
    noise: dict[str, Any] = field(default_factory=dict)
    symmetry: dict[str, str] = field(default_factory=dict)
    used: set[str] = field(default_factory=set)
    effects: dict[str, str] = field(default_factory=dict)
    initial: dict[str, Any] = field(default_factory=dict)
    si: ReadSI = field(default_factory=ReadSI)
    problems: list[Problem] = field(default_factory=list)

    def unused(self, parameter: str) -> str:
        if self.model not in systems.REGISTRY or not systems.REGISTRY[self.model].effects:
            return ""
        return systems.unused(self.model, parameter, self.effects)


def check_document(raw: Mapping[str, Any], system: CheckedSystem) -> list[Problem]:
    """Check which tables the file has, and whether anything stands outside of the table to which it belongs."""
    inner = {
        "numerics": NumericsSettings.values(),
        "system.initial": system.states or (),
        "system.parameters": system.known or (),
        "system": SystemTable.values(),
    }
    misplaced: dict[KeyPath, str] = {
        (key,): f"belongs in [{table}], as {table}.{key}"
        for table, names in inner.items()
        for key in raw.keys() - Document.values().keys()
        if key in names
    }
    return [Problem(path, misplaced.get(path, told)) for path, told in Document.faults(raw, also=())]


def check_system(raw: Mapping[str, Any]) -> CheckedSystem:
    """Check the table ``system`` of the file."""
    problems = problems_of(SystemTable.faults(raw, also=()), ("system",))
    sound = not problems
    checked = CheckedSystem(problems=problems)
    _check_equations(checked, raw)
    _check_names(checked, raw)
    _check_numbers(checked, raw)
    if sound:
        arguments = SystemTable.arguments(raw)
        checked.parameters = {**checked.parameters, **arguments.get("parameters", {})}
        for name in ("initial", "drives", "noise", "symmetry"):
            setattr(checked, name, arguments.get(name, {}))
        if "filippov" in raw and not problems:
            try:
                made, checked.definition = sliding(raw["filippov"], checked.parameters, checked.initial)
                checked.initial, checked.states = made.start, made.state_names
            except ChaosdrillError as fault:
                problems.append(Problem(("system", "filippov"), str(fault)))
    if checked.known is not None:
        # a driven parameter is no longer a parameter
        checked.known = {name: value for name, value in checked.known.items() if name not in table_in(raw, "drives")}
        _check_noise(checked, table_in(raw, "noise"))
    return checked


def _check_equations(checked: CheckedSystem, raw: Mapping[str, Any]) -> None:
    """Look the system up, or check the equations that the scene writes, in one of the ways that there are."""
    problems = checked.problems
    ways = [key for key in ("model", "definition", "map", "filippov") if key in raw]
    if not ways:
        written = "[system.definition], [system.map] or [system.filippov]"
        problems.append(Problem(("system", "model"), f"missing; name a built-in system, or write one as {written}"))
    elif len(ways) > 1:
        both, too_many = "both" if len(ways) == 2 else "all", ("one", "two", "three")[len(ways) - 2]
        text = f"{' and '.join(ways)} are {both} given; leave {too_many} of them out"
        problems.append(Problem(("system", ways[1]), text))
    elif isinstance(raw.get("model"), str):
        checked.model = raw["model"]
        _look_up(checked, table_in(raw, "effects"))
        if _made_before(checked, raw) is None:
            _check_drives(checked, table_in(raw, "drives"))
    elif isinstance(raw.get(ways[0]), Mapping):
        checked.known = dict(table_in(raw, "parameters"))
        if ways[0] == "filippov":
            _check_filippov(checked, raw)
        else:
            _check_written(checked, raw, ways[0])
        if table_in(raw, "effects"):
            told = "a definition is not assembled from effects; leave them out"
            problems.append(Problem(("system", "effects"), told))


def _check_names(checked: CheckedSystem, raw: Mapping[str, Any]) -> None:
    """Check that there are the parameters and states that are named."""
    if checked.known is not None:
        for name in table_in(raw, "parameters"):
            if name not in checked.known:
                place = ("system", "parameters", name)
                fault = checked.unused(name) or f"unknown parameter; {remedy(name, checked.known)}"
                checked.problems.append(Problem(place, fault))
    if checked.states is not None:
        checked.problems += problems_of(Start().misfits(table_in(raw, "initial"), checked), ("system", "initial"))
        checked.problems += [
            Problem(("system", "symmetry", name), f"unknown state; {remedy(name, checked.states)}")
            for name in table_in(raw, "symmetry")
            if name not in checked.states
        ]


def _check_numbers(checked: CheckedSystem, raw: Mapping[str, Any]) -> None:
    """Read the quantities in SI units, and check all numbers against the limits of the parameters."""
    given = dict(table_in(raw, "parameters"))
    if table_in(raw, "si") and checked.known is not None:
        if checked.model in IN_SI:
            checked.si, faults = read_si(raw["si"], given, checked.known)
            beyond = check_limits(checked, checked.si.parameters, ("system", "si"))
            # a parameter made of several quantities has no line of its own
            checked.problems += problems_of(faults, ()) + [replace(fault, path=("system", "si")) for fault in beyond]
            checked.parameters = checked.si.parameters
        else:
            checked.problems.append(Problem(("system", "si"), f"only {' and '.join(IN_SI)} can be given in SI units"))
    checked.problems += check_limits(checked, given, ("system", "parameters"))


def _check_noise(checked: CheckedSystem, noise: Mapping[str, Any]) -> None:
    """Check the noise of a system whose parameters are known, and put those of its distributions in their place."""
    if not noise or checked.known is None:
        return
    if faults := problems_of(check_made.noise_faults(noise, checked.known), ("system", "noise")):
        checked.problems += faults
        # what they would be called is not known
        checked.known = checked.states = None
        return
    from chaosdrill.model.noise import added_limits, names_of

    drawn = check_made.distributions_of(noise)
    checked.limits = {**checked.limits, **added_limits(drawn, checked.limits)}
    known = {name: value for name, value in checked.known.items() if name not in drawn}
    checked.known = {**known, **check_made.noise_parameters(noise)}
    if checked.states is not None:
        checked.states = (*checked.states, *(state for name in drawn for state in names_of(name)))
        checked.drawn = 2 * len(drawn)


def check_limits(checked: CheckedSystem, values: Mapping[str, Any], at: tuple[str | int, ...]) -> list[Problem]:
    """Check numbers against the limits of the model's parameters."""
    faults = ((name, checked.refuses(name, value)) for name, value in values.items())
    return [Problem((*at, name), fault) for name, fault in faults if fault]


def _check_written(checked: CheckedSystem, raw: Mapping[str, Any], key: str) -> None:
    """Check the definition of a system or a map, which has images."""
    checked.definition = {**({"images": None} if key == "map" else {}), **raw[key]}
    drives = table_in(raw, "drives")
    if drives or table_in(raw, "symmetry"):
        before = _made_before(checked, raw)
    else:
        before = checked_before(checked.definition, checked.known or {})
    if before is not None:
        # what was run before has no faults
        checked.states = before.state_names
    else:
        _check_drives(checked, drives if key == "definition" else {})
        _check_definition(checked, key, driven=bool(drives))
    if drives and key == "map":
        from chaosdrill.model.drives import UNDRIVEN

        checked.problems.append(Problem(("system", "drives"), UNDRIVEN))


def _check_filippov(checked: CheckedSystem, raw: Mapping[str, Any]) -> None:
    """Check two fields and a surface by the check of definitions."""
    place, table = ("system", "filippov"), raw["filippov"]
    if _slid_before(checked, raw):
        checked.states = check_made.begun_by(table)
        return
    from chaosdrill.model.reading import Reader

    checked.definition = check_made.as_definition(table)
    _check_drives(checked, table_in(raw, "drives"))
    checked.problems += problems_of(check_made.filippov_faults(table), place)
    if checked.problems:
        checked.states = None
        return
    before = len(checked.problems)
    _check_definition(checked)
    found = Reader(checked.known).read(checked.definition)
    faults = [*checked.problems[before:]]
    if found is not None:
        faults += problems_of(check_made.too_large(found), ("system", "definition"))
    del checked.problems[before:]
    for fault in faults:
        if fault.path[:2] != ("system", "definition"):
            checked.problems.append(fault)
        elif (inner := check_made.placed(fault.path[2:])) is not None:
            checked.problems.append(replace(fault, path=(*place, *inner)))
    if checked.states is not None:
        checked.states = check_made.begun_by(table)


def _made_before(checked: CheckedSystem, raw: Mapping[str, Any]) -> HybridSystem | None:
    """The system with drives, or over half of its motion, of a scene that was run before, and so has no faults."""
    drives, symmetry, parameters = (table_in(raw, name) for name in ("drives", "symmetry", "parameters"))
    if not (drives or symmetry) or "noise" in raw or checked.known is None:
        return None
    if "si" in raw:
        if checked.model not in IN_SI:
            return None
        made, faults = read_si(raw["si"], dict(parameters), checked.known)
        if [*faults]:
            return None
        parameters = {**made.parameters, **parameters}
    tables = (checked.definition, checked.effects, parameters, table_in(raw, "initial"))
    return Recipe(checked.model, *tables, drives, symmetry).before()


def _slid_before(checked: CheckedSystem, raw: Mapping[str, Any]) -> bool:
    """Whether two fields and a surface, and their drives, were run before, and so have no faults."""
    parameters, drives = table_in(raw, "parameters"), table_in(raw, "drives")
    found = sliding_before(raw["filippov"], parameters, table_in(raw, "initial"))
    if found is None or not drives:
        return found is not None
    tables = (found.shared["definition"], checked.effects, parameters, found.start, drives)
    one = Recipe("", *tables, table_in(raw, "symmetry"))
    return "noise" not in raw and one.before() is not None


def _check_drives(checked: CheckedSystem, drives: Mapping[str, Any]) -> None:
    """Check the drives of a system whose parameters are known."""
    if not drives or checked.known is None:
        return
    import sympy

    from chaosdrill.model.reading import Reader

    definition, states = checked.definition, checked.states
    clock: Any = "t"
    if definition is not None:
        reader = Reader(checked.known)
        reader.read(definition)
        states, clock = reader.states, definition.get("time") or clock
    listed = [*(states or ()), *checked.known, *([clock] if isinstance(clock, str) else [])]
    names = {name: sympy.Symbol(name, real=True) for name in listed}
    for name, drive in drives.items():
        place = ("system", "drives", name)
        if name not in checked.known:
            told = f"there is no parameter {name!r:.60} to drive; {remedy(name, checked.known)}"
            checked.problems.append(Problem(place, told))
        else:
            checked.problems += problems_of(check_made.drive_faults(drive, names, checked.used), place)


def _check_definition(checked: CheckedSystem, key: str = "definition", *, driven: bool = True) -> None:
    """Check a definition, in the table of this name, with the parameters that stand beside it.

    Where none of these is ``driven``, guards hold a state or time. The rules are those of Python; in addition, a
    parameter on which nothing depends is likely misspelt.
    """
    from chaosdrill.model.definition import operations, reader_of

    definition, parameters = checked.definition or {}, checked.known or {}
    reader = reader_of(definition, parameters)
    found = reader.read(definition)
    checked.states = reader.states
    faults = [Problem(path if path[:1] == ("parameters",) else (key, *path), told) for path, told in reader.faults]
    of_pi = [
        Problem(place, "'pi' is the number 3.14159... in every expression; choose another name")
        for place, names in (
            (("parameters", "pi"), parameters),
            ((key, "states"), reader.states or ()),
            ((key, "time"), (definition.get("time"),)),
        )
        if "pi" in names
    ]
    if of_pi:
        # whatever names it means the number or that, and may be no fault at all
        faults = of_pi
    elif found is not None:
        known = sorted(reader.used & parameters.keys())
        faults += [
            Problem(("parameters", name), f"not used in the {key}; {remedy(name, known)}")
            for name in parameters
            if name not in {*reader.used, *checked.used}
        ]
        faults += [
            Problem((key, "quadratures", name), f"has a name that {reason}; rename it, as in 'the_integral'")
            for name in found.quadratures
            if (reason := unfit(name))
        ]
        faults += [Problem((key, "transitions", k, "guard"), told) for k, told in found.unmoved() if not driven]
        faults += [
            Problem(
                (key, "modes", mode),
                f"has {count} products, powers and functions (these count twice) in rates, quadratures and guards; at "
                f"most {TUNING.operations} can be compiled in reasonable time: use fewer, such as powers of one sine "
                "in place of sines of multiples, or leave out terms that hardly matter",
            )
            for mode in found.modes
            if (count := operations(found, mode)) > TUNING.operations
        ]
    checked.problems += [replace(fault, path=("system", *fault.path)) for fault in faults]


def _look_up(checked: CheckedSystem, effects: Mapping[str, Any]) -> None:
    """Find the model's parameters and states; with an invalid effect, all that it could have."""
    entry = systems.REGISTRY.get(checked.model)
    if entry is None:
        fault = f"unknown model {checked.model!r:.60}; {remedy(checked.model, systems.REGISTRY)}"
        checked.problems.append(Problem(("system", "model"), fault))
        return
    faults: list[Problem] = []
    texts = {effect: option for effect, option in effects.items() if isinstance(option, str)}
    for effect, option in texts.items():
        place = ("system", "effects", effect)
        if not entry.effects:
            faults.append(Problem(place, f"{checked.model} is not assembled from effects; leave them out"))
        elif effect not in systems.EFFECTS:
            faults.append(Problem(place, f"unknown effect; {remedy(effect, systems.EFFECTS)}"))
        elif option not in systems.EFFECTS[effect]:
            faults.append(Problem(place, f"unknown option {option!r:.60}; {remedy(option, systems.EFFECTS[effect])}"))
        else:
            checked.effects[effect] = option
    chosen = checked.effects if entry.effects else None
    certain = not faults and len(texts) == len(effects)
    try:
        checked.known = systems.parameters(checked.model, chosen)
        checked.states = systems.states(checked.model, chosen)
        checked.limits = systems.limits(checked.model, chosen)
    except ModelError as fault:
        if certain:
            faults.append(Problem(("system", "effects"), str(fault)))
        certain = False
    if entry.effects and not certain:
        checked.known, checked.states = _widest(checked.model)
        checked.limits = LIMITS
    checked.problems += faults


def _widest(model: str) -> tuple[dict[str, float], tuple[str, ...]]:
    """Every parameter and state that some choice of effects has."""
    known: dict[str, float] = {}
    states: dict[str, None] = {}
    for options in product(*systems.EFFECTS.values()):
        chosen = dict(zip(systems.EFFECTS, options, strict=True))
        try:
            known |= systems.parameters(model, chosen)
            states |= dict.fromkeys(systems.states(model, chosen))
        except ModelError:
            continue
    return known, tuple(states)


def table_in(raw: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """A table of the file; empty if it is missing or something else."""
    found = raw.get(name)
    return found if isinstance(found, Mapping) else {}


@dataclass(frozen=True)
class Asked:
    """An analysis requested by a scene, with its table.

    A setting that the scene leaves out is not passed on, so that each default is defined once.
    """

    entry: Analysis
    table: Mapping[str, Any]

    @property
    def kind(self) -> str:
        """Kind of the analysis."""
        return self.entry.kind

    @property
    def parallel(self) -> bool:
        """Whether it has many points, which several workers can share."""
        return self.entry.settings.shared(self.table)

    def keywords(self) -> dict[str, Any]:
        """Arguments of the analysis function that the scene gives."""
        return self.entry.settings.arguments(self.table)

    def get(self, name: str) -> Any:
        """A setting as the scene gives it, or its default; None where the analysis has no such setting."""
        return self.table.get(name, self.entry.settings.default(name))

    def run(
        self,
        system: Any,
        numerics: Mapping[str, Any],
        *,
        workers: int = 1,
        scheduler: str | None = None,
        store: Path | None = None,
        progress: Callable[..., None] | None = None,
    ) -> Dataset:
        """Run the analysis, with at most as many workers as points; ``store`` keeps finished chunks."""
        keywords = self.keywords()
        if self.parallel:
            keywords |= {"workers": workers, "scheduler": scheduler, "store": store}
        if not self.entry.settings.own_numerics:
            keywords |= numerics
        result: Dataset = function(self.entry.function)(system, **keywords, progress=progress)
        return result


def check_numerics(raw: Mapping[str, Any]) -> tuple[dict[str, Any], list[Problem]]:
    """The arguments that the table ``numerics`` gives, unless it has faults."""
    problems = problems_of(NumericsSettings.faults(raw, also=()), ("numerics",))
    return {} if problems else NumericsSettings.arguments(raw), problems


def check_analyses(raw: Mapping[str, Any], system: CheckedSystem) -> tuple[dict[str, Asked], list[Problem]]:
    """Check every table ``analysis.NAME``."""
    found: dict[str, Asked] = {}
    folders: dict[str, str] = {}
    problems: list[Problem] = []
    for name, table in raw.items():
        at: KeyPath = ("analysis", name)
        if not _GROUP.fullmatch(name):
            problems.append(Problem(at, "the name must consist of at most 64 letters, digits, '_', '.' and '-'"))
        # parts of a run lie in folders of these names, and some systems know no case there
        if (other := folders.setdefault(name.casefold(), name)) != name:
            problems.append(Problem(at, f"differs from {other!r} by case alone; rename one of them"))
        if not isinstance(table, Mapping):
            continue
        kind = table.get("kind")
        if not isinstance(kind, str) or kind not in ANALYSES:
            fault = "missing" if kind is None else f"unknown kind {kind!r:.60}"
            problems.append(Problem((*at, "kind"), f"{fault}; {remedy(str(kind), ANALYSES)}"))
            continue
        problems += problems_of(ANALYSES[kind].settings.faults(table, system, also=("kind",)), at)
        found[name] = Asked(ANALYSES[kind], {key: value for key, value in table.items() if key != "kind"})
    return found, problems
