"""``chaosdrill verify``: whether an archive is what its own scene, or definitions, give."""

import click

from chaosdrill.cli.options import json_option
from chaosdrill.cli.output import emit
from chaosdrill.cli.progress import Progress
from chaosdrill.cli.streams import say, tell


@click.command()
@click.argument("archive", metavar="OUT.nc")
@click.option("--workers", type=click.IntRange(min=1), default=1, show_default=True, help="Points computed at a time.")
@json_option
def verify(archive: str, workers: int, as_json: bool) -> int:
    """Run the scene that OUT.nc holds once more and compare, variable by variable.

    An archive that was saved from Python has no scene: each of its analyses is run again from the definition of its
    system, which it holds, and the arguments.

    With the same versions on the same platform: bit by bit. With others: cycles, multipliers and whatever attracts
    within the error of the method, averages in chaos within their standard errors; how each variable was compared is
    printed. What a clock measured is held to the archive's own digest. Exit code 1 and a table if anything differs.
    """
    from dataclasses import asdict

    from chaosdrill.archive import verify as verify_archive

    with Progress() as progress:
        result = verify_archive(archive, workers=workers, report=progress.report)
    if as_json:
        differences = [asdict(item) for item in result.differences]
        shown = {"path": archive, "equal": result.equal, "differences": differences, "notes": list(result.notes)}
        shown |= {"exact": result.exact, "checks": [asdict(check) for check in result.checks]}
        emit(shown)
    elif result.equal:
        say(f"{archive}: equal, {'bit for bit' if result.exact else 'as far as it can be compared'}")
    else:
        say(f"{archive}: differs from what is computed again")
        say(result.table())
    if not as_json:
        if not result.exact:
            say(result.how())
        for note in result.notes:
            tell(note)
    return 0 if result.equal else 1
