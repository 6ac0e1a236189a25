"""What the page is made of is installed with the package."""

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
