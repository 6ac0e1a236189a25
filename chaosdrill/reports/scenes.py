"""The scene of an archive: what was simulated, what was not, and with which numbers."""

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from chaosdrill.errors import ChaosdrillError
from chaosdrill.reports.equations import equations, events, math
from chaosdrill.reports.html import Html, Quantity, element, facts, joined, table
from chaosdrill.reports.numbers import number

if TYPE_CHECKING:
    import xarray as xr

    from chaosdrill.model import HybridSystem
    from chaosdrill.scene import Scene

MOST_SYSTEMS = 10
LONGEST_ARGUMENT = 200


def scene_section(tree: "xr.DataTree") -> Html:
    """Everything that the scene says, or what the definitions tell without one."""
    text = tree.attrs.get("scene")
    if not isinstance(text, str):
        return _defined(tree)
    from chaosdrill.scene import parse_scene

    listing = joined([element("h3", "Scene file"), element("pre", element("code", text), tabindex="0")])
    try:
        scene = parse_scene(text, str(tree.attrs.get("scene_name", "scene.toml")))
        described = _described(scene)
    except ChaosdrillError as fault:
        reason = element("p", "The scene cannot be read by this version: ", str(fault), class_="fault")
        return joined([reason, _known(tree), listing])
    return joined([described, listing], "\n")


def _described(scene: "Scene") -> Html:
    from chaosdrill.scene.describe import describe_scene

    told = describe_scene(scene)
    effects = []
    if told["simulated"]:
        effects += [element("h3", "Simulated"), facts(told["simulated"].items())]
    if told["left_out"]:
        effects += [element("h3", "Left out"), facts(told["left_out"].items())]
    origin = {name: "scene" if p["given"] else "default" for name, p in told["parameters"].items()}
    scales = [(name.replace("_", " "), value) for name, value in told["si_scales"].items()]
    units = table("One dimensionless unit in SI units", ("quantity", "value"), scales)
    return _system(scene.system, origin, joined(effects), units)


def _system(system: "HybridSystem", origin: Mapping[str, str], before: Html, units: Html) -> Html:
    """Numbers and equations of a system; ``origin`` tells of each parameter where its value comes from."""
    labels = system.labels
    states = [(name, math(name), system.initial[name], labels.get(name, "")) for name in system.state_names]
    parameters = [
        (name, math(name), Quantity(number(value, 12)), origin.get(name, "the run"), labels.get(name, ""))
        for name, value in system.parameters.items()
    ]
    return joined(
        [
            element("p", "System: ", element("strong", system.name), ". ", system.description),
            before,
            element("h3", "States and parameters"),
            table("States", ("state", "symbol", "at first", "is"), states),
            table("Parameters", ("parameter", "symbol", "value", "from", "is"), parameters),
            units,
            element("h3", "Equations"),
            equations(system),
            element("h3", "Events") if system.transitions else None,
            events(system),
        ],
        "\n",
    )


def _defined(tree: "xr.DataTree") -> Html:
    """The systems of an archive without a scene, from the definitions in its groups: equations once, all numbers."""
    found: dict[str, dict[str, xr.Dataset]] = {}
    for node in tree.subtree:
        if "definition" in node.attrs:
            group = node.path.strip("/") or "result"
            found.setdefault(str(node.attrs["definition"]), {})[group] = node.to_dataset(inherit=False)
    if not found:
        told = "The archive holds no scene and no definition of a system, so its equations are not known here."
        return joined([element("p", told), _known(tree)])
    parts = [element("p", "The archive holds no scene; each analysis holds its system and its arguments.")]
    for groups in list(found.values())[:MOST_SYSTEMS]:
        try:
            parts.append(_with_numbers(groups))
        except ChaosdrillError as fault:
            parts.append(element("p", "The definition cannot be read: ", str(fault), class_="fault"))
    if len(found) > MOST_SYSTEMS:
        parts.append(element("p", f"{len(found) - MOST_SYSTEMS} more systems are in the archive.", class_="left-out"))
    arguments = [
        (node.path.strip("/") or "result", name, json.dumps(value, ensure_ascii=False)[:LONGEST_ARGUMENT])
        for node in tree.subtree
        for name, value in read_json(node.attrs.get("settings")).items()
        if value is not None
    ]
    return joined([*parts, element("h3", "Arguments"), table("Arguments", ("group", "argument", "value"), arguments)])


def _with_numbers(groups: "Mapping[str, xr.Dataset]") -> Html:
    """A system with the numbers of its first analysis, and what others have instead."""
    from chaosdrill.archive.again import system_of

    (first, dataset), *others = groups.items()
    system = system_of(dataset)
    numbers = {**system.parameters, **system.initial}
    changed = [
        (group, name, str(value))
        for group, other in others
        for name, value in (read_json(other.attrs.get("parameters")) | read_json(other.attrs.get("initial"))).items()
        if value != numbers.get(name)
    ]
    shown = _system(system, dict.fromkeys(system.parameters, first), Html(""), Html(""))
    instead = [element("h3", "Other numbers"), table("Other numbers", ("group", "of", "value"), changed)]
    return joined([shown, *(instead if changed else ())])


def _known(tree: "xr.DataTree") -> Html:
    """Parameters that the groups themselves were made with."""
    rows = []
    for node in tree.subtree:
        for name, value in read_json(node.attrs.get("parameters")).items():
            rows.append((str(node.attrs.get("system", "")), node.path.strip("/"), str(name), str(value)))
    return table("Parameters", ("system", "group", "parameter", "value"), dict.fromkeys(rows))


def read_json(value: Any) -> dict[str, Any]:
    """An attribute that holds a JSON object; empty if it does not."""
    try:
        found = json.loads(value)
    except (TypeError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}
