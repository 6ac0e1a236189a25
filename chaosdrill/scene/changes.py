"""Set values of a scene from outside: the text is changed, so that the archive holds the scene that was run.

A value replaces the existing one; a missing key is added to its table. The rest of the text, comments included, stays
as it is. The result is read again and compared: tomlkit 0.15 would write another document after 1 in 100 random
changes, among them any that adds a table between dotted keys.
"""

import json
import math
import re
import tomllib
from collections.abc import Iterator, Mapping
from typing import Any

from chaosdrill.errors import SettingsError
from chaosdrill.names import shown
from chaosdrill.scene.lines import BARE, DOTTED, NAME, Positions, layout
from chaosdrill.scene.tuning import TUNING
from chaosdrill.settings import KeyPath, too_long
from chaosdrill.units import VANISHES, vanishes

_KEY = re.compile(rf"\s*{DOTTED}\s*")
_NUMBER = re.compile(r"[0-9]{1,9}")


def parse_change(text: str) -> tuple[str, Any]:
    """Read a change as the command line gives it: its key, and its value as `tomllib` gives it.

    It is ``KEY=VALUE`` with a dotted key and a value as in TOML: ``system.parameters.eta=0.5``. Anything that is not a
    TOML value and does not begin like a quoted or bracketed one is text: ``numerics.method=rk4``, ``system.si.m1=250
    kg``.

    Raises `SettingsError` if it cannot be read.
    """
    found = _KEY.match(text)
    if found is not None and text.startswith("[", found.end()):
        raise SettingsError(
            f"--set {text!r:.100}: name an entry of a list after a dot, by its index from 0 or by its name, as "
            "in --set system.definition.transitions.impact.guard=x"
        )
    if found is None or not text.startswith("=", found.end()):
        raise SettingsError(f"--set {text!r:.100}: expected KEY=VALUE, as in --set system.parameters.eta=0.5")
    given = text[found.end() + 1 :].strip()

    def number(digits: str) -> float:
        if vanishes(digits):
            raise SettingsError(f"--set {text!r:.100}: {digits:.40} {VANISHES}")
        return float(digits)

    try:
        document = tomllib.loads(f"value = {given}", parse_float=number)
    except (ValueError, RecursionError):
        if not given or given[0] in "\"'[{" or not given.isprintable():
            raise SettingsError(f"--set {text!r:.100}: {given!r:.60} is not a TOML value") from None
        return found.group().strip(), given
    if len(document) > 1:
        raise SettingsError(f"--set {text!r:.100}: contains more than one value; use one --set for each")
    return found.group().strip(), document["value"]


def change(text: str, key: str, value: Any) -> tuple[str, KeyPath]:
    """Set one value in the text of a scene; return the text with it, and the parts of its key.

    ``text``: a document that ``tomllib.loads`` accepts. ``key``: a dotted one, as ``system.parameters.eta``. Entries of
    lists go by their number from 0, or by the ``name`` that they hold: ``system.definition.transitions.impact.guard``.
    ``value``: also a list or a table; arrays count as lists.

    Raises `SettingsError` if the key is invalid, or passes through a value that is not a table, or if TOML has no such
    value.
    """
    path: KeyPath = _path(key)
    text = text.replace("\r\n", "\n")
    wanted = tomllib.loads(text)
    path = _into_lists(path, wanted, key)
    _put(wanted, path, key, tomllib.loads(f"value = {toml_value(value, f'--set {key}')}")["value"])
    for changed in _candidates(text, path, toml_value(value, f"--set {key}")):
        try:
            # not compared as dictionaries, since nan differs from itself
            if repr(_sorted(tomllib.loads(changed))) == repr(_sorted(wanted)):
                return changed, path
        except tomllib.TOMLDecodeError:
            continue
    raise SettingsError(f"--set {key}: cannot be set in a scene with this layout; write it into the file")


def toml_value(value: Any, place: str) -> str:
    """A value as TOML writes it, on one line; errors begin with its ``place``.

    Raises `SettingsError` if TOML has no such value.
    """
    if told := too_long(value):
        raise SettingsError(f"{place}: {told}")
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int) and abs(value) >= 2**63:
        raise SettingsError(f"{place}: integers must be below 2**63")
    if isinstance(value, int | float):
        return repr(value) if math.isfinite(value) else str(value)
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, list | tuple):
        return "[" + ", ".join(toml_value(entry, place) for entry in value) + "]"
    if isinstance(value, Mapping):
        pairs = (f"{bare_or_quoted(str(name))} = {toml_value(entry, place)}" for name, entry in value.items())
        return "{ " + ", ".join(pairs) + " }" if value else "{}"
    raise SettingsError(f"{place}: expected a number, text, a list or a table, received {shown(value):.60}")


def _path(key: str) -> tuple[str, ...]:
    found = _KEY.fullmatch(key)
    if found is None or len(parts := re.findall(NAME, key)) > TUNING.key_parts_set:
        raise SettingsError(f"--set {key!r:.100}: expected a dotted key, as in system.parameters.eta")
    try:
        return tuple(next(iter(tomllib.loads(f"{part} = 0"))) for part in parts)
    except ValueError:
        raise SettingsError(f"--set {key!r:.100}: TOML has no such key") from None


def _into_lists(path: KeyPath, document: Any, key: str) -> KeyPath:
    """The path with the indices of list entries, which a key gives by number or name."""
    found: KeyPath = ()
    part: Any
    for part in path:
        if isinstance(document, list):
            names = [entry.get("name") if isinstance(entry, dict) else None for entry in document]
            if part in names:
                part = names.index(part)
            elif _NUMBER.fullmatch(part) and int(part) < len(document):
                part = int(part)
            else:
                named = ", ".join(name for name in names if isinstance(name, str))
                ways = f"by its number, from 0 to {len(document) - 1}" if document else "in the file, since it is empty"
                ways += f", or by its name: {named:.200}" if named else ""
                raise SettingsError(f"--set {key}: {'.'.join(map(str, found))} is a list; name an entry {ways}")
        found = (*found, part)
        if isinstance(document, dict):
            document = document.get(part)
        else:
            document = document[part] if isinstance(document, list) else None
    return found


def _put(table: Any, path: KeyPath, key: str, value: Any) -> None:
    *tables, last = path
    for depth, name in enumerate(tables, start=1):
        table = table[name] if isinstance(name, int) else table.setdefault(name, {})
        if not isinstance(table, dict | list):
            place = ".".join(map(str, path[:depth]))
            raise SettingsError(f"--set {key}: {place} is not a table but {shown(table):.60}")
    before = table[last] if isinstance(last, int) else table.get(last)
    if isinstance(before, dict) and not isinstance(value, dict):
        raise SettingsError(
            f"--set {key}: is a table; set the keys in it, as in --set {key}.{next(iter(before), 'name')}=..."
        )
    table[last] = value


def _candidates(text: str, path: KeyPath, value: str) -> Iterator[str]:
    """Candidate texts with the value, the plainest first."""
    found: Positions = layout(text)
    if path in found.values:
        start, end = found.values[path]
        yield text[:start] + value + text[end:]
        return
    parent = path[:-1]
    if parent and parent not in found.below and parent not in found.inside:
        header = ".".join(bare_or_quoted(str(name)) for name in parent)
        yield f"{text.rstrip()}\n\n[{header}]\n{bare_or_quoted(str(path[-1]))} = {value}\n"
    for depth in range(len(parent), -1, -1):
        place, pair = path[:depth], f"{'.'.join(bare_or_quoted(str(name)) for name in path[depth:])} = {value}"
        if place in found.inside:
            at = found.inside[place]
            empty = text[at:].lstrip(" \t").startswith("}")
            yield f"{text[:at]} {pair}{'' if empty else ','}{text[at:]}"
        elif place in found.below:
            at = text.find("\n", found.below[place])
            yield f"{text}\n{pair}\n" if at < 0 else f"{text[: at + 1]}{pair}\n{text[at + 1 :]}"
        elif not place:
            yield f"{pair}\n{text}"


def _sorted(value: Any) -> Any:
    if isinstance(value, dict):
        return sorted((name, _sorted(entry)) for name, entry in value.items())
    return [_sorted(entry) for entry in value] if isinstance(value, list) else value


def bare_or_quoted(name: str) -> str:
    """A key as TOML writes it."""
    return name if re.fullmatch(BARE, name) else _quoted(name)


def _quoted(text: str) -> str:
    # TOML wants one control character more escaped than JSON does, and knows no surrogates
    return json.dumps(text.encode(errors="replace").decode(), ensure_ascii=False).replace("\x7f", "\\u007f")
