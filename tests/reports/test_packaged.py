"""What the page is made of is installed with the package, and escapes what is put into it."""

import re
import tomllib
from pathlib import Path

import chaosdrill

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
