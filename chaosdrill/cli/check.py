"""``chaosdrill check``: whether a scene is right, and what it will simulate."""

import json
from typing import TYPE_CHECKING, Any

import click

from chaosdrill.cli.period import check_period

if TYPE_CHECKING:
    from chaosdrill.scene import Scene


@click.command()
@click.argument("scene")
@click.option("--json", "as_json", is_flag=True, help="Print JSON; of a wrong scene, its faults.")
def check(scene: str, as_json: bool) -> int:
    """Validate SCENE and print the states, modes, events and equations that it simulates; runs nothing."""
    from chaosdrill.scene import load_scene
    from chaosdrill.scene.problems import InvalidSceneError

    try:
        loaded = load_scene(scene)
        check_period(loaded)
        described = describe_scene(loaded)
    except InvalidSceneError as fault:
        if not as_json:
            raise
        click.echo(json.dumps({"valid": False, "problems": fault.problems}, indent=2))
        return 2
    click.echo(json.dumps({"valid": True, **described}, indent=2) if as_json else check_text(described))
    return 0


def describe_scene(scene: "Scene") -> dict[str, Any]:
    """What a scene simulates, as plain values: equations in text, numbers, names."""
    system = scene.system
    labels = system.labels
    return {
        "title": scene.title,
        "system": scene.model,
        "simulated": _effects(scene, present=True),
        "left_out": _effects(scene, present=False),
        "states": {
            name: {"label": labels.get(name, ""), "initial": system.initial[name]} for name in system.state_names
        },
        "initial_mode": system.initial["mode"],
        "parameters": {
            name: {"label": labels.get(name, ""), "value": value, "given": name in scene.parameters}
            for name, value in system.parameters.items()
        },
        "modes": {
            mode: {f"d{state}/dt": str(rate) for state, rate in field.items()} for mode, field in system.modes.items()
        },
        "events": {
            transition.name: {
                "from": list(transition.source),
                "to": transition.target,
                "guard": str(transition.guard),
                "direction": transition.direction,
                "condition": None if transition.condition is None else str(transition.condition),
                "reset": {str(state): str(value) for state, value in transition.reset.items()},
                "priority": transition.priority,
                "kind": transition.kind,
            }
            for transition in system.transitions
        },
        "quadratures": {name: str(rate) for name, rate in system.quadratures.items()},
        "period": None if system.period is None else str(system.period),
        "si_scales": dict(scene.scales),
        "numerics": scene.numerics.keywords(),
        "analyses": {
            name: analysis.model_dump(mode="json", exclude_unset=True) for name, analysis in scene.analyses.items()
        },
    }


def _effects(scene: "Scene", *, present: bool) -> dict[str, str]:
    """Effects that are simulated with their option, or those that are not, with what they would offer."""
    from chaosdrill.systems import EFFECTS, REGISTRY
    from chaosdrill.systems.drill.effects import ABSENT

    if not REGISTRY[scene.model].effects:
        return {}
    chosen = {effect: option for effect, option in scene.effects.items() if option != ABSENT[effect]}
    if present:
        return {effect: f"{option}: {EFFECTS[effect][option]}" for effect, option in chosen.items()}
    return {
        effect: "choose from " + ", ".join(option for option in options if option != ABSENT[effect])
        for effect, options in EFFECTS.items()
        if effect not in chosen
    }


def check_text(described: dict[str, Any]) -> str:
    """The description of a scene for people."""
    lines = [described["title"], f"system     {described['system']}"]
    for heading, key in (("simulated", "simulated"), ("left out", "left_out")):
        lines += _block(heading, described[key].items())
    lines += _block(
        "states",
        ((name, f"= {state['initial']:g} at first   {state['label']}") for name, state in described["states"].items()),
    )
    lines += _block(
        "parameters",
        (
            (name, f"= {entry['value']:.12g}{'' if entry['given'] else ' (default)'}   {entry['label']}")
            for name, entry in described["parameters"].items()
        ),
    )
    for mode, equations in described["modes"].items():
        first = "   (at first)" if mode == described["initial_mode"] else ""
        lines += _block(f"mode {mode}{first}", ((left, f"= {right}") for left, right in equations.items()))
    for name, event in described["events"].items():
        modes = f"{' or '.join(event['from'])} -> {event['to']}"
        lines += _block(f"event {name}   ({event['kind']}, {modes})", _event(event))
    lines += _block("quadratures", ((name, f"= integral of {rate}") for name, rate in described["quadratures"].items()))
    if described["period"] is not None:
        lines += _block("forcing", [("period", described["period"])])
    lines += _block("SI scales", ((name, f"{value:.12g}") for name, value in described["si_scales"].items()))
    lines += _block("numerics", ((name, str(v)) for name, v in described["numerics"].items() if v is not None))
    for name, analysis in described["analyses"].items():
        lines += _block(f"analysis {name}", ((key, json.dumps(value)) for key, value in analysis.items()))
    return "\n".join(lines)


def _event(event: dict[str, Any]) -> list[tuple[str, str]]:
    way = {1: "rises through 0", -1: "falls through 0", 0: "passes 0"}[event["direction"]]
    rows = [("when", f"{event['guard']} {way}")]
    if event["condition"] is not None:
        rows.append(("if", event["condition"]))
    return rows + [(f"{state} :=", value) for state, value in event["reset"].items()]


def _block(heading: str, rows: Any) -> list[str]:
    rows = list(rows)
    width = max((len(name) for name, _ in rows), default=0)
    return [heading, *(f"  {name:<{width}} {text}".rstrip() for name, text in rows)] if rows else []
