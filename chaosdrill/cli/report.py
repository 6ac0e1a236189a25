"""``chaosdrill report``: all that an archive tells, in one page."""

import click

from chaosdrill.cli.options import json_option
from chaosdrill.cli.output import emit
from chaosdrill.cli.streams import say, tell


@click.command()
@click.argument("archive", metavar="OUT.nc")
@click.option("-o", "--output", metavar="REPORT.html", help="Page to write. Default: beside the archive.")
@json_option
def report(archive: str, output: str | None, as_json: bool) -> int:
    """Write a page with all that OUT.nc tells, and print its name.

    The page is one file that loads nothing: scene and equations, pictures, charts in which one points at a parameter
    and sees its section and exponents, tables, accuracy and cost, and where the numbers came from.

    Exit code 1 if a part could not be shown, as an altered archive may have; the page then says which.
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
