"""Whatever stands in an archive is shown as text: no element, no attribute and no script comes out of it."""

import json

import numpy as np
import pytest
import sympy
import xarray as xr
from archives import chart, diagram
from pages import parsed, read

import chaosdrill as cd
from chaosdrill.reports.equations import equations, events

BAD = (
    """</script></title></style><script>window.hacked = 1</script><img src=x onerror="window.hacked = 2">'"&amp;<!--"""
)


def hostile():
    """Every text of an archive is an attack."""
    groups = {}
    for name, dataset in (("diagram", diagram()), ("chart<b>", chart())):
        dataset = dataset.assign_coords(state_name=("state", [BAD, "v"]), state_long_name=("state", ["", BAD]))
        dataset = dataset.assign_coords(seed_name=("seed", [BAD]))
        for variable in dataset.variables.values():
            variable.attrs |= {"long_name": BAD, "comment": BAD, "units": BAD}
        kept = {"kind": dataset.attrs["kind"]}
        dataset.attrs = {**dict.fromkeys(dataset.attrs, BAD), "a" + BAD.replace("/", ""): BAD, "message": BAD, **kept}
        groups[name] = dataset
    root = {"title": BAD, "scene": BAD, "scene_name": BAD, "history": BAD, "versions": json.dumps({BAD: BAD})}
    return xr.DataTree.from_dict({"/": xr.Dataset(attrs=root), **groups})


@pytest.fixture
def made(write):
    return write(hostile(), "hostile<i>'")


def test_elements_are_those_of_a_harmless_page(made):
    page = read(made.path)
    scripts = list(page.all("script"))
    assert [s.attributes.get("type") for s in scripts if "type" in s.attributes] == ["application/json"] * made.charts
    assert len(scripts) == made.charts + 1
    assert {image.attributes["src"][:11] for image in page.all("img")} <= {"data:image/"}
    assert not [e for e in page.all() for name in e.attributes if name.startswith("on")]
    assert not list(page.all("b", "i"))


def test_the_texts_are_there_to_be_read(made):
    page = read(made.path)
    assert next(page.all("h1")).text == BAD
    assert next(page.all("pre")).text == BAD
    data = json.loads(next(s for s in page.all("script") if "type" in s.attributes).text)
    assert data["states"][0]["name"] == BAD


def test_no_script_of_the_archive_runs(made, visit):
    browser = visit(made.path)
    assert browser.execute_script("return window.hacked === undefined")
    assert browser.execute_script("return document.querySelectorAll('.stage:not([hidden])').length") == made.charts
    assert [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"] == []


def test_letters_that_are_not_seen_are_shown_by_their_codes(write, tree):
    tree.attrs["title"] = "safe\u202egnp.exe\x07\ufeff"
    assert next(read(write(tree).path).all("h1")).text == "safe\\u202egnp.exe\\u0007\\ufeff"


def test_attributes_of_other_types(write, tree):
    odd = {"versions": 3, "history": np.arange(3), "scene": 1.5, "title": ["a", "b"]}
    tree.attrs |= odd
    tree["diagram"].attrs |= {"settings": "[", "parameters": "[" * 5000, "tolerance": "x", "wall_time_s": "y"}
    made = write(tree)
    assert made.path.stat().st_size > 10_000
    assert any("could not convert string" in fault for fault in made.faults)
    assert "Not everything could be shown" in read(made.path).text


def test_numbers_that_belong_to_no_code(write, tree):
    tree["diagram"]["outcome"][:] = 99
    tree["diagram"]["period"][:] = -7
    page = read(write(tree).path)
    assert "code 99" in page.text


def test_long_texts_are_cut_and_say_so(write, tree):
    tree.attrs["comment"] = "x" * 1_000_000
    made = write(tree)
    assert made.bytes < 1_000_000
    assert "980000 more characters" in read(made.path).text


@pytest.mark.parametrize(
    "name",
    [
        "<img src=x onerror=alert(1)>",
        "&#60;img src=x onerror=alert(1)&#62;",
        "<meta http-equiv=refresh content='0;url=data:,'>",
        "<style>*{display:none}<&#47;style>",
        "&lt;b&gt;",
        "a'\"b",
        "q0q",
    ],
)
def test_names_in_equations_are_text(name):
    """Every symbol in turn: the same kinds of elements, and the name to be read."""
    harmless = ("x", "v", "t", "w")
    plain = page_of(harmless)
    for place in range(4):
        found = page_of([name if i == place else word for i, word in enumerate(harmless)])
        assert {e.tag for e in found.all()} == {e.tag for e in plain.all()}
        assert name in [e.text for e in found.all("mi")]


def page_of(names):
    x, v, t, w = (sympy.Symbol(name, real=True) for name in names)
    system = cd.HybridSystem(
        name="oscillator",
        states=(x, v),
        time=t,
        parameters={w.name: 2.0},
        modes={"free": {x: v, v: sympy.cos(w * t) - x * v}},
        transitions=[
            cd.Transition("hit", "free", "free", guard=x - w, direction=1, reset={v: -v * w}, condition=v > w * x)
        ],
        period=2 * sympy.pi / w,
        quadratures={"work": v * w},
    )
    return parsed(f"<main>{equations(system)}{events(system)}</main>")
