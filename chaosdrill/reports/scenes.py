"""The scene of an archive: what was simulated, what was not, and with which numbers."""

import json
from typing import TYPE_CHECKING, Any

from chaosdrill.errors import ChaosdrillError
from chaosdrill.reports.equations import equations, events, math
from chaosdrill.reports.html import Html, Quantity, element, facts, joined, table
from chaosdrill.reports.numbers import number

if TYPE_CHECKING:
    import xarray as xr

    from chaosdrill.scene import Scene


def scene_section(tree: "xr.DataTree") -> Html:
    """Everything that the scene says, or what is known without one."""
    text = tree.attrs.get("scene")
    if not isinstance(text, str):
        return joined([element("p", "The archive holds no scene, so its equations are not known here."), _known(tree)])
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

    system, told = scene.system, describe_scene(scene)
    parts = [element("p", "System: ", element("strong", told["system"]), ". ", system.description)]
    if told["simulated"]:
        parts += [element("h3", "Simulated"), facts(told["simulated"].items())]
    if told["left_out"]:
        parts += [element("h3", "Left out"), facts(told["left_out"].items())]
    states = [(name, math(name), entry["initial"], entry["label"]) for name, entry in told["states"].items()]
    parameters = [
        (name, math(name), Quantity(number(p["value"], 12)), "scene" if p["given"] else "default", p["label"])
        for name, p in told["parameters"].items()
    ]
    scales = [(name.replace("_", " "), value) for name, value in told["si_scales"].items()]
    return joined(
        [
            *parts,
            element("h3", "States and parameters"),
            table("States", ("state", "symbol", "at first", "is"), states),
            table("Parameters", ("parameter", "symbol", "value", "from", "is"), parameters),
            table("One dimensionless unit in SI units", ("quantity", "value"), scales),
            element("h3", "Equations"),
            equations(system),
            element("h3", "Events") if system.transitions else None,
            events(system),
        ],
        "\n",
    )


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
