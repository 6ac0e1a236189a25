"""From a file to a scene, or to all that is wrong with it."""

import os
import re
import tomllib
from pathlib import Path
from typing import Any

from chaosdrill.errors import SceneError
from chaosdrill.scene.lines import key_lines
from chaosdrill.scene.problems import InvalidSceneError
from chaosdrill.scene.scene import Scene

MOST_BYTES = 1_000_000
MOST_KEY_PARTS = 64

# tomllib takes time that grows with the square of the length of a dotted key
_DOTTED = re.compile(r"""[A-Za-z0-9_"'-][ \t]*+\.""")
_PLACE = re.compile(r"\s*\(at (?:line (\d+), column (\d+)|end of document)\)$")


def load_scene(path: str | os.PathLike[str]) -> Scene:
    """Read a scene file.

    Parameters
    ----------
    path : path-like
        A TOML file in UTF-8 of at most a megabyte.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        If the file cannot be read, or with every fault that the scene has, each with its line, field and remedy.
    """
    name = Path(path).name or str(path)
    try:
        with open(path, "rb") as file:
            data = file.read(MOST_BYTES + 1)
    except (OSError, ValueError) as fault:
        reason = fault.strerror if isinstance(fault, OSError) else fault
        raise SceneError(f"{path}: cannot read the scene: {reason}") from None
    if len(data) > MOST_BYTES:
        raise SceneError(f"{path}: larger than {MOST_BYTES} bytes; a scene is a small text file")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        line = data.count(b"\n", 0, fault.start) + 1
        raise SceneError(f"{name}:{line}: not UTF-8 text; save the scene as UTF-8") from None
    return parse_scene(text, name)


def parse_scene(text: str, name: str = "scene.toml") -> Scene:
    """Read a scene from its text.

    Parameters
    ----------
    text : str
        A TOML document.
    name : str
        What error messages call the file; without its ending, it is the title of a scene that has none.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        With every fault, one a line.
    """
    # pydantic is worth its import only once there is a scene to validate
    from chaosdrill.scene.check_analyses import check_analyses, check_numerics
    from chaosdrill.scene.check_system import check_system, table_in
    from chaosdrill.scene.document import Document
    from chaosdrill.scene.strict import validate

    raw = _parse_toml(text, name)
    lines = key_lines(text)
    _, problems = validate(Document, raw, ())
    system = check_system(table_in(raw, "system"))
    numerics, faults = check_numerics(table_in(raw, "numerics"))
    analyses, more = check_analyses(table_in(raw, "analysis"), system)
    if "system" in raw:
        problems += system.problems
    problems += faults + more
    if problems or numerics is None:
        raise InvalidSceneError(name, problems, lines)
    return Scene(
        name=name,
        text=text,
        title=raw.get("title") or Path(name).stem,
        model=system.model,
        effects=system.effects,
        parameters=system.parameters,
        initial=system.initial,
        scales=system.scales,
        numerics=numerics,
        analyses=analyses,
        lines=lines,
    )


def _parse_toml(text: str, name: str) -> dict[str, Any]:
    for number, content in enumerate(text.split("\n"), start=1):
        for part in re.split(r"[=,{]", content):
            if part.count(".") > MOST_KEY_PARTS and len(_DOTTED.findall(part)) > MOST_KEY_PARTS:
                raise SceneError(f"{name}:{number}: a key of more than {MOST_KEY_PARTS} parts")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise SceneError(f"{name}: invalid TOML: nested too deeply") from None
    except ValueError as fault:
        message = str(fault)
        found = _PLACE.search(message)
        line = int(found[1]) if found and found[1] else text.count("\n") + 1 if found else 1
        message = _PLACE.sub("", message) + (f" (column {found[2]})" if found and found[2] else "")
        raise SceneError(f"{name}:{line}: invalid TOML: {message}") from None
