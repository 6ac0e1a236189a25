"""``chaosdrill run``: every analysis of a scene, into one archive."""

import json
from typing import Any
from warnings import catch_warnings

import click

from chaosdrill.annotations import DataArray, Dataset
from chaosdrill.cli.streams import changes_option, emit, json_option, say, tell
from chaosdrill.cli.tuning import TUNING
from chaosdrill.dataset.branches import Special, count_special_points
from chaosdrill.dataset.equilibria import SpecialEquilibrium
from chaosdrill.dataset.outcomes import Outcome, count_outcomes, flag_names
from chaosdrill.errors import StartWarning
from chaosdrill.progress import Display

# of the larger variables these are short enough for a line
_SHORT = {"exponent", "multiplier"}


@click.command()
@click.argument("scene")
@click.option("-o", "--output", required=True, metavar="OUT.nc", help="Archive to write; an existing one is replaced.")
@changes_option
@click.option("--workers", type=click.IntRange(min=1), default=1, show_default=True, help="Points computed at once.")
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler whose workers compute the points.")
@click.option("--resume", is_flag=True, help="Continue an unfinished run, or start a new one.")
@json_option
def run(
    scene: str, output: str, changes: dict[str, Any], workers: int, scheduler: str | None, resume: bool, as_json: bool
) -> None:
    """Run every analysis of SCENE and write one archive.

    It is written completely or not at all. SCENE is a TOML file, or - for standard input. Values from --set become part
    of the scene stored in the archive.

    Finished parts are kept in the folder OUT.nc.parts until the archive is written. After an interruption, a kill or
    a full disk the same command with --resume continues from there and writes the same archive, bit for bit, also with
    other workers. Without --resume a folder with finished parts is left untouched, and nothing is run.

    The exit code is 0 even for a run that ends early: its end (escaped, stalled, invalid_start, ...) is the outcome in
    the archive, with a line of advice on stderr. It is 1 if the archive cannot be written, and 2 if the scene or the
    command line is invalid.
    """
    from chaosdrill.workflow import run as run_scene

    # advice says it for every outcome
    with catch_warnings(action="ignore", category=StartWarning), Display() as progress:
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


def describe(dataset: Dataset) -> dict[str, Any]:
    """A result for scripts: its kind, the counts by outcome, the numbers that `summary` prints, and advice."""
    values = {}
    for name, variable in short_variables(dataset).items():
        values[name] = _meaning(variable) if "flag_meanings" in variable.attrs else variable.values.tolist()
    described = {"kind": dataset.attrs["kind"], "wall_time_s": dataset.attrs.get("wall_time_s")}
    if "outcome" in dataset:
        described["outcomes"] = count_outcomes(dataset["outcome"].values)
    if "special_kind" in dataset:
        described["special_points"] = count_special_points(dataset["special_kind"])
    return {**described, "values": values, "advice": advice(dataset)}


def short_variables(dataset: Dataset) -> dict[str, DataArray]:
    """The numbers of a result, and its lists of a few numbers."""
    found = {}
    for name, variable in dataset.data_vars.items():
        short = variable.ndim == 0 or (variable.dims[0] in _SHORT and variable.size <= TUNING.short_list)
        if variable.ndim <= 1 and short and variable.dtype.kind in "iuf":
            found[str(name)] = variable
    return found


def _meaning(code: DataArray) -> str:
    # a negative code stands for none of them
    return "none" if code < 0 else flag_names(code).get(int(code), f"code {int(code)}")


def summary(dataset: Dataset) -> list[str]:
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


def advice(dataset: Dataset) -> list[str]:
    """Advice on points without a result, and on results that need a remark."""
    lines = dataset.attrs.get("message", "").splitlines()
    lines += [f"consistency check failed: {line}" for line in dataset.attrs.get("disagreement", "").splitlines()]
    for name, count in count_outcomes(dataset["outcome"].values).items() if "outcome" in dataset else ():
        outcome = Outcome.__members__.get(name.upper(), Outcome.OK)
        if outcome > Outcome.CHAOTIC and outcome.advice not in dataset.attrs.get("message", ""):
            lines.append(f"{name} ({count} of {dataset['outcome'].size}): {outcome.advice}")
    return lines


def orbit_lines(dataset: Dataset) -> list[str]:
    """One line per orbit of a search; for a continuation its branches, their special points and the cascade."""
    lines: list[str] = []
    if "orbit" in dataset.sizes:
        lines = [_orbit(dataset.isel(orbit=i)) for i in range(dataset.sizes["orbit"])]
    elif "branch_number" in dataset.sizes:
        lines = [line for number in dataset["branch_number"].values for line in _branch(dataset, int(number))]
        lines += _cascade(dataset)
    more = len(lines) - TUNING.lines
    return lines if more <= 0 else [*lines[: TUNING.lines], f"and {more} more lines; see the archive"]


def _orbit(orbit: Dataset) -> str:
    multipliers = ", ".join(
        f"{real:.6g}{imag:+.6g}i" if imag else f"{real:.6g}"
        for real, imag in zip(orbit["multiplier_real"].values, orbit["multiplier_imag"].values, strict=True)
    )
    stable = "stable" if orbit["stable"] else "unstable"
    state = ", ".join(f"{value:.10g}" for value in orbit["orbit_state"].values)
    forced = "forcing_period" in orbit
    length = f"period {int(orbit['period'])}" if forced else f"duration {float(orbit['period_time']):.10g}"
    return f"orbit {int(orbit['orbit'])}: {length}, {stable}, ({state}), multipliers {multipliers}"


def _branch(dataset: Dataset, number: int) -> list[str]:
    """A branch of orbits or of equilibria from its start to its end, with its special points between."""
    own = dataset["branch"].values == number
    parameters = list(json.loads(dataset.attrs["settings"])["sweep"])
    first = dataset.isel(branch_number=number)
    if "branch_period" in dataset:
        kind, usual = f"period {int(first['branch_period'])}", {one.advice for one in Special}
    else:
        kind, usual = f"mode {_meaning(dataset['mode'][own.argmax()])}", {one.advice for one in SpecialEquilibrium}
    stable = int(dataset["stable"].values[own].sum())
    lines = [f"branch {number}: {kind}, {own.sum()} points, {stable} of them stable; {first['branch_start'].item()}"]
    names = flag_names(dataset["special_kind"])
    for i in own[dataset["special_index"].values].nonzero()[0].tolist():
        there = [dataset[name].values[i] for name in ("special_value", "special_value_2")[: len(parameters)]]
        place = ", ".join(f"{name} = {value:.12g}" for name, value in zip(parameters, there, strict=True))
        special, text = names[int(dataset["special_kind"].values[i])], str(dataset["special_text"].values[i])
        error = f"(error {dataset['special_error'].values[i]:.1g})"
        lines.append(f"  {special.replace('_', ' ')} at {place} {error}" + (f": {text}" if text not in usual else ""))
    return [*lines, f"  end: {first['branch_end_text'].item()}"]


def _cascade(dataset: Dataset) -> list[str]:
    if "doubling_value" not in dataset:
        return []
    rows = zip(*(dataset[n].values for n in ("doubling_period", "doubling_value", "feigenbaum_ratio")), strict=True)
    lines = [
        f"period {period} doubles at {value:.12g}" + (f", ratio {ratio:.6g}" if ratio == ratio else "")
        for period, value, ratio in rows
    ]
    limit, error = float(dataset["accumulation"]), float(dataset["accumulation_error"])
    return [*lines, f"doublings accumulate at {limit:.12g} (error {error:.1g})"] if limit == limit else lines
