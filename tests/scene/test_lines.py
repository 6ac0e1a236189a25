"""Each key of a TOML document is found on the line where it stands."""

import json
import tomllib

from hypothesis import given
from hypothesis import strategies as st

from chaosdrill.scene.lines import key_lines

DOCUMENT = '''\
# a comment with [brackets] = 1
title = """two
[not.a.table]
lines with \\""" in them"""
"quoted key"."with \\u0041" = 1
[a . b]
x = [ # 1
  1, "]",
  [2, 3,
   4], { y = 1, z = { w = [1,
   2] } },
]
d.e = 'x # y'
when = 1979-05-27 07:32:00 # a blank inside the value
[[p]]
n = 1
[p.sub]
m = 2
[[p]]
s = \'\'\'
n = 4
\'\'\'\'\'
l = 5
'''


def test_every_form_of_a_key():
    assert key_lines(DOCUMENT) == {
        ("title",): 2,
        ("quoted key",): 5,
        ("quoted key", "with A"): 5,
        ("a",): 6,
        ("a", "b"): 6,
        ("a", "b", "x"): 7,
        ("a", "b", "x", 0): 8,
        ("a", "b", "x", 1): 8,
        ("a", "b", "x", 2): 9,
        ("a", "b", "x", 2, 0): 9,
        ("a", "b", "x", 2, 1): 9,
        ("a", "b", "x", 2, 2): 10,
        ("a", "b", "x", 3): 10,
        ("a", "b", "x", 3, "y"): 10,
        ("a", "b", "x", 3, "z"): 10,
        ("a", "b", "x", 3, "z", "w"): 10,
        ("a", "b", "x", 3, "z", "w", 0): 10,
        ("a", "b", "x", 3, "z", "w", 1): 11,
        ("a", "b", "d"): 13,
        ("a", "b", "d", "e"): 13,
        ("a", "b", "when"): 14,
        ("p",): 15,
        ("p", 0): 15,
        ("p", 0, "n"): 16,
        ("p", 0, "sub"): 17,
        ("p", 0, "sub", "m"): 18,
        ("p", 1): 19,
        ("p", 1, "s"): 20,
        ("p", 1, "l"): 23,
    }


def test_windows_line_ends():
    assert key_lines("a = 1\r\n\r\n[b]\r\nc = 2\r\n") == {("a",): 1, ("b",): 3, ("b", "c"): 4}


texts = st.text(st.characters(codec="utf-8", exclude_characters="\x7f", exclude_categories=("Cs", "Cc")), max_size=8)
values = st.recursive(
    st.integers(-9, 9) | st.booleans() | texts,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(texts, inner, max_size=3),
    max_leaves=12,
)


def inline(value):
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{inline(key)} = {inline(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[\n" + "".join(f"  {inline(item)}, # ]\n" for item in value) + "]"
    return json.dumps(value, ensure_ascii=False)


def paths(value, at=()):
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        yield (*at, key)
        yield from paths(item, (*at, key))


@given(st.dictionaries(texts, values, max_size=5))
def test_no_key_is_missed_and_none_invented(document):
    text = "\n".join(f"{inline(key)} = {inline(value)}" for key, value in document.items())
    assert set(key_lines(text)) == set(paths(tomllib.loads(text)))
