"""Links of the README and of the documentation lead somewhere, addresses outside have their form, formulas end."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [
    ROOT / "README.md",
    ROOT / "CHANGELOG.md",
    *sorted(page for page in (ROOT / "docs").rglob("*.md") if "_build" not in page.parts),
    *sorted(page for page in (ROOT / "studies").glob("*/*.md") if page.parent.name != "out"),
]
LINK = re.compile(r"!?\[([^\]\[]*)\]\(([^()\s]+(?:\([^()\s]*\)[^()\s]*)*)\)")
DOI = re.compile(r"10\.\d{4,9}/\S+")


def prose(page):
    """Text of a page without its code."""
    text = re.sub(r"^(`{3,}).*?^\1$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    return re.sub(r"`[^`\n]*`", "code", text)


def anchors(page):
    """Anchors of a page as GitHub and MyST make them of headings."""
    titles = re.findall(r"^#{1,6} (.+)$", page.read_text(encoding="utf-8"), flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.strip().lower()).replace(" ", "-") for title in titles}


def links(page):
    """Text and target of every link."""
    return LINK.findall(prose(page))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_within_the_repository_lead_to_a_file_and_an_anchor(page):
    wrong = []
    for _, target in links(page):
        if "://" in target or target.startswith("mailto:"):
            continue
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        # these pages are made when the documentation is built
        made = file.parent.name == "generated"
        if not made and (not file.exists() or (anchor and anchor not in anchors(file))):
            wrong.append(target)
    assert not wrong


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_addresses_are_https_and_identifiers_are_those_of_their_text(page):
    for text, target in links(page):
        if "://" not in target:
            continue
        assert target.startswith("https://")
        if "doi.org" in target:
            assert target.startswith("https://doi.org/")
            doi = target.removeprefix("https://doi.org/")
            assert DOI.fullmatch(doi)
            said = text.removeprefix("doi:")
            assert said == doi or not said.startswith("10.")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_formulas_in_a_paragraph_are_closed(page):
    paragraphs = re.split(r"\n\s*\n", re.sub(r"\$\$.*?\$\$", "", prose(page), flags=re.DOTALL))
    assert [text for text in paragraphs if len(re.findall(r"(?<!\\)\$", text)) % 2] == []
