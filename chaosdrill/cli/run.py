"""``chaosdrill run``: every analysis of a scene, into one archive."""

from typing import TYPE_CHECKING, Any

import click

from chaosdrill.cli.options import changes_option, json_option
from chaosdrill.cli.orbit_lines import orbit_lines
from chaosdrill.cli.output import emit
from chaosdrill.cli.streams import say, tell
from chaosdrill.dataset.branches import count_special_points
from chaosdrill.dataset.outcomes import Outcome, count_outcomes
from chaosdrill.progress import Display

if TYPE_CHECKING:
    import xarray as xr

# of the larger variables these are short enough for a line
_SHORT = {"exponent", "multiplier"}
_SHORT_LENGTH = 8


@click.command()
@click.argument("scene")
@click.option("-o", "--output", required=True, metavar="OUT.nc", help="Archive to write; an existing one is replaced.")
@changes_option
@click.option("--workers", type=click.IntRange(min=1), default=1, show_default=True, help="Points computed at once.")
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler whose workers compute the points.")
@click.option("--resume", is_flag=True, help="Continue an unfinished run, or start a new one.")
@json_option
def run(
    scene: str,
    output: str,
    changes: dict[str, Any],
    workers: int,
    scheduler: str | None,
    resume: bool,
    as_json: bool,
) -> None:
    """Run every analysis of SCENE and write one archive, completely or not at all.

    SCENE is a TOML file, or - for standard input. Values from --set become part of the scene stored in the archive.

    Finished parts are kept in the folder OUT.nc.parts until the archive is written. After an interruption, a kill or
    a full disk the same command with --resume continues from there and writes the same archive, bit for bit, also with
    other workers. Without --resume a folder with finished parts is left untouched, and nothing is run.

    The exit code is 0 also for a run that ends early: how it ended (escaped, stalled, invalid_start, ...) is its
    outcome, which the archive contains, with a line of advice on stderr. It is 1 if the archive cannot be
    written, and 2 if the scene or the command line is invalid.
    """
    from chaosdrill.workflow import run as run_scene

    with Display() as progress:
        tree = run_scene(
            scene,
            output,
            changes=changes,
            workers=workers,
            scheduler=scheduler,
            resume=resume,
            report=progress.report,
            tell=progress.tell,
        )
    groups = {name: node.to_dataset() for name, node in tree.children.items()}
    for name, dataset in groups.items():
        for line in advice(dataset):
            tell(f"{name}: {line}")
    if as_json:
        root = {name: tree.attrs[name] for name in ("title", "scene_sha256", "wall_time_s")}
        emit({"archive": output, **root, "groups": {name: describe(group) for name, group in groups.items()}})
        return
    for name, dataset in groups.items():
        for line in [*summary(dataset), *orbit_lines(dataset), *dataset.attrs.get("recommendation", "").splitlines()]:
            say(f"{name}: {line}")
    say(output)


def describe(dataset: "xr.Dataset") -> dict[str, Any]:
    """A result for scripts: its kind, the counts by outcome, the numbers that `summary` prints, and advice."""
    values = {}
    for name, variable in short_variables(dataset).items():
        values[name] = _meaning(variable) if "flag_meanings" in variable.attrs else variable.values.tolist()
    described = {"kind": dataset.attrs["kind"], "wall_time_s": dataset.attrs.get("wall_time_s")}
    if "outcome" in dataset:
        described["outcomes"] = count_outcomes(dataset["outcome"].values)
    if "special_kind" in dataset:
        described["special_points"] = count_special_points(dataset["special_kind"].values)
    return {**described, "values": values, "advice": advice(dataset)}


def short_variables(dataset: "xr.Dataset") -> "dict[str, xr.DataArray]":
    """The numbers of a result, and its lists of a few numbers."""
    found = {}
    for name, variable in dataset.data_vars.items():
        short = variable.ndim == 0 or (variable.dims[0] in _SHORT and variable.size <= _SHORT_LENGTH)
        if variable.ndim <= 1 and short and variable.dtype.kind in "iuf":
            found[str(name)] = variable
    return found


def _meaning(code: "xr.DataArray") -> str:
    # a negative code stands for none of them
    if code < 0:
        return "none"
    meanings = code.attrs["flag_meanings"].split()
    return str(meanings[int(code)]) if code < len(meanings) else f"code {int(code)}"


def summary(dataset: "xr.Dataset") -> list[str]:
    """The numbers of a result that fit on a line each."""
    lines = []
    for name, variable in short_variables(dataset).items():
        if "flag_meanings" in variable.attrs:
            text = _meaning(variable)
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
    lines += [f"consistency check failed: {line}" for line in dataset.attrs.get("disagreement", "").splitlines()]
    for name, count in count_outcomes(dataset["outcome"].values).items() if "outcome" in dataset else ():
        outcome = Outcome.__members__.get(name.upper(), Outcome.OK)
        if outcome > Outcome.CHAOTIC and outcome.advice not in dataset.attrs.get("message", ""):
            lines.append(f"{name} ({count} of {dataset['outcome'].size}): {outcome.advice}")
    return lines
