"""Read a scene from a file, or report all its faults."""

import errno
import os
import re
import select
import stat
import sys
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from chaosdrill.errors import SceneError
from chaosdrill.files import HDF5, format_of_bytes, name_text, reason_of
from chaosdrill.scene.changes import change, toml_value
from chaosdrill.scene.lines import COMMENT, DOTTED, LONG_STRING, NAME, NO_LINE, InvalidSceneError, Problem, key_lines
from chaosdrill.scene.scene import PIPED, STDIN, Scene
from chaosdrill.scene.tuning import TUNING
from chaosdrill.settings import KeyPath
from chaosdrill.typed import PATH, TABLE, TEXT, expecting
from chaosdrill.units import VANISHES, vanishes

# a long text or comment is not a key, nor is a text that its line does not close
_TOKEN = re.compile(rf"""{COMMENT}|{LONG_STRING}|(?P<key>{DOTTED})|"[^\n]*""")
_PLACE = re.compile(r"\s*\(at (?:line (\d+), column (\d+)|end of document)\)$")
_POINTED = re.compile(r"\d\.\d+\s*=")
_UNWRITTEN = "a pipe into which nothing writes; name a file, or '-' for standard input"
_SILENT = "a pipe whose writer has sent nothing for {:.0f} s and keeps it open; name a file instead"


@expecting(SceneError, path=PATH, changes=TABLE)
def load_scene(path: str | os.PathLike[str], changes: Mapping[str, Any] | None = None) -> Scene:
    """Read a scene file.

    Parameters
    ----------
    path : path-like
        A TOML file in UTF-8 of at most a megabyte; ``"-"`` is standard input.
    changes : mapping of str to value, optional
        Values that replace those of the scene or are added: ``{"system.parameters.eta": 0.5}``. They become part of the
        scene's text.

    Returns
    -------
    Scene
        With ``system``, built on first use, and ``analyses``, which `run` runs.

    Raises
    ------
    SceneError
        If the file cannot be read, or if the scene has faults: all of them, each with its line, field and remedy.
    SettingsError
        If the key or the value of a change is not valid TOML.
    """
    piped = os.fspath(path) == STDIN
    name = PIPED if piped else Path(path).name or str(path)
    data = _read_stdin() if piped else _read_file(path)
    if len(data) > TUNING.bytes:
        raise SceneError(f"{name if piped else path}: larger than {TUNING.bytes} bytes; a scene is a small text file")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        found = format_of_bytes(data[:512])
        if found and "text" not in found:
            way = "name a small text file, as 'chaosdrill new' prints one"
            if data.startswith(HDF5):
                way = "the attribute 'scene' of an archive holds the text, and 'chaosdrill verify' runs it again"
            raise SceneError(f"{name}: {found}, not a scene; {way}") from None
        line = data.count(b"\n", 0, fault.start) + 1
        raise SceneError(f"{name}:{line}: not UTF-8 text; save the scene as UTF-8") from None
    return parse_scene(text, name, changes)


def _read_file(path: str | os.PathLike[str]) -> bytes:
    try:
        # the opening of a pipe does not wait for its other end
        with open(path, "rb", opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK)) as file:
            if stat.S_ISFIFO(os.fstat(file.fileno()).st_mode):
                return _read_pipe(file.fileno())
            os.set_blocking(file.fileno(), True)
            return file.read(TUNING.bytes + 1)
    except (OSError, ValueError) as fault:
        reason = reason_of(fault)
        first, line_break, _ = str(path).partition("\n")
        if line_break:
            reason = f"{reason}; if this is a scene's text, write it to a file, as by pathlib.Path.write_text"
        raise SceneError(f"{first:.200}: cannot read the scene: {reason}") from None


def _read_pipe(handle: int) -> bytes:
    """What a pipe holds until its writers close it; an OSError if there are none, or if they are silent."""
    data = b""
    while len(data) <= TUNING.bytes:
        try:
            piece = os.read(handle, TUNING.bytes + 1 - len(data))
        except BlockingIOError:
            if not select.select([handle], [], [], TUNING.silence_s)[0]:
                raise OSError(errno.ETIMEDOUT, _SILENT.format(TUNING.silence_s)) from None
            continue
        if not piece:
            break
        data += piece
    if not data:
        raise OSError(errno.EPIPE, _UNWRITTEN)
    return data


def _read_stdin() -> bytes:
    # a process that was started with it closed has no standard input
    if sys.stdin is None:
        raise SceneError(f"{PIPED}: cannot read the scene: standard input is closed")
    try:
        return sys.stdin.buffer.read(TUNING.bytes + 1)
    except OSError as fault:
        raise SceneError(f"{PIPED}: cannot read the scene: {reason_of(fault)}") from None


@expecting(SceneError, text=TEXT, name=TEXT, changes=TABLE)
def parse_scene(text: str, name: str = "scene.toml", changes: Mapping[str, Any] | None = None) -> Scene:
    """Read a scene from its text.

    Parameters
    ----------
    text : str
        A TOML document.
    name : str
        Name of the file in error messages; without its suffix, the default title of the scene.
    changes : mapping of str to value, optional
        As for `load_scene`.

    Returns
    -------
    Scene
        With ``system``, built on first use, and ``analyses``, which `run` runs.

    Raises
    ------
    SceneError
        With every fault, one per line.
    SettingsError
        As `load_scene`.
    """
    # what checks it is worth its import only once there is a scene
    from chaosdrill.scene.checks import check_analyses, check_document, check_numerics, check_system, table_in

    name = name_text(name)
    raw = _parse_toml(text, name)
    lines = key_lines(text)
    for key, value in (changes or {}).items():
        text, path = change(text, key, value)
        raw = _parse_toml(text, name)
        _place_change(lines, path)
    if problems := list(_beyond_doubles(raw)):
        raise InvalidSceneError(name, problems, lines)
    system = check_system(table_in(raw, "system"))
    problems = check_document(raw, system)
    numerics, faults = check_numerics(table_in(raw, "numerics"))
    analyses, more = check_analyses(table_in(raw, "analysis"), system)
    if "system" in raw:
        problems += system.problems
    problems += faults + more
    if problems:
        raise InvalidSceneError(name, problems, lines)
    return Scene(
        name=name,
        text=text,
        title=raw.get("title") or Path(name).stem,
        model=system.model,
        definition=system.definition,
        drives=system.drives,
        noise=system.noise,
        symmetry=system.symmetry,
        effects=system.effects,
        parameters=system.parameters,
        initial=system.initial,
        si=system.si,
        numerics=numerics,
        analyses=analyses,
        lines=lines,
        changes={key: toml_value(value, f"--set {key}") for key, value in (changes or {}).items()},
    )


def _place_change(lines: dict[KeyPath, int], path: KeyPath) -> None:
    """Place a key, and the tables that it creates, on no line of the file."""
    for inner in [place for place in lines if place[: len(path)] == path]:
        del lines[inner]
    for depth in range(1, len(path)):
        lines.setdefault(path[:depth], NO_LINE)
    lines[path] = NO_LINE


def _fault_of_key(key: str) -> str:
    """Why a dotted key is too long, or a number has too many digits; empty if neither."""
    if len(re.findall(NAME, key)) > TUNING.key_parts:
        return f"a key of more than {TUNING.key_parts} parts"
    if len(key) > TUNING.digits and re.fullmatch(r"[+-]?(?:0[xob])?[0-9a-fA-F_]+", key):
        return f"a number of {len(key)} digits; write it as a double with an exponent, such as 1e20, or shorter"
    return ""


class _Vanishing(str):
    """The digits of a number that is not 0, and nearer to it than any double."""


def _beyond_doubles(raw: Any, path: KeyPath = ()) -> Iterator[Problem]:
    """Numbers that no machine has, each at its place."""
    if isinstance(raw, dict | list):
        for key, value in raw.items() if isinstance(raw, dict) else enumerate(raw):
            yield from _beyond_doubles(value, (*path, key))
    elif isinstance(raw, _Vanishing):
        yield Problem(path, f"{raw:.40} {VANISHES}")
    elif isinstance(raw, int) and not -(2**63) <= raw < 2**63:
        text = f"an integer of {len(str(abs(raw)))} digits; integers of TOML are from -2**63 to 2**63 - 1"
        yield Problem(path, f"{text}; write a number with a point or an exponent, such as 1e20")


def _parse_toml(text: str, name: str) -> dict[str, Any]:
    for found in _TOKEN.finditer(text):
        key = found["key"] or ""
        if len(key) > TUNING.key_parts and (fault := _fault_of_key(key)):
            line = text.count("\n", 0, found.start()) + 1
            raise SceneError(f"{name}:{line}: {fault}")
    try:
        return tomllib.loads(text, parse_float=lambda digits: (_Vanishing if vanishes(digits) else float)(digits))
    except RecursionError:
        raise SceneError(f"{name}: invalid TOML: nested too deeply") from None
    except ValueError as fault:
        message = str(fault)
        place = _PLACE.search(message)
        line = int(place[1]) if place and place[1] else text.count("\n") + 1 if place else 1
        message = _PLACE.sub("", message) + (f" (column {place[2]})" if place and place[2] else "")
        way = "; text stands in quotes" if message.startswith("Invalid value") else ""
        if message.startswith("Cannot overwrite") and _POINTED.search(text.split("\n")[line - 1]):
            way = "; a number with a point stands in quotes as a key"
        raise SceneError(f"{name}:{line}: invalid TOML: {message}{way}") from None
