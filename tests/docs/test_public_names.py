"""The page of the Python interface has every public name, and no other."""

import re
from pathlib import Path

import chaosdrill
from chaosdrill import errors
from chaosdrill.analysis.registry import FUNCTIONS

PAGE = Path(__file__).parents[2] / "docs" / "api.md"


def test_the_page_has_the_public_names():
    text = PAGE.read_text(encoding="utf-8")
    shown = set(re.findall(r"^\.\. auto(?:function|class):: chaosdrill\.(\w+)$", text, flags=re.MULTILINE))
    if "generated/analyses.md" in text:
        shown |= set(FUNCTIONS)
    if ".. automodule:: chaosdrill.errors" in text:
        shown |= {name for name in vars(errors) if name.endswith("Error")}
    assert shown == set(chaosdrill.__all__) - {"__version__"}
