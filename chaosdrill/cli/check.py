"""``chaosdrill check``: whether a scene is right, and what it will simulate."""

import json
from typing import Any

import click

from chaosdrill.cli.options import changes_option, json_option
from chaosdrill.cli.output import emit
from chaosdrill.cli.streams import say


@click.command()
@click.argument("scene")
@changes_option
@json_option
def check(scene: str, changes: dict[str, Any], as_json: bool) -> None:
    """Validate SCENE without running it, and print its states, modes, events and equations.

    SCENE is a TOML file, or - for standard input.
    """
    from chaosdrill.scene import check as check_scene

    described = check_scene(scene, changes)
    if as_json:
        emit({"valid": True, **described})
    else:
        say(check_text(described))


def check_text(described: dict[str, Any]) -> str:
    """The description of a scene for people."""
    lines = [described["title"], f"system     {described['system']}"]
    lines += _block("set", ((key, f"= {value}") for key, value in described["changes"].items()))
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
    rows = ((name, f"= integral of {_in_modes(rate)}") for name, rate in described["quadratures"].items())
    lines += _block("quadratures", rows)
    if described["period"] is not None:
        lines += _block("forcing", [("period", described["period"])])
    lines += _block(
        "SI quantities",
        (
            (
                name,
                f"= {entry['value']:.12g}{'' if entry['units'] == '1' else ' ' + entry['units']}".ljust(24)
                + entry["label"],
            )
            for name, entry in described["si"].items()
        ),
    )
    lines += _block("SI scales", ((name, f"{value:.12g}") for name, value in described["si_scales"].items()))
    lines += _block("numerics", ((name, str(v)) for name, v in described["numerics"].items() if v is not None))
    for name, analysis in described["analyses"].items():
        lines += _block(
            f"analysis {name}", ((key, json.dumps(value, ensure_ascii=False)) for key, value in analysis.items())
        )
    return "\n".join(lines)


def _event(event: dict[str, Any]) -> list[tuple[str, str]]:
    way = {1: "rises through 0", -1: "falls through 0", 0: "passes 0"}[event["direction"]]
    rows = [("when", f"{event['guard']} {way}")]
    if event["condition"] is not None:
        rows.append(("if", _in_modes(event["condition"])))
    return rows + [(f"{state} :=", value) for state, value in event["reset"].items()]


def _in_modes(told: str | dict[str, str]) -> str:
    """A text, or those of modes that differ in it."""
    return told if isinstance(told, str) else "; ".join(f"{text} in {mode}" for mode, text in told.items())


def _block(heading: str, rows: Any) -> list[str]:
    rows = list(rows)
    width = max((len(name) for name, _ in rows), default=0)
    return [heading, *(f"  {name:<{width}} {text}".rstrip() for name, text in rows)] if rows else []
