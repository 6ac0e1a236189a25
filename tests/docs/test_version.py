"""One file says which version this is; what repeats it agrees with it."""

import re
import tomllib
from pathlib import Path

import chaosdrill

ROOT = Path(__file__).parents[2]
VERSION = chaosdrill.__version__
RELEASES = re.findall(r"^## (\d+\.\d+\.\d+) \((\d{4}-\d\d-\d\d)\)$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)


def cited(key):
    (value,) = re.findall(rf"^{key}: (\S+)$", (ROOT / "CITATION.cff").read_text(), flags=re.MULTILINE)
    return value


def test_the_package_takes_its_version_from_the_code():
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())
    assert "version" in settings["project"]["dynamic"]
    assert settings["tool"]["setuptools"]["dynamic"] == {"version": {"attr": "chaosdrill.version.__version__"}}


def test_the_changelog_begins_with_this_release_and_goes_back():
    numbers = [tuple(map(int, number.split("."))) for number, _ in RELEASES]
    assert RELEASES[0][0] == VERSION
    assert numbers == sorted(numbers, reverse=True)
    dates = [date for _, date in RELEASES]
    assert dates == sorted(dates, reverse=True)


def test_the_citation_names_this_release():
    assert (cited("version"), cited("date-released")) == RELEASES[0]


def test_the_comparison_compares_this_release():
    assert f"| chaosdrill | {VERSION} |" in (ROOT / "docs" / "comparison.md").read_text()


def test_the_badges_are_true():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    said = re.findall(r">([^<>\n]+)</text>", (ROOT / "docs" / "_static" / "badges.svg").read_text())
    oldest = project["requires-python"].removeprefix(">=") + " or newer"
    assert said == ["version", VERSION, "python", oldest, "license", project["license"]]
    words = f"Version {VERSION}, Python {oldest}, license {project['license']}"
    assert f"![{words}](docs/_static/badges.svg)" in (ROOT / "README.md").read_text()
