"""An installation has every file of the package, and a source distribution what it is built and cited from."""

import re
import runpy
import tomllib
from fnmatch import fnmatch
from pathlib import Path

import pytest

import chaosdrill
from chaosdrill.version import __version__

PACKAGE = Path(chaosdrill.__file__).parent
ROOT = PACKAGE.parent
TUNING = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def files():
    return [one.relative_to(PACKAGE) for one in PACKAGE.rglob("*") if one.is_file() and "__pycache__" not in one.parts]


def test_data_files_are_listed():
    """Setuptools takes modules by itself, and of the rest what is listed."""
    patterns = TUNING["tool"]["setuptools"]["package-data"]["chaosdrill"]
    data = [one.as_posix() for one in files() if one.suffix != ".py"]
    assert data
    assert [one for one in data if not any(fnmatch(one, pattern) for pattern in patterns)] == []


def test_every_folder_of_modules_is_a_package():
    folders = {one.parent for one in files() if one.suffix == ".py"}
    assert [one for one in folders if not (PACKAGE / one / "__init__.py").is_file()] == []


@pytest.mark.parametrize("name", ["CHANGELOG.md", "CITATION.cff"])
def test_a_source_distribution_has_what_describes_the_release(name):
    text = (ROOT / name).read_text(encoding="utf-8")
    assert __version__ in text
    assert name in (ROOT / "MANIFEST.in").read_text(encoding="utf-8").split()


@pytest.mark.parametrize("source", ["", "https://source.example/files/v0/"])
def test_the_description_for_an_index_has_no_relative_link(source):
    """An index shows README.md without the files beside it."""
    made = runpy.run_path(str(ROOT / "setup.py"))["description"]
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    text = made(readme, source)
    targets = re.findall(r"\]\(([^()\s]+)\)", re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL))
    assert [one for one in targets if "://" not in one and not one.startswith("#")] == []
    assert ("docs/_static/drill.png" in text) == bool(source)
    assert re.findall(r"^```.*?^```$", text, re.MULTILINE | re.DOTALL) == re.findall(
        r"^```.*?^```$", readme, re.MULTILINE | re.DOTALL
    )
