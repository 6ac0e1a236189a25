"""Options that several commands share."""

from typing import Any

import click

from chaosdrill.scene.changes import parse_change


def given_text(text: str) -> str:
    """Text of the command line, which is UTF-8 whatever the locale."""
    try:
        return text.encode("utf-8", "surrogateescape").decode("utf-8")
    except UnicodeError:
        return text


def _changes(_context: click.Context, _option: click.Parameter, given: tuple[str, ...]) -> dict[str, Any]:
    return dict(parse_change(given_text(text)) for text in given)


changes_option = click.option(
    "--set",
    "changes",
    multiple=True,
    metavar="KEY=VALUE",
    callback=_changes,
    help="Set a value of the scene, as in system.parameters.eta=0.5; may be repeated.",
)
json_option = click.option("--json", "as_json", is_flag=True, help="Print one JSON document, also for errors.")
