"""Whatever stands in an archive is shown as text: no element, no attribute and no script comes out of it."""

import json

import numpy as np
import pytest
import sympy
import xarray as xr
from markupsafe import Markup
from support.archives import chart, diagram
from support.pages import parsed, read

import chaosdrill as cd
from chaosdrill.reports.origin import system_part

BAD = (
    """</script></title></style><script>window.hacked = 1</script><img src=x onerror="window.hacked = 2">'"&amp;<!--"""
)
REFRESH = "<meta http-equiv=refresh content=0;url=other.html>"
AWAY = (
    f"""'"></title></style></script></text>{REFRESH}<base href=x:><link rel=prefetch href=other.html><iframe src=y>"""
)


def hostile(bad=BAD):
    """Every text of an archive is an attack."""
    groups = {}
    for name, dataset in (("diagram", diagram()), ("chart<b>", chart())):
        dataset = dataset.assign_coords(state=[bad, "v"], state_long_name=("state", ["", bad]))
        dataset = dataset.assign_coords(seed=[bad])
        for variable in dataset.variables.values():
            variable.attrs |= {"long_name": bad, "comment": bad, "units": bad}
        kept = {"kind": dataset.attrs["kind"]}
        dataset.attrs = {**dict.fromkeys(dataset.attrs, bad), "a" + bad.replace("/", ""): bad, "message": bad, **kept}
        groups[name] = dataset
    root = {"title": bad, "scene": bad, "scene_name": bad, "history": bad, "versions": json.dumps({bad: bad})}
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


def asked(browser):
    """What the page has asked for since it was opened, itself included; a refresh without a delay is due at once."""
    browser.execute_async_script("setTimeout(arguments[0], 500)")
    events = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    urls = [e["params"]["request"]["url"] for e in events if e["method"] == "Network.requestWillBeSent"]
    return [url for url in urls if not url.startswith("data:")]


def renamed(bad):
    """A system in which everything is called by an attack."""
    names = [f"{bad}{k}" for k in range(3)]
    x, v = (sympy.Symbol(name, real=True) for name in names[:2])
    bounce = cd.Transition(names[2], bad, bad, guard=x, direction=-1, reset={v: -v})
    return cd.HybridSystem(
        name=bad,
        states=(x, v),
        parameters={},
        modes={bad: {x: v, v: -x}},
        transitions=[bounce],
        initial={x: 1.0},
        description=bad,
    )


def test_no_text_leads_away_from_the_page(write, visit, tmp_path):
    (tmp_path / "other.html").write_text("<title>another page</title>")
    tree = hostile(AWAY)
    # a name holds no slash
    system = renamed(AWAY.replace("/", ""))
    cd.save_scene(tmp_path / "scene.toml", system, {"motion": {"kind": "trajectory", "duration": 1}})
    tree.attrs["scene"] = (tmp_path / "scene.toml").read_text(encoding="utf-8")
    made = write(tree, "away")
    # the equations are there, so that their names are on the page
    assert "<math" in made.path.read_text(encoding="utf-8")
    browser = visit(made.path)
    assert asked(browser) == [made.path.as_uri()]
    assert browser.current_url == made.path.as_uri()


def test_a_refresh_would_be_followed_so_that_no_page_with_one_is_written(write, tree, visit, tmp_path, monkeypatch):
    other = tmp_path / "other.html"
    other.write_text("<title>another page</title>")
    page = write(tree).path
    page.write_text(page.read_text(encoding="utf-8").replace("<main", f"{REFRESH}<main"), encoding="utf-8")
    visit(page)
    browser = visit(page)
    assert asked(browser)[-1] == browser.current_url == other.as_uri()
    before = page.read_bytes()
    monkeypatch.setattr("chaosdrill.reports.html.TEMPLATES.finalize", Markup)
    with pytest.raises(cd.ArchiveError, match="an element meta, which no page may"):
        write(hostile(AWAY))
    assert page.read_bytes() == before


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
    return parsed(f"<main>{system_part(system, {})}</main>")
