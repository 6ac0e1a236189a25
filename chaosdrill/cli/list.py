"""``chaosdrill list``: what can be named in a scene."""

import click

from chaosdrill.cli.options import json_option
from chaosdrill.cli.output import emit
from chaosdrill.cli.streams import say
from chaosdrill.scene.names import TOPICS
from chaosdrill.scene.names import list_names as names_of


@click.command("list")
@click.argument("topic", type=click.Choice(TOPICS))
@json_option
def list_names(topic: str, as_json: bool) -> None:
    """List the systems, effects, analyses or methods that a scene can name, with one line each."""
    found = names_of(topic)
    if as_json:
        emit(found)
        return
    if topic == "effects":
        found = {
            f"{effect} = {option!r}": text for effect, options in found.items() for option, text in options.items()
        }
    width = max(map(len, found))
    for name, summary in found.items():
        say(f"{name:<{width}}  {summary}")
