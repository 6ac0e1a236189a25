"""Code on a page fits its width, and a page that would load from the network is told."""

import re
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [page for page in sorted((ROOT / "docs").rglob("*.md")) if not {"_build", "generated"} & set(page.parts)]
FENCE = re.compile(r"^```(\S*)[^\n]*\n(?:---\n.*?^---\n)?(.*?)^```$", re.MULTILINE | re.DOTALL)
# columns of a block of code on a page of the theme's width
WIDTH = 88


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_lines_of_code_fit_the_page(page):
    blocks = FENCE.findall(page.read_text(encoding="utf-8"))
    code = [text for language, text in blocks if language in ("{code-cell}", "python", "sh", "toml")]
    assert [line for text in code for line in text.splitlines() if len(line) > WIDTH] == []


@pytest.mark.parametrize(
    ("page", "loaded"),
    [
        ('<script defer="defer" src="https://cdn.example/mathjax.js"></script>', ["https://cdn.example/mathjax.js"]),
        ('<link rel="stylesheet" type="text/css" href="//fonts.example/a.css">', ["//fonts.example/a.css"]),
        ('<link href="https://fonts.example/b.css" rel="stylesheet">', ["https://fonts.example/b.css"]),
        ('<script src="_static/mathjax/tex-chtml.js"></script><a href="https://doi.org/10.1/x">x</a>', []),
    ],
)
def test_what_a_page_loads_from_the_network_is_found(page, loaded):
    assert runpy.run_path(str(ROOT / "docs" / "_ext" / "offline.py"))["addresses"](page) == loaded
