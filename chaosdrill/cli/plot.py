"""``chaosdrill plot``: the pictures that suit what is in an archive."""

import click


@click.command()
@click.argument("archive", metavar="OUT.nc")
@click.option(
    "-o",
    "--output",
    metavar="FIG.png",
    help="Picture to write (png, pdf, svg); of several, each gets its own name before the suffix. "
    "Default: beside the archive.",
)
@click.option("--group", metavar="NAME", help="Only this group of the archive.")
def plot(archive: str, output: str | None, group: str | None) -> None:
    """Draw the pictures that suit what is in OUT.nc, and print the files written."""
    from chaosdrill.plot import plot_archive

    for path in plot_archive(archive, output, group=group):
        click.echo(str(path))
