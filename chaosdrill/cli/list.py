"""``chaosdrill list``: what can be named in a scene."""

import json
from typing import Any

import click


def _systems() -> dict[str, Any]:
    from chaosdrill.systems import REGISTRY

    return {name: entry.summary for name, entry in REGISTRY.items()}


def _effects() -> dict[str, Any]:
    from chaosdrill.systems import EFFECTS

    return {effect: dict(options) for effect, options in EFFECTS.items()}


def _analyses() -> dict[str, Any]:
    from chaosdrill.analysis.registry import ANALYSES

    return {kind: entry.summary for kind, entry in ANALYSES.items()}


def _methods() -> dict[str, Any]:
    from chaosdrill.analysis.registry import METHODS

    return dict(METHODS)


_TOPICS = {"systems": _systems, "effects": _effects, "analyses": _analyses, "methods": _methods}


@click.command("list")
@click.argument("topic", type=click.Choice(list(_TOPICS)))
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def list_names(topic: str, as_json: bool) -> None:
    """List what can be named in a scene: systems, effects, analyses or methods, with a line each."""
    found = _TOPICS[topic]()
    if as_json:
        click.echo(json.dumps(found, indent=2))
        return
    if topic == "effects":
        found = {
            f"{effect} = {option!r}": text for effect, options in found.items() for option, text in options.items()
        }
    width = max(map(len, found))
    for name, summary in found.items():
        click.echo(f"{name:<{width}}  {summary}")
