"""Pages, links and docstrings: what is quick to check of the documentation."""

import builtins
import inspect
import re
import runpy
import symtable
from pathlib import Path

import pytest

import chaosdrill
import chaosdrill as cd
from chaosdrill import errors
from chaosdrill.analysis.registry import FUNCTIONS as NAMES_FUNCTIONS

# Code on a page fits its width, and a page that would load from the network is found.


ROOT = Path(__file__).parents[2]

PAGES = [page for page in sorted((ROOT / "docs").rglob("*.md")) if not {"_build", "generated"} & set(page.parts)]

FENCE = re.compile(r"^```(\S*)[^\n]*\n(?:---\n.*?^---\n)?(.*?)^```$", re.MULTILINE | re.DOTALL)

# columns of a block of code on a page of the theme's width
WIDTH = 88


def faults(pages, wrong):
    """What ``wrong`` finds on pages, by page."""
    assert pages
    return {str(page.relative_to(ROOT)): found for page in pages if (found := wrong(page))}


def test_lines_of_code_fit_the_page():
    def long(page):
        blocks = FENCE.findall(page.read_text(encoding="utf-8"))
        code = [text for language, text in blocks if language in ("{code-cell}", "python", "sh", "toml")]
        return [line for text in code for line in text.splitlines() if len(line) > WIDTH]

    assert faults(PAGES, long) == {}


def test_every_picture_says_what_it_shows():
    def silent(page):
        blocks = re.findall(r"^```{code-cell}[^\n]*\n(.*?)^```$", page.read_text("utf-8"), re.MULTILINE | re.DOTALL)
        drawn = [cell for cell in blocks if re.search(r"cd\.plot\(|plt\.subplots\(|^Image\(", cell, re.MULTILINE)]
        return [cell for cell in drawn if not re.search(r"^    alt: \S", cell, re.MULTILINE)]

    assert faults(PAGES, silent) == {}


def test_pictures_of_every_page_are_turned_around_on_a_dark_one():
    style = (ROOT / "docs" / "_static" / "pages.css").read_text(encoding="utf-8")
    assert re.findall(r"(\S+ img) \{ filter: invert", style) == ["article img", "article img"]


GALLERY = ROOT / "docs" / "gallery"


@pytest.mark.parametrize(
    "page", [page for page in PAGES if page.parent == GALLERY and page.stem != "index"], ids=lambda page: page.stem
)
def test_pictures_of_the_gallery_have_captions(page):
    text = page.read_text(encoding="utf-8")
    alternatives, captions = (re.findall(rf"^    {key}: \S", text, flags=re.MULTILINE) for key in ("alt", "caption"))
    assert len(captions) == len(alternatives) > 0
    # a thumbnail shows its caption on a page that loads no scripts for formulas
    assert "$" not in "".join(re.findall(r"^    caption: >-\n((?:      .*\n)+)", text, flags=re.MULTILINE))
    assert (GALLERY / "index.md").read_text(encoding="utf-8").split().count(page.stem) == 2


@pytest.mark.parametrize(
    ("page", "loaded"),
    [
        ('<script defer="defer" src="https://cdn.example/mathjax.js"></script>', ["https://cdn.example/mathjax.js"]),
        ('<link rel="stylesheet" type="text/css" href="//fonts.example/a.css">', ["//fonts.example/a.css"]),
        ('<link href="https://fonts.example/b.css" rel="stylesheet">', ["https://fonts.example/b.css"]),
        ("<link rel=preconnect href='https://fonts.example'>", ["https://fonts.example"]),
        ("<style>@import 'https://fonts.example/c.css'; p { margin: 0; }</style>", ["https://fonts.example/c.css"]),
        ("@font-face { src: url( //fonts.example/d.woff2 ); }", ["//fonts.example/d.woff2"]),
        ("a { background: url(data:image/svg+xml;utf8,//); } /* https://licence.example */", []),
        ('<script src="_static/mathjax/tex-chtml.js"></script><a href="https://doi.org/10.1/x">x</a>', []),
    ],
)
def test_what_a_page_loads_from_the_network_is_found(page, loaded):
    assert runpy.run_path(str(ROOT / "docs" / "_ext" / "offline.py"))["addresses"](page) == loaded


# Links of the README and of the documentation lead somewhere, addresses outside have their form, formulas end.


LINKS_PAGES = [
    ROOT / "README.md",
    ROOT / "CHANGELOG.md",
    *sorted(page for page in (ROOT / "docs").rglob("*.md") if "_build" not in page.parts),
    *sorted(page for page in (ROOT / "studies").glob("*/*.md") if page.parent.name != "out"),
]

LINK = re.compile(r"!?\[([^\]\[]*)\]\(([^()\s]+(?:\([^()\s]*\)[^()\s]*)*)\)")

DOI = re.compile(r"10\.\d{4,9}/\S+")

NAMED = re.compile(r"`((?:tests|studies|chaosdrill)/[\w/]+\.\w+)`")


def test_files_that_a_page_names_are_there():
    def missing(page):
        named = NAMED.findall(page.read_text(encoding="utf-8"))
        return [name for name in named if not (ROOT / name).exists() and "/out/" not in name]

    assert faults(LINKS_PAGES, missing) == {}


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


def test_links_within_the_repository_lead_to_a_file_and_an_anchor():
    def dead(page):
        for _, target in links(page):
            if "://" in target or target.startswith("mailto:"):
                continue
            path, _, anchor = target.partition("#")
            file = (page.parent / path).resolve() if path else page
            # these pages are made when the documentation is built
            made = file.parent.name == "generated"
            if not made and (not file.exists() or (anchor and anchor not in anchors(file))):
                yield target

    assert faults(LINKS_PAGES, lambda page: [*dead(page)]) == {}


def test_addresses_are_https_and_identifiers_are_those_of_their_text():
    def right(text, target):
        doi, said = target.removeprefix("https://doi.org/"), text.removeprefix("doi:")
        if "doi.org" in target:
            return target != doi and DOI.fullmatch(doi) and (said == doi or not said.startswith("10."))
        return target.startswith("https://")

    def wrong(page):
        return [target for text, target in links(page) if "://" in target and not right(text, target)]

    assert faults(LINKS_PAGES, wrong) == {}


def test_formulas_in_a_paragraph_are_closed():
    def open_ones(page):
        paragraphs = re.split(r"\n\s*\n", re.sub(r"\$\$.*?\$\$", "", prose(page), flags=re.DOTALL))
        return [text for text in paragraphs if len(re.findall(r"(?<!\\)\$", text)) % 2]

    assert faults(LINKS_PAGES, open_ones) == {}


# Docstrings of public functions name the arguments that there are, in their order, and say what comes back.


FUNCTIONS = [name for name in cd.__all__ if inspect.isfunction(getattr(cd, name))]


def section(text, title):
    """Lines of one section of a numpydoc docstring."""
    found = re.search(rf"^{title}\n-+\n(.*?)(?=^\w[^\n]*\n-+\n|\Z)", text, flags=re.MULTILINE | re.DOTALL)
    return found[1] if found else ""


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_docstring_has_the_arguments_of_the_signature(name):
    function = getattr(cd, name)
    text = inspect.getdoc(function)
    named = re.findall(r"^(\*{0,2}\w+(?:, \w+)*) : .*\n    \S", section(text, "Parameters"), flags=re.MULTILINE)
    stars = {inspect.Parameter.VAR_KEYWORD: "**", inspect.Parameter.VAR_POSITIONAL: "*"}
    expected = [stars.get(p.kind, "") + p.name for p in inspect.signature(function).parameters.values()]
    assert ", ".join(named).split(", ") == expected
    assert re.search(r"^    \S", section(text, "Returns"), flags=re.MULTILINE)
    assert section(text, "Raises")


# The check that runs the examples of the documentation fails where an example does.


EXECUTED = Path(__file__).parents[2] / "docs" / "_ext" / "executed.py"


@pytest.fixture(scope="module")
def check():
    return runpy.run_path(str(EXECUTED))


@pytest.mark.parametrize(
    "example",
    [
        "```python\nx = 1\nassert x == 2\n```",
        "```python\nx = 1\n```\n\n```sh\nfalse\n```",
        "```sh\npython3 studies/run.py nothing\n```",
        '```toml\n[analysis.orbit]\nkind = "periodic-orbit"\nperiods = 2\n```',
        "    chaosdrill run scene.toml\n",
    ],
)
def test_an_example_that_fails_is_told_with_its_page(check, tmp_path, example):
    page = tmp_path / "page.md"
    page.write_text(f"# A page\n\n{example}\n", encoding="utf-8")
    (fault,) = check["faults_of"](page)
    assert str(page) in fault


def test_examples_share_names_and_files_and_marked_ones_are_left_out(check, tmp_path):
    page = tmp_path / "page.md"
    page.write_text(
        "```python\nnumber = 3\nopen('note.txt', 'w').close()\n```\n\n```sh\n# not run: it would fail\nfalse\n```\n\n"
        "```sh\ntest -f note.txt\n```\n\n```python\nassert number == 3\n```\n",
        encoding="utf-8",
    )
    assert check["faults_of"](page) == []


def undefined(check, page):
    """Names that an example of a page reads, and neither it nor an earlier one has made."""
    prelude = ROOT / "docs" / "_examples" / page.stem / "prelude.py"
    texts = [prelude.read_text(encoding="utf-8")] if prelude.is_file() else []
    texts += [block.text for block in check["blocks"](page) if block.language == "python"]
    made, missing = set(dir(builtins)), set()
    for text in texts:
        table = symtable.symtable(text, str(page), "exec")
        made |= {one.get_name() for one in table.get_symbols() if one.is_assigned() or one.is_imported()}
        missing |= {one.get_name() for one in table.get_symbols() if one.is_referenced()} - made
    return missing


def test_examples_know_the_names_that_they_read(check, tmp_path):
    assert {page.stem: found for page in check["pages"]() if (found := undefined(check, page))} == {}
    # names of notebook cells are not among them
    page = tmp_path / "page.md"
    page.write_text("```{code-cell} python\nx = 1\n```\n\n```python\nprint(x)\n```\n", encoding="utf-8")
    assert undefined(check, page) == {"x"}


# The page of the Python interface has every public name, and no other.


PAGE = Path(__file__).parents[2] / "docs" / "api.md"


def test_the_page_has_the_public_names():
    text = PAGE.read_text(encoding="utf-8")
    shown = set(re.findall(r"^\.\. auto(?:function|class):: chaosdrill\.(\w+)$", text, flags=re.MULTILINE))
    if "generated/analyses.md" in text:
        shown |= set(NAMES_FUNCTIONS)
    if ".. automodule:: chaosdrill.errors" in text:
        shown |= {name for name in vars(errors) if name.endswith(("Error", "Warning"))}
    assert shown == set(chaosdrill.__all__) - {"__version__"}
