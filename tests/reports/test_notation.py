"""A system as its equations: names are text, whatever they hold, and what is written says the same as the system."""

import re
from html.parser import HTMLParser

import pytest
import sympy

import chaosdrill as cd

HOSTILE = "a<script>alert(1)<script>$\\input{passwd}$%#&^~"


@pytest.fixture(scope="module")
def strange():
    x, v, force = sympy.symbols(["x", HOSTILE, "force"], real=True)
    hit = cd.Transition(
        f"hit {HOSTILE}", source="free_flight", target="free_flight", guard=x - 1, direction=1, reset={v: -v}
    )
    return cd.HybridSystem(
        name=HOSTILE,
        description=HOSTILE,
        states=(x, v),
        parameters={"force": 2.0},
        modes={"free_flight": {x: v, v: force - x}},
        transitions=[hit],
        labels={"x": HOSTILE},
    )


class Tags(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.found, self.text = set(), ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.found.add(tag)

    def handle_data(self, data):
        self.text += data


def test_names_are_text_in_html(strange):
    page = Tags(strange._repr_html_())
    assert "script" not in page.found
    assert {"math", "mfrac", "table"} <= page.found
    assert page.text.count(HOSTILE) > 5


def test_names_are_text_in_latex(strange):
    written = strange._repr_latex_()
    assert written.startswith("$$\\begin{aligned}\n")
    inside = written[2:-2]
    commands = set(re.findall(r"\\([A-Za-z]+)", inside))
    assert commands == {"begin", "end", "frac", "mathrm", "backslash", "wedge", "sim", "to", "nearrow"}
    # what TeX reads as more than a letter is escaped everywhere, and braces and columns are in order
    assert re.search(r"(?<!\\)[$%#~^_]", inside) is None
    depth = 0
    for brace in re.findall(r"(?<!\\)[{}]", inside):
        depth += 1 if brace == "{" else -1
        assert depth >= 0
    assert depth == 0
    assert [len(re.findall(r"(?<!\\)&", line)) for line in inside.splitlines()[1:-1]] == [1] * 6
    assert r"\mathrm{force} - x" in inside


def test_symbols_are_set_as_such():
    written = cd.build("impact-oscillator")._repr_latex_()
    assert (
        r"\frac{\mathrm{d}v}{\mathrm{d}t} &= \mathrm{amplitude} \cos{\left(\omega t \right)} - 2 v \zeta - x" in written
    )
    assert r"x - \mathrm{wall} &\nearrow 0" in written or r"- \mathrm{wall} + x &\nearrow 0" in written


def test_large_systems_are_not_written_out():
    x = sympy.symbols("x:300", real=True)
    system = cd.HybridSystem(name="many", states=x, parameters={}, modes={"all": {s: -s for s in x}})
    assert system._repr_html_() is None
    assert system._repr_latex_() is None
