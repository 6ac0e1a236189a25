"""Examples on pages that are no notebooks are run when these pages are built, so that none goes stale unseen.

    python docs/_ext/executed.py README.md docs/sweeps.md       runs those of some pages by themselves

The blocks of a page are run in their order, in one namespace and one scratch folder, in which the files of
``docs/_examples/PAGE/`` lie beforehand and ``prelude.py`` has been run. What a block is decides what is done with it:

======== ========================================================================================================
python   is run
sh       is run by bash and must end with 0; of ``studies/run.py JOB`` only the job's name is checked
toml     a scene, or a part of one, which is completed by the drill: must be valid, and every analysis in it is known
======== ========================================================================================================

A block whose first line is a comment that begins with ``# not run`` is left out, and says to its reader why. Other
languages (text, none) are not looked at; a command in an indented block is a fault, since it would pass unseen.
"""

import os
import re
import runpy
import shutil
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

DOCS = Path(__file__).resolve().parent.parent
ROOT = DOCS.parent
BIN = str(Path(sys.executable).parent)
MARK = "# not run"
FENCE = re.compile(r"^(?P<fence>`{3,})(?P<language>\S*)[^\n]*\n(?P<text>.*?)^(?P=fence)$", re.MULTILINE | re.DOTALL)
INDENTED = re.compile(r"^(?: {4}|\t)(?:chaosdrill|pip|python3?) .*$", re.MULTILINE)
DRILL = """
[system]
model = "percussive-drill"
[system.effects]
drive = "harmonic"
friction = "stribeck"
rock = "moving"
contact = "hunt-crossley"
"""
ANY_ANALYSIS = """
[analysis.any]
kind = "trajectory"
periods = 1
"""


class Block(NamedTuple):
    """A fenced block of a page."""

    language: str
    line: int
    text: str


def blocks(page: Path) -> Iterator[Block]:
    """Blocks of a page that are examples and not marked as not run."""
    source = page.read_text(encoding="utf-8")
    for found in FENCE.finditer(source):
        if found["language"] in ("python", "sh", "toml") and not found["text"].startswith(MARK):
            yield Block(found["language"], source.count("\n", 0, found.start()) + 1, found["text"])


def hidden_commands(page: Path) -> list[str]:
    """Commands in indented blocks, which nothing runs."""
    outside = FENCE.sub("", page.read_text(encoding="utf-8"))
    return [found[0].strip() for found in INDENTED.finditer(outside)]


def jobs() -> set[str]:
    """Names of the jobs of ``studies/run.py``."""
    return set(runpy.run_path(str(ROOT / "studies" / "run.py"))["JOBS"])


def run_shell(text: str) -> None:
    """Run commands, all but studies, which have tests of their own."""
    lines = []
    for line in text.splitlines():
        study = re.match(r"python3 studies/run.py (\w+)", line)
        if study and study[1] not in jobs():
            raise ValueError(f"studies/run.py has no job {study[1]!r}")
        if not study:
            lines.append(line)
    subprocess.run(["bash", "-eu", "-o", "pipefail", "-c", "\n".join(lines)], check=True)


def check_scene(text: str) -> None:
    """Complete a scene, and validate it."""
    import chaosdrill as cd

    whole = text if re.search(r"^\[system(\.definition|\.filippov|\.map)?\]", text, re.MULTILINE) else DRILL + text
    cd.check(cd.parse_scene(whole if "[analysis." in whole else whole + ANY_ANALYSIS))


def run_page(page: Path) -> None:
    """Run the examples of a page in the current folder.

    Raises
    ------
    Exception
        That of the first block that fails, with a note that says where it stands.
    """
    namespace = {"__name__": "__main__"}
    given = DOCS / "_examples" / page.stem
    if given.is_dir():
        shutil.copytree(given, ".", dirs_exist_ok=True)
    prelude = Path("prelude.py")
    if prelude.is_file():
        exec(compile(prelude.read_text(encoding="utf-8"), str(prelude), "exec"), namespace)
    for block in blocks(page):
        try:
            if block.language == "python":
                exec(compile("\n" * block.line + block.text, str(page), "exec"), namespace)
            elif block.language == "sh":
                run_shell(block.text)
            else:
                check_scene(block.text)
        except Exception as fault:
            fault.add_note(f"{page}:{block.line}: in this {block.language} block")
            raise


def pages() -> list[Path]:
    """The README, and every page on which there is an example outside of notebook cells."""
    written = [page for page in sorted(DOCS.rglob("*.md")) if page.parent.name not in ("generated", "_build")]
    return [page for page in (ROOT / "README.md", *written) if any(blocks(page)) or hidden_commands(page)]


def faults_of(page: Path) -> list[str]:
    """What is wrong with the examples of a page, run in a process and a folder of their own."""
    faults = [f"{page}: indented, so that nothing runs it: {line}" for line in hidden_commands(page)]
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, __file__, "--here", str(page)],
            cwd=folder,
            env=dict(os.environ, MPLBACKEND="agg", PATH=os.pathsep.join([BIN, os.environ["PATH"]])),
            capture_output=True,
            text=True,
            check=False,
        )
    return faults if done.returncode == 0 else [*faults, f"{page}:\n{done.stdout[-2000:]}{done.stderr[-4000:]}"]


def run_examples(app) -> None:
    """Run the examples of all pages, and stop the build if one fails."""
    from sphinx.errors import ExtensionError
    from sphinx.util.display import status_iterator

    if app.builder.name not in ("html", "dirhtml"):
        return
    found = status_iterator(pages(), "running examples... ", "darkgreen", stringify_func=lambda page: page.name)
    faults = [fault for page in found for fault in faults_of(page)]
    if faults:
        raise ExtensionError("examples that fail:\n" + "\n".join(faults))


def setup(app) -> dict[str, bool]:
    """Run the examples before anything is built."""
    app.connect("builder-inited", run_examples)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def main(arguments: list[str]) -> int:
    """Run the examples of the pages named, and return how many pages have faults."""
    if arguments[:1] == ["--here"]:
        try:
            run_page(Path(arguments[1]))
        except Exception:
            traceback.print_exc()
            return 1
        return 0
    faulty = 0
    for page in [Path(name).resolve() for name in arguments] or pages():
        faults = faults_of(page)
        print(page.name, "; ".join(faults) or "runs", flush=True)
        faulty += bool(faults)
    return faulty


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
