"""``chaosdrill cite``: the references of what an archive was made with."""

import click

from chaosdrill.cli.options import json_option
from chaosdrill.cli.output import emit
from chaosdrill.cli.streams import say


@click.command()
@click.argument("archive", metavar="OUT.nc")
@click.option("--bibtex", is_flag=True, help="Print BibTeX.")
@json_option
def cite(archive: str, bibtex: bool, as_json: bool) -> None:
    """Print what to cite for OUT.nc: this package, and the references of its analyses, methods and systems."""
    from dataclasses import asdict

    from chaosdrill.workflow import cite as references

    if bibtex and as_json:
        raise click.UsageError("--bibtex and --json are different formats; choose one")
    found = references(archive)
    if as_json:
        emit({"path": archive, "references": [asdict(reference) for reference in found]})
    else:
        texts = (reference.bibtex() if bibtex else reference.text() for reference in found)
        say(("\n\n" if bibtex else "\n").join(texts))
