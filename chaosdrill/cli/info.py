"""``chaosdrill info``: what is in an archive and where it came from."""

from typing import Any

import click

from chaosdrill.cli.options import json_option
from chaosdrill.cli.output import emit
from chaosdrill.cli.streams import say


@click.command()
@click.argument("archive", metavar="OUT.nc")
@json_option
def info(archive: str, as_json: bool) -> None:
    """Show the contents and provenance of OUT.nc."""
    from chaosdrill.workflow import info as describe

    described = describe(archive)
    if as_json:
        emit(described)
    else:
        say(info_text(described))


def info_text(described: dict[str, Any]) -> str:
    """The description of an archive for people."""
    lines = [f"{described['path']}  {described['bytes']} bytes"]
    for name, value in described.items():
        if name in ("path", "bytes", "altered", "quantities", "groups"):
            continue
        if isinstance(value, dict):
            if not value:
                continue
            value = ", ".join(f"{key} {text}" for key, text in value.items())
        lines.append(f"  {name:<13} {value}")
    lines += altered_line(described)
    for name, entry in described["quantities"].items():
        lines.append(f"  {name:<21} {entry['value']} [{entry['units']}]  {entry['long_name']}")
    for group, content in described["groups"].items():
        facts = [f"{name} {content[name]}" for name in ("system", "method", "tolerance") if name in content]
        lines += ["", f"{group}  {content['kind']}  {', '.join(facts)}"]
        lines.append("  dimensions    " + ", ".join(f"{name} {size}" for name, size in content["dimensions"].items()))
        for heading, key in (("outcomes", "outcomes"), ("special", "special_points")):
            if counts := ", ".join(f"{name} {count}" for name, count in content.get(key, {}).items()):
                lines.append(f"  {heading:<13} {counts}")
        lines.append(f"  repeatable    {content['repeatable']}")
        lines += altered_line(content)
        for name, variable in content["variables"].items():
            shape = f"({', '.join(variable['dimensions'])})"
            lines.append(f"  {name + shape:<44} {variable['dtype']:<8} [{variable['units']}]  {variable['long_name']}")
    return "\n".join(lines)


def altered_line(described: dict[str, Any]) -> list[str]:
    """What of the archive or of a group was altered, if anything was."""
    changed = described.get("altered")
    return [f"  altered       {', '.join(changed)}  (since the archive was written)"] if changed else []
