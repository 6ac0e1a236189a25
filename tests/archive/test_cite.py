"""What is cited is what was used."""

import json
import re
from importlib.resources import files

import pytest

from chaosdrill.cli import main
from chaosdrill.dataset.references import BY_METHOD, REFERENCES, package, references
from chaosdrill.workflow import cite


@pytest.fixture(scope="module")
def keys(every_kind):
    return [reference.key for reference in cite(every_kind)]


def test_the_package_comes_first_and_everything_once(keys):
    assert keys[0] == "chaosdrill"
    assert len(keys) == len(set(keys))


def test_methods_analyses_and_system(keys):
    for key in ("jorba2005", "hairer1993", "mueller1995", "benettin1980", "keller1977", "auerbach1987", "shaw1983"):
        assert key in keys, key


def test_what_was_not_used_is_not_cited(keys):
    assert not {"hunt1975", "lorenz1963", "feigenbaum1978"} & set(keys)


def test_a_drill_with_contact():
    drill = {"kind": "trajectory", "system": "percussive-drill", "method": "rk4"}
    assert [r.key for r in references(drill | {"parameters": '{"a": 0.1}'})] == ["drilling"]
    assert [r.key for r in references(drill | {"parameters": '{"n": 1.5, "k": 1e5}'})] == ["drilling", "hunt1975"]


def test_a_cascade():
    assert "feigenbaum1978" in [r.key for r in references({"kind": "continuation"}, ["feigenbaum_ratio"])]


@pytest.mark.parametrize("settings", ["", "[]", "not JSON", "[" * 100_000, 3.0, "null"])
def test_settings_that_cannot_be_read_add_nothing(settings):
    assert references({"kind": "trajectory", "settings": settings}) == ()


def test_every_kind_and_method_is_known():
    from chaosdrill.analysis.registry import METHODS, analyses
    from chaosdrill.systems import REGISTRY

    assert {key for entry in analyses().values() for key in entry.cites} <= REFERENCES.keys()
    assert BY_METHOD.keys() == METHODS.keys()
    assert {key for entry in REGISTRY.values() for key in entry.cites} <= REFERENCES.keys()


@pytest.mark.parametrize("reference", REFERENCES.values(), ids=REFERENCES)
def test_entries_are_whole(reference):
    assert reference.title
    if reference.doi:
        assert re.fullmatch(r"10\.\d{4,5}/\S+", reference.doi)
        assert reference.text().endswith(f"doi:{reference.doi}")
    assert reference.bibtex().count("{") == reference.bibtex().count("}")
    assert "None" not in reference.text() + reference.bibtex()


@pytest.mark.parametrize(
    ("key", "line"),
    [
        ("mueller1995", r"  journal = {Chaos, Solitons \& Fractals},"),
        ("mueller1995", "  pages = {1671--1681},"),
        ("denhartog1931", "  author = {J. P. {Den Hartog}},"),
        ("dibernardo2008", "  author = {M. di Bernardo and C. J. Budd and A. R. Champneys and P. Kowalczyk},"),
    ],
)
def test_bibtex_can_be_typeset_and_sorted(key, line):
    assert line in REFERENCES[key].bibtex().splitlines()


def test_the_list_of_references_is_printed_as_it_is_kept():
    kept = files("chaosdrill.dataset").joinpath("references.bib").read_text(encoding="utf-8")
    assert "\n\n".join(reference.bibtex() for reference in REFERENCES.values()) + "\n" == kept


def test_bibtex_of_the_package_has_no_given_names():
    assert "  author = {{The chaosdrill developers}}," in package().bibtex().splitlines()


def test_command_line(every_kind, capsys):
    assert main(["cite", str(every_kind)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any("doi:10.1016/0960-0779(94)00170-U" in line for line in lines)
    assert main(["cite", "--json", str(every_kind)]) == 0
    found = json.loads(capsys.readouterr().out)["references"]
    assert len(found) == len(lines)
    assert {"key": "mueller1995", "year": 1995}.items() <= next(r for r in found if r["key"] == "mueller1995").items()
    assert main(["cite", "--bibtex", str(every_kind)]) == 0
    assert capsys.readouterr().out.count("\n@") == len(lines) - 1
    assert main(["cite", "--bibtex", "--json", str(every_kind)]) == 2
