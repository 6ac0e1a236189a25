"""``chaosdrill verify``: whether an archive is what its own scene, or definitions, give."""

import click

from chaosdrill.cli.options import json_option
from chaosdrill.cli.output import emit
from chaosdrill.cli.streams import say, tell
from chaosdrill.progress import Display


@click.command()
@click.argument("archive", metavar="OUT.nc")
@click.option("--workers", type=click.IntRange(min=1), default=1, show_default=True, help="Points computed at once.")
@json_option
def verify(archive: str, workers: int, as_json: bool) -> int:
    """Run the scene stored in OUT.nc again and compare every variable.

    An archive saved from Python has no scene: each of its analyses is run again from the stored definition of its
    system and the arguments.

    With the same versions on the same platform: bit by bit. Otherwise: cycles, multipliers and attractors
    within the error of the method, averages in chaos within their standard errors; the criterion of each variable is
    printed. Measured times are compared with their checksums. Exit code 1 and a table if anything differs.
    """
    from dataclasses import asdict

    from chaosdrill.workflow import verify as verify_archive

    with Display() as progress:
        result = verify_archive(archive, workers=workers, report=progress.report)
    if as_json:
        differences = [asdict(item) for item in result.differences]
        shown = {"path": archive, "equal": result.equal, "differences": differences, "notes": list(result.notes)}
        shown |= {"exact": result.exact, "checks": [asdict(check) for check in result.checks]}
        emit(shown)
    elif result.equal:
        say(f"{archive}: equal, {'bit for bit' if result.exact else 'by the criterion of each variable'}")
    else:
        say(f"{archive}: differs from the repeated run")
        say(result.table())
    if not as_json:
        if not result.exact:
            say(result.how())
        for note in result.notes:
            tell(note)
    return 0 if result.equal else 1
