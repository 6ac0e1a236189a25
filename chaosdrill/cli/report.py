"""``chaosdrill report``: all that an archive tells, in one page."""

import click

from chaosdrill.cli.options import json_option
from chaosdrill.cli.output import emit
from chaosdrill.cli.streams import say, tell


@click.command()
@click.argument("archive", metavar="OUT.nc")
@click.option("-o", "--output", metavar="REPORT.html", help="Page to write. Default: next to the archive.")
@json_option
def report(archive: str, output: str | None, as_json: bool) -> int:
    """Write the contents of OUT.nc to one page, and print its name.

    The page is one file that loads nothing: scene and equations, plots, charts in which one selects a parameter
    and sees its section and exponents, tables, accuracy and cost, and the provenance of the numbers.

    Exit code 1 if a part could not be shown, for example of an altered archive; the page then says which.
    """
    from dataclasses import asdict

    from chaosdrill.reports import report as write_report

    made = write_report(archive, output)
    if as_json:
        emit({**asdict(made), "path": str(made.path), "archive": str(made.archive)})
    else:
        say(str(made.path))
    for fault in made.faults:
        tell(f"could not be shown: {fault}")
    return 1 if made.faults else 0
