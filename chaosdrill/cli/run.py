"""``chaosdrill run``: every analysis of a scene, into one archive."""

import os
from pathlib import Path
from typing import TYPE_CHECKING

import click

from chaosdrill.cli.orbit_lines import orbit_lines
from chaosdrill.cli.period import check_period
from chaosdrill.cli.progress import Progress
from chaosdrill.dataset.outcomes import Outcome, count_outcomes
from chaosdrill.errors import SettingsError
from chaosdrill.files import remove_drafts

if TYPE_CHECKING:
    import xarray as xr

# of the larger variables these are short enough for a line
_SHORT = {"exponent", "multiplier"}
_SHORT_LENGTH = 8


@click.command()
@click.argument("scene")
@click.option("-o", "--output", required=True, metavar="OUT.nc", help="Archive to write; an earlier one is replaced.")
@click.option("--workers", type=click.IntRange(min=1), default=1, show_default=True, help="Points computed at a time.")
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler whose workers compute the points instead.")
@click.option("--resume", is_flag=True, help="Go on with a run that did not end; begin one if there is none.")
def run(scene: str, output: str, workers: int, scheduler: str | None, resume: bool) -> None:
    """Run every analysis of SCENE and write one archive, whole or not at all.

    What has finished is kept in the folder OUT.nc.parts until the archive is written. After an interruption, a kill or
    a full disk the same command with --resume goes on from there and writes the same archive, bit for bit, also with
    other workers. Without --resume a folder with finished parts is left alone, and nothing is run.

    The exit code is 0 also for a run that ends early: how it ended (escaped, stalled, invalid_start, ...) is its
    outcome, a result that the archive holds, with a line of advice on stderr. It is 1 if the archive cannot be
    written, and 2 if the scene or the command line is wrong.
    """
    from chaosdrill.archive import check_writable, save
    from chaosdrill.scene import load_scene
    from chaosdrill.sweep import Parts

    if scheduler is not None and workers != 1:
        raise SettingsError(
            f"--workers is {workers}, but the scheduler at {scheduler} has workers of its own; give one of the two"
        )
    loaded = load_scene(scene)
    check_period(loaded)
    if os.path.exists(output) and os.path.samefile(scene, output):
        raise SettingsError(f"--output is {output!r}, which is the scene itself; name another file, such as result.nc")
    check_writable(output)
    with Parts(f"{output}.parts", loaded.fingerprint(), resume=resume) as parts:
        remove_drafts(Path(output))
        for name, state in parts.kept().items():
            click.echo(f"{name}: {state} before", err=True)
        try:
            with Progress() as progress:
                tree = loaded.run(workers=workers, scheduler=scheduler, parts=parts, report=progress.report)
            save(tree, output)
        except BaseException:
            if parts.kept():
                click.echo(f"what has finished is kept in {parts.folder}; --resume goes on with it", err=True)
            raise
        parts.finish()
    for name, node in tree.children.items():
        dataset = node.to_dataset()
        for line in [*summary(dataset), *orbit_lines(dataset), *dataset.attrs.get("recommendation", "").splitlines()]:
            click.echo(f"{name}: {line}")
        for line in advice(dataset):
            click.echo(f"{name}: {line}", err=True)
    click.echo(output)


def summary(dataset: "xr.Dataset") -> list[str]:
    """The numbers of a result that fit on a line each."""
    lines = []
    for name, variable in dataset.data_vars.items():
        short = variable.ndim == 0 or (variable.dims[0] in _SHORT and variable.size <= _SHORT_LENGTH)
        if variable.ndim > 1 or not short or variable.dtype.kind not in "iuf":
            continue
        if "flag_meanings" in variable.attrs:
            # a negative code stands for none of them
            text = variable.attrs["flag_meanings"].split()[int(variable)] if variable >= 0 else "none"
        else:
            text = " ".join(f"{value:.10g}" for value in variable.values.ravel())
        lines.append(f"{name} {text}")
    if "outcome" in dataset and dataset["outcome"].ndim and dataset["outcome"].size:
        counts = count_outcomes(dataset["outcome"].values)
        lines.append("outcome " + ", ".join(f"{outcome} {count}" for outcome, count in counts.items()))
    return lines


def advice(dataset: "xr.Dataset") -> list[str]:
    """What to say of points that have no result, and of results that need a word."""
    lines = dataset.attrs.get("message", "").splitlines()
    lines += [f"disagrees with itself: {line}" for line in dataset.attrs.get("disagreement", "").splitlines()]
    for name, count in count_outcomes(dataset["outcome"].values).items() if "outcome" in dataset else ():
        outcome = Outcome[name.upper()]
        if outcome > Outcome.CHAOTIC and outcome.advice not in dataset.attrs.get("message", ""):
            lines.append(f"{name} ({count} of {dataset['outcome'].size}): {outcome.advice}")
    return lines
