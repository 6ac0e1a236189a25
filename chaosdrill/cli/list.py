"""``chaosdrill list``: what can be named in a scene."""

from itertools import groupby

import click

from chaosdrill.cli.options import json_option
from chaosdrill.cli.output import emit
from chaosdrill.cli.streams import say
from chaosdrill.scene.names import TOPICS
from chaosdrill.scene.names import list_names as names_of
from chaosdrill.systems import REGISTRY


@click.command("list")
@click.argument("topic", type=click.Choice(TOPICS))
@click.argument("name", required=False)
@json_option
def list_names(topic: str, name: str | None, as_json: bool) -> None:
    """List the systems, effects, analyses or methods that a scene can name, or the settings of the analysis NAME."""
    found = names_of(topic, name)
    if as_json:
        emit(found)
    elif topic == "systems":
        for group, names in groupby(found, key=lambda system: REGISTRY[system].group):
            say(f"{group}:")
            _columns({f"  {system}": found[system] for system in names}, max(map(len, found)) + 2)
    elif topic == "effects":
        _columns(
            {f"{effect} = {option!r}": text for effect, options in found.items() for option, text in options.items()}
        )
    else:
        _columns(found)


def _columns(found: dict[str, str], width: int = 0) -> None:
    width = max(width, *map(len, found))
    for name, text in found.items():
        say(f"{name:<{width}}  {text}")
