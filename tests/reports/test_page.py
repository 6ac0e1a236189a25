"""The page as text: well formed, complete in itself, and readable without eyes."""

import base64
import hashlib
import re
from itertools import pairwise

import pytest
from support.pages import read


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
        assert re.match(r"[A-Z].* of (diagram|chart): .{10,}", picture.attributes["alt"])


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
