"""Provenance: scene, equations and events; file, versions and attributes of the archive; citations.

A system is shown by its equations: in HTML for pages and notebooks, and in LaTeX. Names are always treated as text.
"""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from chaosdrill.annotations import Dataset, DataTree
from chaosdrill.archive.digest import unsealed
from chaosdrill.archive.read import altered_parts, groups_of
from chaosdrill.dataset.provenance import drawn
from chaosdrill.dataset.references import mapping
from chaosdrill.errors import ChaosdrillError
from chaosdrill.files import name_text
from chaosdrill.model import HybridSystem
from chaosdrill.model.grammar import PLAIN_NAME
from chaosdrill.reports.html import GREEK, NOTHING, Quantity, joined, known_columns, number, part, render, shown, table
from chaosdrill.reports.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.scene import Scene

_STYLE = Markup(
    "<style>.chaosdrill-system .equations {list-style: none; padding: 0; margin: 0}"
    ".chaosdrill-system .equations li {padding: 0.2em 0} .chaosdrill-system .equations math {display: inline math}"
    ".chaosdrill-system .scroll {overflow: auto hidden; padding-bottom: 0.2em}"
    ".chaosdrill-system :is(th, td, caption) {text-align: left; padding: 0 1em 0 0}"
    ".chaosdrill-system dd {display: inline; margin: 0}"
    ".chaosdrill-system dt {display: inline; opacity: 0.7} .chaosdrill-system dt::after {content: ': '}</style>"
)

_IN_MATHEMATICS = str.maketrans(
    {
        "\\": r"\backslash ",
        "^": r"\wedge ",
        "~": r"\sim ",
        " ": r"\ ",
        "-": r"\text{-}",
        **{letter: f"\\{letter}" for letter in "{}$%#&_"},
    }
)

_CROSSES = {1: r"\nearrow 0", -1: r"\searrow 0", 0: r"= 0"}


def scene_section(tree: DataTree) -> Markup:
    """The complete scene, or the definitions of an archive without one."""
    text = tree.attrs.get("scene")
    if not isinstance(text, str):
        return _defined(tree)
    from chaosdrill.scene import parse_scene

    try:
        told = _described(parse_scene(text, str(tree.attrs.get("scene_name", "scene.toml"))))
    except ChaosdrillError as fault:
        told = part("paragraph", f"The scene cannot be read by this version: {fault}", "fault") + _known(tree)
    return told + part("heading", "Scene file") + part("listing", text)


def _described(scene: "Scene") -> Markup:
    from chaosdrill.scene.describe import describe_scene

    told = describe_scene(scene)
    origin = {name: "scene" if p["given"] else "default" for name, p in told["parameters"].items()}
    scales = [(name.replace("_", " "), value) for name, value in told["si_scales"].items()]
    units = table("One dimensionless unit in SI units", ("quantity", "value"), scales)
    return system_part(scene.system, origin, told["simulated"], told["left_out"], units)


def system_part(
    system: HybridSystem,
    origin: Mapping[str, str] | None = None,
    simulated: Mapping[str, str] | None = None,
    left_out: Mapping[str, str] | None = None,
    units: Markup = NOTHING,
) -> Markup:
    """Numbers, equations and events of a system.

    ``origin``: origin of the value of each parameter; "the run" for those not named. ``simulated``, ``left_out``:
    effects, each with a line of description. ``units``: a table of units.
    """
    labels = system.labels
    states = [(name, part("formula", name), system.initial[name], labels.get(name, "")) for name in system.state_names]
    source = {} if origin is None else {name: origin.get(name, "the run") for name in system.parameters}
    parameters = [
        (name, part("formula", name), Quantity(number(value, 12)), source.get(name, ""), labels.get(name, ""))
        for name, value in system.parameters.items()
    ]
    same = {
        name: next(iter(rates.values())) for name, rates in system.quadratures.items() if len(set(rates.values())) == 1
    }
    integrals = {"": same} | {
        f", mode {mode}": {name: rates[mode] for name, rates in system.quadratures.items() if name not in same}
        for mode in system.modes
    }
    return render(
        "system.html",
        system=system,
        integrals=integrals,
        simulated=simulated,
        left_out=left_out,
        noise=drawn(system.noise),
        states=table("States", *known_columns(("state", "symbol", "initial value", "meaning"), states)),
        parameters=table("Parameters", *known_columns(("parameter", "symbol", "value", "from", "meaning"), parameters)),
        units=units,
    )


def _defined(tree: DataTree) -> Markup:
    """The systems of an archive without a scene, from the definitions in its groups."""
    found: dict[str, dict[str, Dataset]] = {}
    for path, group in groups_of(tree).items():
        if "definition" in group.attrs:
            found.setdefault(str(group.attrs["definition"]), {})[path.strip("/") or "result"] = group
    if not found:
        told = "The archive holds no scene and no definition of a system, so its equations are not known here."
        return part("paragraph", told) + _known(tree)
    parts = [part("paragraph", "The archive holds no scene; each analysis holds its system and its arguments.")]
    for groups in list(found.values())[: TUNING.systems]:
        try:
            parts.append(_with_numbers(groups))
        except ChaosdrillError as fault:
            parts.append(part("paragraph", f"The definition cannot be read: {fault}", "fault"))
    if (more := len(found) - TUNING.systems) > 0:
        parts.append(part("paragraph", f"{more} more systems are in the archive.", "left-out"))
    arguments = [
        (node.path.strip("/") or "result", name, json.dumps(value, ensure_ascii=False)[: TUNING.argument])
        for node in tree.subtree
        for name, value in mapping(node.attrs.get("settings")).items()
        if value is not None
    ]
    parts += [part("heading", "Arguments"), table("Arguments", ("group", "argument", "value"), arguments)]
    return joined(parts)


def _with_numbers(groups: Mapping[str, Dataset]) -> Markup:
    """A system with the numbers of its first analysis, and those of others that differ."""
    from chaosdrill.workflow.run_scene import system_of

    (first, dataset), *others = groups.items()
    system = system_of(dataset)
    numbers = {**system.parameters, **system.initial}
    changed = [
        (group, name, str(value))
        for group, other in others
        for name, value in (mapping(other.attrs.get("parameters")) | mapping(other.attrs.get("initial"))).items()
        if value != numbers.get(name)
    ]
    shown = system_part(system, dict.fromkeys(system.parameters, first))
    if not changed:
        return shown
    return shown + part("heading", "Other numbers") + table("Other numbers", ("group", "of", "value"), changed)


def _known(tree: DataTree) -> Markup:
    """Parameters with which the groups were made."""
    rows = [
        (str(node.attrs.get("system", "")), node.path.strip("/"), str(name), str(value))
        for node in tree.subtree
        for name, value in mapping(node.attrs.get("parameters")).items()
    ]
    return table("Parameters", ("system", "group", "parameter", "value"), dict.fromkeys(rows))


def origin_section(tree: DataTree, path: Path) -> Markup:
    """The file, the versions, and the attributes of the root and of every group."""
    with path.open("rb") as stream:
        digest = hashlib.file_digest(stream, "sha256").hexdigest()
    file = [("name", name_text(path.name)), ("size in bytes", str(path.stat().st_size)), ("SHA-256", digest)]
    changed = ", ".join(altered_parts(tree))
    whole = unsealed(tree) or "as they were written, by the digests of all variables"
    file.append(("values", f"altered since they were written: {changed}" if changed else whole))
    versions = [(str(name), str(version)) for name, version in mapping(tree.attrs.get("versions")).items()]
    parts = [
        part("paragraph", "The numbers of this page are those of this file.", "note"),
        table("The archive's file", ("what", "value"), file),
        table("Versions", ("library", "version"), versions),
    ]
    for node in tree.subtree:
        told = {str(name): value for name, value in node.attrs.items() if name not in ("scene", "versions")}
        rows = [(name, str(value.tolist() if hasattr(value, "tolist") else value)) for name, value in told.items()]
        caption = "Attributes of the archive" if node.path == "/" else f"Attributes of {node.path.strip('/')}"
        parts.append(table(caption, ("attribute", "value"), rows))
    return joined(parts)


def citations_section(tree: DataTree) -> Markup:
    """What to cite for the contents of the archive."""
    from chaosdrill.workflow.describe import references_in

    return joined(
        [
            part("paragraph", "This package, and the sources of the analyses, methods and systems in the archive."),
            part("bullets", [reference.text() for reference in references_in(tree)]),
            part("paragraph", "chaosdrill cite --bibtex prints them for BibTeX.", "note"),
        ]
    )


def system_html(system: HybridSystem) -> str | None:
    """The system as HTML with its equations in MathML, which loads nothing; None if it is too large."""
    if _is_long(system):
        return None
    return str(Markup('<div class="chaosdrill-system">{}{}</div>').format(_STYLE, system_part(system)))


def system_latex(system: HybridSystem) -> str | None:
    """The equations of the modes and the events in LaTeX, one display; None if it is too large.

    An event is its guard, with an arrow for the direction in which it passes zero, the condition of its outcome, and
    its reset.
    """
    if _is_long(system):
        return None
    if system.discrete:
        images = [rf"{_latex(x)} &\mapsto {_latex(image)}" for x, image in vars(system)["images"].items()]
        return "$$\\begin{aligned}\n" + " \\\\\n".join(images) + "\n\\end{aligned}$$"
    time = r"\mathrm{d}" + ("t" if system.time is None else _latex(system.time))
    lines = []
    for mode, field in system.modes.items():
        lines.append(rf"&{_roman(mode)}:")
        lines += [rf"\frac{{\mathrm{{d}}{_latex(state)}}}{{{time}}} &= {_latex(rate)}" for state, rate in field.items()]
    for event in system.transitions:
        sources = r",\ ".join(map(_roman, event.source))
        lines.append(rf"&{_roman(event.name)}:\ {sources} \to {_roman(event.target)}")
        conditions = {} if event.condition is None else event.conditions
        if len(set(conditions.values())) == 1:
            conditions = {"": next(iter(conditions.values()))}
        where = "".join(
            rf",\quad {_latex(condition)}" + (rf"\ ({_roman(mode)})" if mode else "")
            for mode, condition in conditions.items()
        )
        lines.append(rf"{_latex(event.guard)} &{_CROSSES[event.direction]}{where}")
        lines += [rf"{_latex(state)} &:= {_latex(value)}" for state, value in event.reset.items()]
    return "$$\\begin{aligned}\n" + " \\\\\n".join(lines) + "\n\\end{aligned}$$"


def _is_long(system: HybridSystem) -> bool:
    fields = len(system.modes) * len(system.state_names)
    events = sum(1 + len(event.reset) for event in system.transitions)
    return fields + events + len(system.quadratures) > TUNING.equations


def _latex(expression: Any) -> str:
    import sympy

    # a word in italics would be the product of its letters
    upright = {s: _roman(s.name) for s in expression.free_symbols if not _is_set(s.name)}
    upright |= {s: f"\\{GREEK[s.name]}" for s in upright if s.name in GREEK}
    written: str = sympy.latex(expression, symbol_names=upright)
    return written


def _is_set(name: str) -> bool:
    """Whether sympy typesets a name as a letter, with an index or an accent, or as a Greek letter."""
    import sympy

    if not PLAIN_NAME.fullmatch(name) or not name.strip("_"):
        return False
    return len(name) == 1 or any(sign in sympy.latex(sympy.Symbol(name)) for sign in "\\_^")


def _roman(text: str) -> str:
    return rf"\mathrm{{{shown(text).translate(_IN_MATHEMATICS)}}}"
