"""Who searches for a task by the words of the field finds a guide whose heading has them; the index has every guide."""

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
GUIDES = sorted(page for page in (DOCS / "howto").glob("*.md") if page.stem != "index")


def headings(page):
    return " ".join(re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), flags=re.MULTILINE)).lower()


@pytest.mark.parametrize(
    "words",
    [
        "power spectrum",
        "recurrence plot",
        "return map",
        "strobe",
        "phase",
        "both directions",
        "drift",
        "unstable orbit",
        "exponent",
        "diagram",
    ],
)
def test_a_guide_has_the_words_in_a_heading(words):
    assert [page.name for page in GUIDES if words in headings(page)]


def test_stroboscopic_sections_are_explained_on_a_guide():
    assert [page.name for page in GUIDES if "stroboscopic" in page.read_text(encoding="utf-8").lower()]


def test_every_guide_is_in_the_index_once():
    listed = re.search(r"```\{toctree\}\n(?::.*\n)*\n(.*?)```", (DOCS / "howto" / "index.md").read_text(), re.DOTALL)
    assert sorted(listed[1].split()) == [page.stem for page in GUIDES]
