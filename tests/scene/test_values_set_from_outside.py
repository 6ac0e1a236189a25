"""A value that is set from outside: exactly that key changes, and no other text."""

import tomllib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chaosdrill.errors import SettingsError
from chaosdrill.scene.changes import change, parse_change, toml_value


@pytest.mark.parametrize(
    ("text", "key", "value", "expected"),
    [
        ("a = 1 # one\nb = 2\n", "a", 0.5, "a = 0.5 # one\nb = 2\n"),
        ("a = 1", "b", 2, "b = 2\na = 1"),
        ("[t]\na = 1\n", "t.b", True, "[t]\nb = true\na = 1\n"),
        ("[t] # here", "t.b", "x", '[t] # here\nb = "x"\n'),
        ("t = { a = 1 }\n", "t.b", 2, "t = { b = 2, a = 1 }\n"),
        ("t = {}\n", "t.b", 2, "t = { b = 2}\n"),
        ("t = { a = 1 }\n", "t.a", [1, 2], "t = { a = [1, 2] }\n"),
        ("t.a = 1\n", "t.b", 2, "t.b = 2\nt.a = 1\n"),
        ("[t]\nu.a = 1\n", "t.u.b", 2, "[t]\nu.b = 2\nu.a = 1\n"),
        ("[t.u]\na = 1\n", "t.v.b", 2, "[t.u]\na = 1\n\n[t.v]\nb = 2\n"),
        ("[t.u]\na = 1\n", "t.b", 2, "[t.u]\na = 1\n\n[t]\nb = 2\n"),
        ("a = 1\r\nb = 2\r\n", "b", 3, "a = 1\nb = 3\n"),
        ('a = """\nx = 1\n"""\nx = 1\n', "x", 2, 'a = """\nx = 1\n"""\nx = 2\n'),
        ("a = [ # list\n 1,\n 2 ]\n", "a", {"b": 1}, "a = { b = 1 }\n"),
        ("a = 1\n", '"b c"."d.e"', 2, 'a = 1\n\n["b c"]\n"d.e" = 2\n'),
        ("a = nan\n", "b", 1, "b = 1\na = nan\n"),
        ("a = [1, 2]\n", "a.1", 3, "a = [1, 3]\n"),
        ("[[a]]\nname = 'c'\nb = 1\n[[a]]\nb = 1\n", "a.1.b", 2, "[[a]]\nname = 'c'\nb = 1\n[[a]]\nb = 2\n"),
        ("[[a]]\nname = 'c'\nb = 1\n[[a]]\nb = 1\n", "a.c.b", 2, "[[a]]\nname = 'c'\nb = 2\n[[a]]\nb = 1\n"),
        ("[[a]]\nname = 'c'\n", "a.c.d", 2, "[[a]]\nd = 2\nname = 'c'\n"),
        ("a.b = 1\nb = 'x'\n", "a.c.d", 2, "a.b = 1\nb = 'x'\n\n[a.c]\nd = 2\n"),
        ("b.c = {}\nc = 1\n", "b.d.e", 2, "b.c = {}\nc = 1\n\n[b.d]\ne = 2\n"),
        ("a = [{ b = 1 }]\n", "a.0.d.e", 2, "a = [{ d.e = 2, b = 1 }]\n"),
    ],
)
def test_where_a_value_goes(text, key, value, expected):
    assert change(text, key, value)[0] == expected


@pytest.mark.parametrize(
    ("text", "key", "message"),
    [
        ("a = 1", "a.b", "a is not a table but 1"),
        ("[[a]]\nb = 1", "a.b", "a is a list; name an entry by its number, from 0 to 0"),
        ("[[a]]\nname = 'c'", "a.b", "or by its name: c"),
        ("a = []", "a.0", "a is a list; name an entry in the file"),
        ("a = [1]", "a.1", "from 0 to 0"),
        ("a = [1]", "a.0.b", "a.0 is not a table but 1"),
        ("a.b = 1", "a", "is a table; set the keys in it, as in --set a.b="),
        ("a = 1", "", "expected a dotted key"),
        ("a = 1", "a b", "expected a dotted key"),
        ("a = 1", '"\\q"', "TOML has no such key"),
        ("a = 1", ".".join("abcdefghijklmnopqrstuvwxyz"), "expected a dotted key"),
    ],
)
def test_where_no_value_goes(text, key, message):
    with pytest.raises(SettingsError, match="--set") as caught:
        change(text, key, 2)
    assert message in str(caught.value)


@pytest.mark.parametrize("value", [None, object(), 1 + 2j, [None], {"a": None}])
def test_what_toml_does_not_have(value):
    with pytest.raises(SettingsError, match="expected a number, text, a list or a table"):
        change("", "a", value)


def test_a_whole_number_that_toml_does_not_have():
    with pytest.raises(SettingsError, match="integers must be below 2"):
        change("", "a", 10**5000)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("a=1", 1),
        (" a = 1e-3 ", 1e-3),
        ("a=true", True),
        ("a=True", "True"),
        ("a=250 kg", "250 kg"),
        ('a="1"', "1"),
        ("a=[1, 2]", [1, 2]),
        ("a={b = 1}", {"b": 1}),
        ("a=x=y", "x=y"),
        ("a=1 # one", 1),
    ],
)
def test_values_of_the_command_line(text, value):
    assert parse_change(text) == ("a", value)


def test_arrays_are_lists():
    assert toml_value(np.linspace(0, 1, 3), "a") == "[0.0, 0.5, 1.0]"
    assert toml_value(np.float64(0.1), "a") == "0.1"


NAMES = st.sampled_from(["a", "b", "c", "d e", 'q"', "ß"])
SCALARS = st.one_of(
    st.booleans(), st.integers(-(2**63), 2**63 - 1).filter(lambda n: abs(n) < 2**63), st.floats(), st.text(max_size=8)
)
VALUES = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(NAMES, inner, max_size=3), max_leaves=6
)


@st.composite
def documents(draw):
    """A document of tables with headers, inline tables and dotted keys, and a path in it."""
    lines = []
    tree = draw(st.dictionaries(NAMES, st.dictionaries(NAMES, VALUES, max_size=3) | SCALARS, max_size=4))
    later = []
    for name, entry in tree.items():
        key = toml_value({name: 0}, "")[2:-5].strip()
        form = draw(st.sampled_from(["header", "inline", "dotted"])) if isinstance(entry, dict) and entry else "value"
        if form == "header":
            later += [f"[{key}] # {name!r}", *(toml_value({k: v}, "")[2:-2] for k, v in entry.items())]
        elif form == "dotted":
            lines += [f"{key}.{toml_value({k: v}, '')[2:-2]}" for k, v in entry.items()]
        else:
            lines.append(f"{key} = {toml_value(entry, '')} # {name!r}")
    path = draw(st.lists(NAMES, min_size=1, max_size=3))
    return "\n".join(lines + later) + draw(st.sampled_from(["", "\n"])), path


@settings(max_examples=120)
@given(document=documents(), value=VALUES)
def test_nothing_else_changes(document, value):
    text, path = document
    key = ".".join(toml_value({name: 0}, "")[2:-5].strip() for name in path)
    try:
        changed, parts = change(text, key, value)
    except SettingsError:
        return
    assert list(parts) == path
    after, wanted = tomllib.loads(changed), tomllib.loads(text)
    table = wanted
    for name in path[:-1]:
        table = table.setdefault(name, {})
    table[path[-1]] = tomllib.loads(f"x = {toml_value(value, '')}")["x"]

    def plain(entry):
        return sorted((k, plain(v)) for k, v in entry.items()) if isinstance(entry, dict) else entry

    assert repr(plain(after)) == repr(plain(wanted))
