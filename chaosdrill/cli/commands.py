"""All commands except ``run``: each passes its arguments on and prints the result."""

import json
from collections.abc import Iterable
from dataclasses import asdict
from itertools import groupby
from pathlib import Path
from typing import Any

import click

from chaosdrill.cli.streams import answer, changes_option, given_text, json_option, tell
from chaosdrill.progress import Display
from chaosdrill.scene import check as check_scene
from chaosdrill.scene.names import TOPICS, new_scene
from chaosdrill.scene.names import list_names as names_of
from chaosdrill.systems import REGISTRY


@click.command()
@click.argument("system")
@json_option
def new(system: str, as_json: bool) -> None:
    """Print a scene of SYSTEM to start from.

    It has the parameters and the initial state of SYSTEM, a name of `chaosdrill list systems`, and two analyses.

    For example: chaosdrill new izhikevich > neuron.toml
    """
    text = new_scene(system)
    answer(as_json, {"system": system, "scene": text}, text.removesuffix("\n"))


@click.command()
@click.argument("folder", metavar="[DIR]", required=False)
@json_option
def warm(folder: str | None, as_json: bool) -> None:
    """Compile the engine beforehand, for containers and clusters.

    The code is kept where every process of this user finds it. With DIR it is put there, too: for an installation that
    cannot be written, name that folder in CHAOSDRILL_WARM_DIR. The code is that of this machine's kind of processor.
    """
    if folder is not None and (not folder or "\0" in folder or Path(folder).is_file()):
        # a shell's variable that is not set is empty: the code would lie in the working directory
        raise click.UsageError(f"DIR is {folder!r}, which names no folder; name one, or leave it out")
    from chaosdrill.engine.warm import warm as warm_engine

    compiled = (
        "grids.matching",
        "judgement.recurrence",
        "judgement.tori",
        "measures.blocks",
        "measures.covariant",
        "measures.neighbours",
    )
    elsewhere = tuple(f"chaosdrill.analysis.{one}" for one in compiled)
    try:
        made = warm_engine(None if folder is None else Path(folder), (*elsewhere, "chaosdrill.orbits.guards_met"))
    except OSError as fault:
        # a write names no file
        raise OSError(fault.errno, fault.strerror, fault.filename or folder) from fault
    if lost := [file for file in made if not file.exists()]:
        raise OSError(
            f"{lost[0].parent}: {len(lost)} of {len(made)} functions cannot be kept there; make room, name another "
            "folder in CHAOSDRILL_CACHE_DIR, or name a DIR"
        )
    size = sum(file.stat().st_size for file in made)
    where = sorted({str(file.parent) for file in made})
    text = f"{len(made)} functions, {size / 1e6:.1f} MB, in {', '.join(where)}"
    answer(as_json, {"folders": where, "functions": len(made), "bytes": size}, text)


@click.command()
@click.argument("scene")
@changes_option
@json_option
def check(scene: str, changes: dict[str, Any], as_json: bool) -> None:
    """Validate SCENE and print its equations; run nothing.

    States, parameters, modes and events are printed, and the effects that the scene leaves out.

    SCENE is a TOML file, or - for standard input.
    """
    described = check_scene(scene, changes)
    answer(as_json, {"valid": True, **described}, check_text(described))


def check_text(described: dict[str, Any]) -> str:
    """The description of a scene for people."""
    lines = [_within(described["title"], 2), f"system     {described['system']}"]

    def block(heading: str, rows: Iterable[tuple[str, str]]) -> None:
        listed = list(rows)
        width = max((len(name) for name, _ in listed), default=0)
        lines.extend([heading] * bool(listed))
        lines.extend(f"  {name:<{width}} {_within(text, width + 3)}".rstrip() for name, text in listed)

    def equal(key: str, sign: str = "=") -> list[tuple[str, str]]:
        return [(name, f"{sign} {value}") for name, value in described[key].items()]

    block("set", equal("changes"))
    for heading, key in (("simulated", "simulated"), ("left out", "left_out"), ("noise", "noise")):
        block(heading, described[key].items())
    block("symmetry", equal("symmetry", "->"))
    states, parameters = described["states"].items(), described["parameters"].items()
    block("states", ((name, f"= {state['initial']:g} initially   {state['label']}") for name, state in states))
    told = ((name, one["value"], "" if one["given"] else " (default)", one["label"]) for name, one in parameters)
    block("parameters", ((name, f"= {value:.12g}{default}   {label}") for name, value, default, label in told))
    block("map", equal("map"))
    for mode, equations in described["modes"].items():
        first = "   (initial)" if mode == described["initial_mode"] else ""
        block(f"mode {mode}{first}", ((left, f"= {right}") for left, right in equations.items()))
    for name, event in described["events"].items():
        block(f"event {name}   ({event['kind']}, {' or '.join(event['from'])} -> {event['to']})", _event(event))
    rates = described["quadratures"].items()
    block("quadratures", ((name, f"= integral of {_in_modes(rate)}") for name, rate in rates))
    block("forcing", [("period", described["period"])] if described["period"] is not None else [])
    si = (
        (name, f"= {one['value']:.12g} {one['units']}".removesuffix(" 1"), one["label"])
        for name, one in described["si"].items()
    )
    block("SI quantities", ((name, f"{amount:<24}{label}") for name, amount, label in si))
    block("SI scales", ((name, f"{value:.12g}") for name, value in described["si_scales"].items()))
    block("numerics", ((name, str(value)) for name, value in described["numerics"].items() if value is not None))
    for name, analysis in described["analyses"].items():
        block(f"analysis {name}", ((key, json.dumps(value, ensure_ascii=False)) for key, value in analysis.items()))
    return "\n".join(lines)


def _event(event: dict[str, Any]) -> list[tuple[str, str]]:
    way = {1: "rises through 0", -1: "falls through 0", 0: "passes 0"}[event["direction"]]
    rows = [("when", f"{event['guard']} {way}")]
    if event["condition"] is not None:
        rows.append(("if", _in_modes(event["condition"])))
    return rows + [(f"{state} :=", value) for state, value in event["reset"].items()]


def _in_modes(told: str | dict[str, str]) -> str:
    """A text, or those of modes that differ in it."""
    return told if isinstance(told, str) else "; ".join(f"{text} in {mode}" for mode, text in told.items())


def _within(text: Any, margin: int) -> str:
    """A text whose later lines are indented, so that a stranger's text makes no line that this program might print."""
    return str(text).replace("\n", "\n" + " " * margin)


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
@click.option(
    "--state",
    metavar="NAME",
    multiple=True,
    help="State that is shown where pictures show one; given twice, two against each other.",
)
@click.option("--animate", is_flag=True, help="An animation (gif, or mp4 by ffmpeg) of each trajectory instead.")
@json_option
def plot(
    archive: str, output: str | None, group: str | None, state: tuple[str, ...], animate: bool, as_json: bool
) -> None:
    """Draw every plot that suits OUT.nc.

    The names of the files written are printed.
    """
    from chaosdrill.plots import plot_archive

    named = None if group is None else given_text(group)
    names = [given_text(name) for name in state]
    # one name stands for itself, as in Python
    shown = names[0] if len(names) == 1 else names or None
    paths = [str(path) for path in plot_archive(archive, output, group=named, animated=animate, state=shown)]
    answer(as_json, {"archive": archive, "pictures": paths}, "\n".join(paths))


@click.command()
@click.argument("archive", metavar="OUT.nc")
@click.option("-o", "--output", metavar="REPORT.html", help="Page to write. Default: next to the archive.")
@json_option
def report(archive: str, output: str | None, as_json: bool) -> int:
    """Write OUT.nc as one page for a browser.

    The page is one file that loads nothing: scene and equations, plots, charts in which one selects a parameter
    and sees its section and exponents, tables, accuracy and cost, and the provenance of the numbers.

    The name of the page is printed. Exit code 1 if a part could not be shown, for example of an altered archive; the
    page then says which.
    """
    from chaosdrill.reports import report as write_report

    made = write_report(archive, output)
    path = str(made.path)
    answer(as_json, {**asdict(made), "path": path, "archive": str(made.archive)}, path)
    warn_of(made.unsealed)
    if made.altered:
        tell(f"altered since the archive was written: {', '.join(made.altered)}")
    for fault in made.faults:
        tell(f"could not be shown: {fault}")
    return 1 if made.faults else 0


@click.command()
@click.argument("archive", metavar="OUT.nc")
@click.option("--workers", type=click.IntRange(min=1), default=1, show_default=True, help="Points computed at once.")
@json_option
def verify(archive: str, workers: int, as_json: bool) -> int:
    """Run the scene in OUT.nc again and compare all results.

    An archive saved from Python has no scene: each of its analyses is run again from the stored definition of its
    system and the arguments.

    With the same versions on the same platform: bit by bit. Otherwise: cycles, multipliers and attractors
    within the error of the method, averages in chaos within their standard errors; the criterion of each variable is
    printed. Measured times are compared with their checksums. Exit code 1 and a table if anything differs.
    """
    from chaosdrill.workflow import verify as verify_archive

    with Display() as progress:
        result = verify_archive(archive, workers=workers, report=progress.report)
    how = "bit for bit" if result.exact else "by the criterion of each variable"
    lines = [f"{archive}: equal, {how}{', but not sealed' if result.unsealed else ''}"]
    if not result.equal:
        lines = [f"{archive}: differs from the repeated run", result.table()]
    lines += [] if result.exact else [result.how()]
    answer(as_json, {**asdict(result), "path": archive, "equal": result.equal}, "\n".join(lines))
    for note in () if as_json else result.notes:
        tell(note)
    warn_of(result.unsealed)
    return 0 if result.equal else 1


@click.command()
@click.argument("archive", metavar="OUT.nc")
@json_option
def info(archive: str, as_json: bool) -> None:
    """Show the contents and provenance of OUT.nc."""
    from chaosdrill.workflow import info as describe

    described = describe(archive)
    answer(as_json, described, info_text(described))
    warn_of(described["unsealed"])


def warn_of(unsealed: str) -> None:
    """Print on standard error, in every format of the output, that an archive is not sealed."""
    if unsealed:
        tell(unsealed)


def info_text(described: dict[str, Any]) -> str:
    """The description of an archive for people."""
    lines = [f"{described['path']}  {described['bytes']} bytes"]
    for name, value in described.items():
        if name in ("path", "bytes", "altered", "unsealed", "quantities", "groups") or value == {}:
            continue
        if isinstance(value, dict):
            value = ", ".join(f"{key} {text}" for key, text in value.items())
        lines.append(f"  {name:<13} {_within(value, 16)}")
    lines += altered_line(described)
    for name, entry in described["quantities"].items():
        lines.append(_within(f"  {name:<21} {entry['value']} [{entry['units']}]  {entry['long_name']}", 24))
    for group, content in described["groups"].items():
        facts = [f"{name} {content[name]}" for name in ("system", "method", "tolerance") if name in content]
        lines += ["", _within(f"{group}  {content['kind']}  {', '.join(facts)}", 16)]
        lines.append("  dimensions    " + ", ".join(f"{name} {size}" for name, size in content["dimensions"].items()))
        if noise := content.get("noise"):
            noises = "; ".join(f"{name} {words}" for name, words in noise.items())
            lines.append(f"  noise         {_within(noises, 16)}")
        for heading, key in (("outcomes", "outcomes"), ("special", "special_points")):
            if counts := ", ".join(f"{name} {count}" for name, count in content.get(key, {}).items()):
                lines.append(f"  {heading:<13} {counts}")
        lines.append(f"  repeatable    {_within(content['repeatable'], 16)}")
        lines += altered_line(content)
        for name, variable in content["variables"].items():
            shape = f"({', '.join(variable['dimensions'])})"
            about = f"{variable['dtype']:<8} [{variable['units']}]  {variable['long_name']}"
            lines.append(f"  {name + shape:<44} {_within(about, 47)}")
    return "\n".join(lines)


def altered_line(described: dict[str, Any]) -> list[str]:
    """What of the archive or of a group was altered, if anything was."""
    changed = described.get("altered")
    if described.get("without_digests"):
        return ["  altered       unknown: the values have no digests"]
    return [f"  altered       {', '.join(changed)}  (since the archive was written)"] if changed else []


@click.command()
@click.argument("archive", metavar="OUT.nc")
@click.option("--bibtex", is_flag=True, help="Print BibTeX.")
@json_option
def cite(archive: str, bibtex: bool, as_json: bool) -> None:
    """Print what to cite for OUT.nc.

    That is this package, and the references of the analyses, methods and systems in OUT.nc.
    """
    from chaosdrill.workflow import cite as references

    if bibtex and as_json:
        raise click.UsageError("--bibtex and --json are different formats; choose one")
    found = references(archive)
    texts = (reference.bibtex() if bibtex else reference.text() for reference in found)
    document = {"path": archive, "references": [asdict(reference) for reference in found]}
    answer(as_json, document, ("\n\n" if bibtex else "\n").join(texts))


@click.command("list")
@click.argument("topic", type=click.Choice(TOPICS))
@click.argument("name", required=False)
@json_option
def list_names(topic: str, name: str | None, as_json: bool) -> None:
    """List the names for scenes, with a line for each.

    These are systems, effects of the drill, analyses or methods. `chaosdrill list analyses NAME` lists the settings
    of an analysis.
    """
    found = names_of(topic, name)
    rows = found
    if topic == "systems":
        rows = {}
        for group, names in groupby(found, key=lambda system: REGISTRY[system].group):
            rows |= {f"{group}:": ""} | {f"  {system}": found[system] for system in names}
    elif topic == "effects":
        rows = {f"{effect} = {option!r}": text for effect, options in found.items() for option, text in options.items()}
    width = max(len(row) for row, text in rows.items() if text)
    answer(as_json, found, "\n".join(f"{row:<{width}}  {text}" if text else row for row, text in rows.items()))
