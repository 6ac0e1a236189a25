"""Spoilt scenes: checked by the command line, and some of them run."""

import json
import math
import re
import string
import tomllib
from zlib import crc32

import judge
import trees
from values import HOSTILE, NUMBERS, OTHERS, OWNED, PLAUSIBLE, TOKEN, expression

name, ending = "scene", ".toml"
SOUND = ("0",)
RUN_ONE_IN = 60
"""How many inputs that are checked come on one that is also run."""

PATIENCE_S = 1.5
SET = "# --set "
"""A line of an input that begins so is an argument of the command."""


def seeds(folder):
    """The corpus holds all."""
    return []


def prepare(folder):
    """Have everything loaded that scenes need."""


def attempt(data, folder, guard):
    """Check a scene, and run it if it is its turn."""
    scene, output = folder / "in" / "scene.toml", folder / "out" / "out.nc"
    scene.write_bytes(data)
    lines = data.decode(errors="replace").splitlines()
    sets = [part for line in lines if line.startswith(SET) for part in ("--set", line.removeprefix(SET))]
    as_json = ["--json"] if crc32(data) % 2 else []
    with guard.watching():
        code, wrong = judge.command(["check", scene, *as_json, *sets], (0, 2))
    if code == 0 and crc32(data) % RUN_ONE_IN == 0:
        arguments = ["run", scene, "-o", output, "--json", *sets]
        watching = guard.watching(folder / "out")
        code, found = judge.command_apart(arguments, (0, 1, 2, 130), folder, PATIENCE_S, watching)
        wrong += found
        if output.exists() != (code == 0) and not (code == 130 and output.exists()):
            wrong.append(f"run: exit code {code}, and the archive says otherwise")
        left = {path.name for path in (folder / "out").iterdir()} - {"out.nc"}
        if left and code != 130:
            wrong.append(f"run: left {sorted(left)}")
    if scene.read_bytes() != data:
        wrong.append("the scene was changed")
    return str(code), wrong


def mutate(data, chance, other):
    """A scene that is spoilt in one of many ways."""
    text = data.decode(errors="replace")
    for _ in range(chance.choice([1, 1, 1, 2, 3])):
        found = chance.choice(WAYS)(text, chance, other.decode(errors="replace"))
        if isinstance(found, bytes):
            return found
        text = found
    return text.encode(errors="replace")


def _bytes(text, chance, _):
    data = bytearray(text.encode(errors="replace"))
    for _ in range(chance.choice([1, 1, 2, 4, 32])):
        at = chance.randrange(len(data) + 1)
        data[at : at + chance.randrange(3)] = chance.randbytes(chance.randrange(3))
    return bytes(data)


def _truncated(text, chance, _):
    return text.encode(errors="replace")[: chance.randrange(len(text) + 1)]


def _replaced(text, chance, pattern, new):
    """The text with one of the places that fit a pattern exchanged."""
    found = list(re.finditer(pattern, text))
    if not found:
        return text
    place = chance.choice(found)
    return text[: place.start()] + new(place.group()) + text[place.end() :]


def _value(text, chance, new):
    return _replaced(text, chance, r'(?<== )("[^"]*"|[-\d.e]+)', lambda _: new)


def _number(text, chance, _):
    return _value(text, chance, chance.choice(NUMBERS))


def _plausible(text, chance, _):
    """Numbers that may be allowed, but are far from what one would give."""
    return _value(text, chance, chance.choice(PLAUSIBLE))


def _other_type(text, chance, _):
    return _value(text, chance, chance.choice(OTHERS))


def _hostile(text, chance, _):
    return _value(text, chance, f'"{chance.choice(HOSTILE)}"')


def _nested(text, chance, _):
    depth = chance.choice([3, 50, 300, 1000, 30_000])
    opening, closing = chance.choice([("[", "]"), ("{ a = ", " }"), ("[{ a = ", " }]")])
    if chance.random() < 0.3:
        return text + f"[{'.'.join(['a'] * depth)}]\nb = 1\n"
    return _value(text, chance, opening * depth + "1" + closing * chance.choice([depth, depth - 1]))


def _doubled(text, chance, _):
    lines = text.splitlines() or [""]
    line = chance.choice(lines)
    lines.insert(chance.randrange(len(lines) + 1), chance.choice([line, line, line.upper(), line.replace("=", ".x =")]))
    return "\n".join(lines)


def _reordered(text, chance, other):
    lines = text.splitlines() + other.splitlines()[: chance.randrange(20)]
    for _ in range(chance.choice([1, 2, 10])):
        if lines:
            lines.insert(chance.randrange(len(lines)), lines.pop(chance.randrange(len(lines))))
    return "\n".join(lines[chance.randrange(3) :])


def _renamed(text, chance, _):
    words = re.findall(r"\w+", text) or ["x"]
    return _replaced(
        text,
        chance,
        r"[A-Za-z_]\w*",
        lambda old: chance.choice([old[::-1], "", OWNED, chance.choice(words), f'"{chance.choice(HOSTILE)[:60]}"']),
    )


def _expression(text, chance, _):
    """A text that may be an expression, with pieces of it exchanged."""
    return _replaced(text, chance, r'(?<=")[^"\n]+(?=")', lambda old: expression(old, chance).replace('"', ""))


def _token(text, chance, _):
    """A piece of the text that stands somewhere else in it, or is left out."""
    tokens = TOKEN.findall(text[:20_000]) or [""]
    at = chance.randrange(len(tokens))
    tokens[at : at + chance.choice([0, 1, 1, 3])] = chance.choice(
        [[], [chance.choice(tokens)], [chance.choice(NUMBERS)]]
    )
    return "".join(tokens)


def _tree(text, chance, other):
    """A scene of other values, written anew."""
    try:
        tree = tomllib.loads(text)
        changed = trees.mutated(tree, chance, tomllib.loads(other) if chance.random() < 0.5 else None)
    except (ValueError, RecursionError):
        return text
    return "".join(f"{_quoted(key)} = {_written(entry)}\n" for key, entry in changed.items())


def _written(value):
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_quoted(k)} = {_written(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_written, value)) + "]"
    if isinstance(value, bool) or value is None:
        return str(value).lower()
    if isinstance(value, int):
        return str(value) if abs(value) < 10**400 else "1" * 400
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else str(value)
    return _quoted(value) if isinstance(value, str) else str(value)


def _quoted(text):
    return json.dumps(str(text).encode(errors="replace").decode(), ensure_ascii=False)


def _set(text, chance, _):
    """An argument that sets a value of the scene, and makes little sense."""
    key = chance.choice(
        ["system.parameters.eta", "system", "analysis.motion.periods", "a.b.c", "'", "", "system.model.x", "é"]
    )
    garbage = "".join(chance.choices(string.printable, k=chance.randrange(12))).replace("\0", "")
    value = chance.choice([*NUMBERS, *OTHERS, *HOSTILE, garbage, garbage])
    return f"{SET}{key}={value}\n{text}"


WAYS = (
    *(_bytes, _truncated, _number, _plausible, _other_type, _hostile, _nested, _doubled, _reordered, _renamed),
    *(_expression, _expression, _expression, _token, _tree, _tree, _tree, _set),
)
