"""``chaosdrill new``: a scene to start from."""

import click

from chaosdrill.cli.streams import say


@click.command()
@click.argument("system")
def new(system: str) -> None:
    """Print a scene of SYSTEM, a name of `chaosdrill list systems`, with its parameters, initial state and analyses.

    For example: chaosdrill new izhikevich > neuron.toml
    """
    from chaosdrill.scene.new import new_scene

    say(new_scene(system).removesuffix("\n"))
