"""The page: what it is made of, how it is written, and how large it becomes."""

import base64
import hashlib
import os
import re
import tomllib
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from support.archives import chart, diagram
from support.pages import read

import chaosdrill
import chaosdrill as cd
from chaosdrill.archive import save
from chaosdrill.errors import ArchiveError, SettingsError
from chaosdrill.reports.charts import explorer_data
from chaosdrill.reports.tuning import TUNING

# The page as text: well formed, complete in itself, and readable without eyes.


@pytest.fixture
def page(written):
    return read(written.path)


def test_nothing_is_loaded(page):
    for element in page.all():
        for name in ("src", "href", "srcset", "action", "data", "poster"):
            value = element.attributes.get(name)
            assert value is None or value.startswith(("#", "data:")), (element.tag, name)
    assert "url(" not in "".join(style.text for style in page.all("style"))


def test_the_policy_names_the_only_script_and_style(page):
    policy = next(m.attributes["content"] for m in page.all("meta") if "http-equiv" in m.attributes)
    for tag in ("script", "style"):
        (own,) = (e for e in page.all(tag) if "type" not in e.attributes)
        digest = base64.b64encode(hashlib.sha256(own.text.encode()).digest()).decode()
        assert f"{tag}-src 'sha256-{digest}'" in policy
    assert "default-src 'none'" in policy
    assert not [e for e in page.all() for name in e.attributes if name == "style" or name.startswith("on")]


def test_landmarks(page):
    tags = [element.tag for element in page.all("header", "nav", "main", "footer")]
    assert tags == ["header", "nav", "main", "footer"]
    assert next(page.all("html")).attributes["lang"] == "en"
    assert next(page.all("title")).text == "A hitting oscillator"


def test_headings_go_down_one_level_at_a_time(page):
    levels = [int(heading.tag[1]) for heading in page.all("h1", "h2", "h3", "h4", "h5", "h6")]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(after <= before + 1 for before, after in pairwise(levels))


def test_ids_are_unique_and_what_is_named_exists(page):
    ids = [element.attributes["id"] for element in page.all() if "id" in element.attributes]
    assert len(ids) == len(set(ids))
    for element in page.all():
        for name in ("aria-labelledby", "aria-describedby"):
            assert element.attributes.get(name, ids[0]) in ids
        if element.attributes.get("href", "").startswith("#"):
            assert element.attributes["href"][1:] in ids


def test_pictures_say_what_they_show(page):
    pictures = list(page.all("img"))
    assert len(pictures) >= 4
    for picture in pictures:
        # groups that are called as their pictures are not called twice
        assert re.match(r"[A-Z][^:]*(diagram|map|chart): .{10,}", picture.attributes["alt"])
        assert not re.search(r"(\w+) of \1\b", picture.attributes["alt"])


def test_tables_have_captions_and_scopes(page):
    tables = list(page.all("table"))
    assert len(tables) > 8
    for table in tables:
        assert table.children[0].tag == "caption"
        assert table.children[0].text
        columns = [cell.attributes["scope"] for cell in table.children[1].all("th")]
        assert set(columns) == {"col"}
        for row in table.children[2].all("tr"):
            assert [cell.tag for cell in row.children] == ["th", *["td"] * (len(columns) - 1)]
            assert row.children[0].attributes["scope"] == "row"


def test_what_scrolls_can_be_reached_by_keyboard(page):
    for element in page.all("div", "pre"):
        if element.tag == "pre" or element.attributes.get("class") == "scroll":
            assert element.attributes["tabindex"] == "0"


# What the page is made of is installed with the package, and escapes what is put into it.


ROOT = Path(chaosdrill.__file__).parent


def test_every_asset_is_package_data():
    project = ROOT.parent / "pyproject.toml"
    patterns = tomllib.loads(project.read_text())["tool"]["setuptools"]["package-data"]["chaosdrill"]
    packaged = {path for pattern in patterns for path in ROOT.glob(pattern)}
    others = {p for p in ROOT.rglob("*") if p.is_file() and p.suffix != ".py" and "__pycache__" not in p.parts}
    assert others <= packaged
    assert {path.suffix for path in packaged} >= {".html", ".css", ".js"}


def test_no_template_lets_text_through_as_it_is():
    for template in (ROOT / "reports" / "templates").iterdir():
        written = template.read_text(encoding="utf-8")
        assert not re.search(r"\|\s*safe\b|autoescape", written), template.name
        # an attribute without quotes would end at the first blank
        assert not re.search(r"=\s*\{\{", re.sub(r"\{%.*?%\}", "", written)), template.name


# A report is written whole or not at all, and only where a page belongs.


@pytest.fixture
def archive(tree, tmp_path):
    return save(tree, tmp_path / "result.nc")


def test_default_name_is_beside_the_archive(archive):
    assert cd.report(archive).path == archive.with_suffix(".html")


def test_the_same_archive_gives_the_same_page(archive, tmp_path):
    one, two = (cd.report(archive, tmp_path / f"{name}.html").path.read_bytes() for name in "ab")
    assert one == two


def test_a_full_disk_leaves_the_earlier_page(archive, monkeypatch):
    page = cd.report(archive).path
    before = page.read_bytes()

    def half(self, data):
        with open(self, "wb") as stream:
            stream.write(data[:1000])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", half)
    with pytest.raises(ArchiveError, match="No space left on device; an earlier file is unchanged"):
        cd.report(archive)
    assert page.read_bytes() == before
    assert sorted(os.listdir(page.parent)) == ["result.html", "result.nc"]


def test_the_archive_itself_is_never_the_target(archive):
    before = archive.read_bytes()
    with pytest.raises(SettingsError, match=r"does not end with \.html"):
        cd.report(archive, archive)
    assert archive.read_bytes() == before


def test_a_folder_that_does_not_exist(archive, tmp_path):
    with pytest.raises(ArchiveError, match="does not exist"):
        cd.report(archive, tmp_path / "no" / "page.html")


# A chart in a page has a bounded size, and says what was left out of it.


def test_small_ones_are_whole():
    data, left_out = explorer_data(diagram())
    assert left_out == []
    section = np.frombuffer(base64.b64decode(data["section"]["values"]), dtype="<f4").reshape(11, 1, 8, 2)
    np.testing.assert_array_equal(section, diagram()["section"].values.astype("f4"))
    exponents = next(q for q in data["quantities"] if q["name"] == "lyapunov_exponent")
    held = np.frombuffer(base64.b64decode(exponents["values"]), dtype="<f4").reshape(11, 1, 2)
    np.testing.assert_array_equal(held, diagram()["lyapunov_exponent"].values.astype("f4"))


def test_large_charts_are_thinned_and_say_so():
    data, left_out = explorer_data(chart(1200, 900).drop_vars("section"))
    assert left_out == ["Of 1200 x 900 points this chart holds 600 x 450, one in 2 each way; the archive has all."]
    zeta = np.frombuffer(base64.b64decode(data["axes"][0]["values"]))
    np.testing.assert_array_equal(zeta, np.linspace(0.1, 0.4, 1200)[::2])
    held = sum(len(text) for text in (data["outcome"], data["period"], *(q["values"] for q in data["quantities"])))
    assert held < 4 / 3 * TUNING.grid_bytes


def test_of_long_sections_the_last_points_are_kept():
    data, left_out = explorer_data(diagram(200, 8001))
    assert left_out == ["Of 8001 section points of each run this chart holds the last 3750."]
    assert len(data["section"]["values"]) <= 4 / 3 * TUNING.section_bytes
    section = np.frombuffer(base64.b64decode(data["section"]["values"]), dtype="<f4").reshape(200, 3750, 2)
    # the last of 8001 points of a cycle of two is its first one
    assert section[0, -1, 0] == -0.125


def test_points_stand_in_ascending_order():
    data, _ = explorer_data(chart().isel(zeta=[2, 0, 3, 1]))
    assert np.all(np.diff(np.frombuffer(base64.b64decode(data["axes"][0]["values"]))) > 0)
    assert list(np.frombuffer(base64.b64decode(data["period"]), dtype="<i2")) == [
        n for n in (1, 2, 3, 4) for _ in range(3)
    ]


def test_many_charts_share_what_a_page_holds():
    data, _ = explorer_data(chart(1200, 900), 0.25)
    held = sum(len(text) for text in (data["outcome"], data["period"], *(q["values"] for q in data["quantities"])))
    assert 0.1 * TUNING.grid_bytes < held < 0.25 * 4 / 3 * TUNING.grid_bytes
    whole, part = (explorer_data(diagram(200, 8001), share)[0]["section"]["iterates"] for share in (1.0, 0.25))
    assert part == whole // 4
