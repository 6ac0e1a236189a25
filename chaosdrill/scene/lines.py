"""Positions of the keys of a TOML document, and the faults of a scene with their lines and remedies.

``tomllib`` gives no positions, and an error without a line is hard to find. The scanner walks a document that
``tomllib`` has already accepted, so it finds keys and values but does not validate them.
"""

import json
import re
import tomllib
from bisect import bisect_right
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from chaosdrill.errors import SceneError
from chaosdrill.names import shortened
from chaosdrill.scene.tuning import TUNING
from chaosdrill.settings import KeyPath

# nothing repeats possessively, which Python 3.11.4 and older do not match as they should (gh-106052), and nothing needs
# to: of the alternatives in a repetition never more than one fits
BARE = "[A-Za-z0-9_-]+"
_QUOTED = r"""(?:"(?:[^"\\\n]|\\[^\n])*"|'[^'\n]*')"""
NAME = f"(?:{BARE}|{_QUOTED})"
DOTTED = rf"{NAME}(?:[ \t]*\.[ \t]*{NAME})*"
COMMENT = r"#[^\n]*"
LONG_STRING = r'''(?:"""(?:[^"\\]|\\[\s\S]|"(?!""))*(?:"{3,5}|\Z)|\'\'\'(?:[^']|'(?!''))*(?:'{3,5}|\Z))'''
"""In three quotes, over lines; to the end of a text that does not close it."""

_BLANK = re.compile(rf"(?:[ \t\n]|{COMMENT})*")
_SPACE = re.compile(r"[ \t]*")
_NAME = re.compile(NAME)
_STRING = re.compile(f"{LONG_STRING}|{_QUOTED}")
_SCALAR = re.compile(r"[^,\]}#\n]*")

NO_LINE = 0  # line of what stands in no file, since it was set on the command line


@dataclass
class Positions:
    """Positions in the text of a TOML document: offsets of characters, lines from 1.

    ``values`` are the ends of each value, ``inside`` is where an inline table begins behind its brace, ``below`` where
    the header of a table ends.
    """

    lines: dict[KeyPath, int] = field(default_factory=dict)
    values: dict[KeyPath, tuple[int, int]] = field(default_factory=dict)
    inside: dict[KeyPath, int] = field(default_factory=dict)
    below: dict[KeyPath, int] = field(default_factory=dict)


def key_lines(text: str) -> dict[KeyPath, int]:
    """Line of every key and array element of a valid TOML document.

    ``text``: a document that ``tomllib.loads`` accepts.

    Returns: path of keys and indices -> line, from 1. A table's line is that of its header, if it has one.
    """
    return layout(text.replace("\r\n", "\n")).lines


def layout(text: str) -> Positions:
    """Where everything stands in a document that ``tomllib.loads`` accepts, and whose lines end in ``\\n``."""
    return _Scanner(text).scan()


class _Scanner:
    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0
        self.starts = [0, *(found.end() for found in re.finditer("\n", text))]
        self.found = Positions()
        self.lines = self.found.lines
        self.tables_of: dict[KeyPath, int] = {}

    def scan(self) -> Positions:
        table: KeyPath = ()
        self._skip(_BLANK)
        while self.at < len(self.text):
            if self.text[self.at] == "[":
                table = self._header()
            else:
                self._pair(table)
            self._skip(_BLANK)
        return self.found

    def _header(self) -> KeyPath:
        many = self.text.startswith("[[", self.at)
        line = self._line()
        self.at += 2 if many else 1
        names = self._dotted()
        self.at = self.text.index("]", self.at) + (2 if many else 1)
        path: KeyPath = ()
        for depth, name in enumerate(names, start=1):
            path = (*path, name)
            last = depth == len(names)
            if last and not many:
                self.lines[path] = line
            else:
                self.lines.setdefault(path, line)
            if last and many:
                self.tables_of[path] = self.tables_of.get(path, 0) + 1
            if path in self.tables_of:
                path = (*path, self.tables_of[path] - 1)
                self.lines.setdefault(path, line)
        self.found.below[path] = self.at
        return path

    def _pair(self, table: KeyPath) -> None:
        line = self._line()
        path = table
        for name in self._dotted():
            path = (*path, name)
            self.lines.setdefault(path, line)
        self.at = self.text.index("=", self.at) + 1
        self._skip(_SPACE)
        self._value(path)

    def _dotted(self) -> list[str]:
        names = []
        while True:
            self._skip(_SPACE)
            raw = self._skip(_NAME)
            names.append(next(iter(tomllib.loads(f"{raw} = 0"))))
            self._skip(_SPACE)
            if not self.text.startswith(".", self.at):
                return names
            self.at += 1

    def _value(self, path: KeyPath) -> None:
        opening, start = self.text[self.at], self.at
        if opening == "{":
            self.found.inside[path] = start + 1
        if opening in "\"'":
            self._skip(_STRING)
        elif opening in "[{":
            self.at += 1
            index = 0
            while True:
                self._skip(_BLANK)
                if self.text[self.at] in "]}":
                    break
                if opening == "{":
                    self._pair(path)
                else:
                    self.lines[*path, index] = self._line()
                    self._value((*path, index))
                index += 1
                self._skip(_BLANK)
                if self.text[self.at] == ",":
                    self.at += 1
            self.at += 1
        else:
            self._skip(_SCALAR)
        self.found.values[path] = start, start + len(self.text[start : self.at].rstrip())

    def _skip(self, pattern: re.Pattern[str]) -> str:
        found = pattern.match(self.text, self.at)
        if found is None:
            raise AssertionError(f"a valid document has no {self.text[self.at : self.at + 10]!r} at {self.at}")
        self.at = found.end()
        return found.group()

    def _line(self) -> int:
        return bisect_right(self.starts, self.at)


@dataclass(frozen=True)
class Problem:
    """One fault: the path of keys to it, and a message with the likely fix."""

    path: KeyPath
    message: str


def problems_of(faults: Iterable[tuple[KeyPath, str]], at: KeyPath) -> list[Problem]:
    """Problems of the faults below a path."""
    return [Problem((*at, *path), message) for path, message in faults]


class InvalidSceneError(SceneError):
    """A scene with faults; the message has one line for each.

    ``name``: name of the file, as the messages show it. ``problems``: the faults; the attribute of this name holds line
    (or None), field and message of each, for scripts. ``lines``: lines of the keys; 0 for those set on the command
    line.
    """

    def __init__(self, name: str, problems: Iterable[Problem], lines: Mapping[KeyPath, int]) -> None:
        placed = sorted(((line_of(problem.path, lines), problem) for problem in problems), key=lambda pair: pair[0])
        self.problems = [
            {"line": line or None, "field": show(problem.path), "message": problem.message} for line, problem in placed
        ]
        texts = [
            f"{f'{name}:{line}' if line else '--set'}: {show(problem.path)}: {problem.message}"
            for line, problem in placed
        ]
        if len(texts) > TUNING.faults_shown:
            texts[TUNING.faults_shown :] = [f"{name}: and {len(texts) - TUNING.faults_shown} more"]
        super().__init__("\n".join(texts))


def line_of(path: KeyPath, lines: Mapping[KeyPath, int]) -> int:
    """Line of a path, or of the nearest table around it that has one."""
    while path and path not in lines:
        path = path[:-1]
    return lines.get(path, 1)


def show(path: KeyPath) -> str:
    """A path in the notation of users: ``system.parameters.eta``, ``sweep.eta[2]``."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            part = shortened(part)
            name = part if re.fullmatch(BARE, part) else json.dumps(part, ensure_ascii=False)
            text += f".{name}" if text else name
    return text
