"""``chaosdrill plot``: the pictures that suit what is in an archive."""

import click

from chaosdrill.cli.options import given_text, json_option
from chaosdrill.cli.output import emit
from chaosdrill.cli.streams import say


@click.command()
@click.argument("archive", metavar="OUT.nc")
@click.option(
    "-o",
    "--output",
    metavar="FIG.png",
    help="Plot to write (png, pdf, svg); if there are several, each name is inserted before the suffix. "
    "Default: next to the archive.",
)
@click.option("--group", metavar="NAME", help="Only this group of the archive.")
@json_option
def plot(archive: str, output: str | None, group: str | None, as_json: bool) -> None:
    """Draw every plot that suits the contents of OUT.nc, and print the files written."""
    from chaosdrill.plots import plot_archive

    paths = [str(path) for path in plot_archive(archive, output, group=None if group is None else given_text(group))]
    if as_json:
        emit({"archive": archive, "pictures": paths})
    else:
        say("\n".join(paths))
