"""Every fault of a scene, each with its place, its line and its remedy."""

import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from chaosdrill.errors import SceneError
from chaosdrill.names import shortened
from chaosdrill.scene.lines import Path

SHOWN = 50
NO_LINE = 0
"""Line of what stands in no file, since it was set on the command line."""


@dataclass(frozen=True)
class Problem:
    """One fault: the path of keys to it, and what is wrong there with the likely fix."""

    path: Path
    message: str


def problems_of(faults: Iterable[tuple[Path, str]], at: Path) -> list[Problem]:
    """Faults of what stands at a place."""
    return [Problem((*at, *path), message) for path, message in faults]


class InvalidSceneError(SceneError):
    """A scene with faults; its text has one line for each.

    Parameters
    ----------
    name : str
        Name of the file, as the messages show it.
    problems : iterable of Problem
        What is wrong; the attribute of this name holds line (or None), field and message of each, for scripts.
    lines : mapping of path to int
        Where the keys stand; 0 for those that were set on the command line.
    """

    def __init__(self, name: str, problems: Iterable[Problem], lines: Mapping[Path, int]) -> None:
        placed = sorted(((line_of(problem.path, lines), problem) for problem in problems), key=lambda pair: pair[0])
        self.problems = [
            {"line": line or None, "field": show(problem.path), "message": problem.message} for line, problem in placed
        ]
        texts = [
            f"{f'{name}:{line}' if line else '--set'}: {show(problem.path)}: {problem.message}"
            for line, problem in placed
        ]
        if len(texts) > SHOWN:
            texts[SHOWN:] = [f"{name}: and {len(texts) - SHOWN} more"]
        super().__init__("\n".join(texts))


def line_of(path: Path, lines: Mapping[Path, int]) -> int:
    """Line of a path, or of the nearest table around it that has one."""
    while path and path not in lines:
        path = path[:-1]
    return lines.get(path, 1)


def show(path: Path) -> str:
    """A path as people write it: ``system.parameters.eta``, ``sweep.eta[2]``."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            part = shortened(part)
            name = part if re.fullmatch(r"[A-Za-z0-9_-]+", part) else json.dumps(part, ensure_ascii=False)
            text += f".{name}" if text else name
    return text
