"""What stands on the page is what stands in the archive."""

import hashlib
import json
import tracemalloc

import netCDF4
import numpy as np
import pytest
from support.archives import SCENE, diagram
from support.pages import read

import chaosdrill as cd
from chaosdrill.reports import charts, tables


@pytest.fixture
def page(written):
    return read(written.path)


def rows(page, caption):
    """Cells of the table with this caption, row by row."""
    (table,) = (t for t in page.all("table") if t.children[0].text == caption)
    return [[cell.text for cell in row.children] for row in table.children[2].all("tr")]


def test_result_counts_what_was_written(written):
    assert written.groups == ("diagram", "chart")
    assert written.charts == 2
    assert written.pictures == len(list(read(written.path).all("img")))
    assert written.faults == ()
    assert written.bytes == written.path.stat().st_size


def test_scene_text_and_hash_of_the_archive(written, page):
    assert next(page.all("pre")).text == SCENE
    digest = hashlib.sha256(written.archive.read_bytes()).hexdigest()
    assert ["SHA-256", digest] in rows(page, "The archive's file")


def test_every_attribute_of_every_group_is_told(written, page):
    for name, group in cd.open(written.archive).children.items():
        told = dict(rows(page, f"Attributes of {name}"))
        expected = {k: str(v) for k, v in group.attrs.items() if k != "versions"}
        assert told == expected
    assert rows(page, "Versions") == [["numpy", "2.0"]]


def test_equations_are_those_that_check_prints(page):
    from chaosdrill.scene import parse_scene
    from chaosdrill.scene.describe import describe_scene

    told = describe_scene(parse_scene(SCENE))
    plain = [math.attributes["alttext"] for math in page.all("math")]
    for rates in told["modes"].values():
        for left, right in rates.items():
            assert f"{left} = {right}" in plain
    for event in told["events"].values():
        assert event["guard"] in plain
        assert all(f"{state} := {value}" in plain for state, value in event["reset"].items())


def test_outcomes_come_with_their_advice(page):
    tables = [t for t in page.all("table") if t.children[0].text == "Outcomes"]
    first = [[cell.text for cell in row.children] for row in tables[0].children[2].all("tr")]
    assert first == [
        ["periodic", "10", "90.9 %", cd.Outcome.PERIODIC.advice],
        ["escaped", "1", "9.09 %", cd.Outcome.ESCAPED.advice],
    ]


def test_stretches_of_the_same_motion(page):
    (caption,) = (t.children[0].text for t in page.all("table") if t.children[0].text.startswith("Motions along"))
    assert rows(page, caption) == [["2", "2.9", "period 2", "10", "−2"], ["3", "3", "escaped", "1", "–"]]


def test_accuracy_has_a_row_for_each_analysis(page):
    first, second = rows(page, "Accuracy and cost")
    assert first[0] == "diagram"
    assert first[2] == "1e−12"
    assert first[6] == "0.0025"
    assert second[0] == "chart"


def test_what_to_cite_is_what_the_archive_cites(written, page):
    (section,) = (s for s in page.all("section") if s.attributes["id"] == "citations")
    entries = [item.text for item in section.all("li")]
    assert entries == [reference.text() for reference in cd.cite(written.archive)]
    assert len(entries) > 1


def test_values_that_were_altered_are_told(written, tmp_path):
    path = tmp_path / "copy.nc"
    path.write_bytes(written.archive.read_bytes())
    told = [dict(rows(read(written.path), "The archive's file"))["values"]]
    with netCDF4.Dataset(path, "a") as file:
        file["diagram/period"][3] = 7
    made = cd.report(path)
    assert made.altered == ("diagram period",)
    told.append(dict(rows(read(made.path), "The archive's file"))["values"])
    assert told == [
        "as they were written, by the digests of all variables",
        "altered since they were written: diagram period",
    ]


def test_without_a_scene_the_equations_are_those_of_the_definition(write, tree):
    del tree.attrs["scene"]
    page = read(write(tree).path)
    assert "holds no scene" in page.text
    shown = {formula.attributes["alttext"] for formula in page.all("math")}
    assert {"dx/dt = v", "v := -e*v", "-wall + x", "T = 2*pi/omega"} <= shown
    assert ["diagram", "tolerance", "1e-12"] in rows(page, "Arguments")


def test_numbers_in_which_analyses_differ_are_told_beside_the_equations(write, tree):
    del tree.attrs["scene"]
    parameters = json.loads(tree["chart"].attrs["parameters"])
    tree["chart"].attrs["parameters"] = json.dumps(parameters | {"zeta": 0.25})
    page = read(write(tree).path)
    assert rows(page, "Other numbers") == [["chart", "zeta", "0.25"]]
    assert [f.attributes["alttext"] for f in page.all("math")].count("v := -e*v") == 1


def test_without_a_definition_either_the_page_says_so(write, tree):
    del tree.attrs["scene"]
    for node in tree.children.values():
        del node.attrs["definition"]
    page = read(write(tree).path)
    assert "holds no scene and no definition" in page.text
    assert not list(page.all("math"))
    parameters = {row[2]: row[3] for row in rows(page, "Parameters")}
    assert parameters == {k: str(v) for k, v in json.loads(tree["chart"].attrs["parameters"]).items()}


def test_scene_of_another_version_hides_nothing_else(write, tree):
    tree.attrs["scene"] = SCENE.replace("impact-oscillator", "no-such-system")
    made = write(tree)
    page = read(made.path)
    assert made.faults == ()
    assert "unknown" in page.text
    assert "no-such-system" in next(page.all("pre")).text
    assert made.charts == 2


def test_a_large_variable_that_no_chart_shows_is_not_copied():
    ds = diagram().assign(more=("other", np.zeros(2_000_000)))
    charts.explorer(ds, "diagram", 1)  # what is imported does not count
    tracemalloc.start()
    try:
        charts.explorer(ds, "diagram", 1)
        tables.intervals(ds)
        assert tracemalloc.get_traced_memory()[1] < ds["more"].nbytes / 4
    finally:
        tracemalloc.stop()
