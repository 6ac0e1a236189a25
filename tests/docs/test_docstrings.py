"""Docstrings of public functions name the arguments that there are, in their order, and say what comes back."""

import inspect
import re

import pytest

import chaosdrill as cd

FUNCTIONS = [name for name in cd.__all__ if inspect.isfunction(getattr(cd, name))]


def section(text, title):
    """Lines of one section of a numpydoc docstring."""
    found = re.search(rf"^{title}\n-+\n(.*?)(?=^\w[^\n]*\n-+\n|\Z)", text, flags=re.MULTILINE | re.DOTALL)
    return found[1] if found else ""


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_docstring_has_the_arguments_of_the_signature(name):
    function = getattr(cd, name)
    text = inspect.getdoc(function)
    named = re.findall(r"^(\*{0,2}\w+(?:, \w+)*) : ", section(text, "Parameters"), flags=re.MULTILINE)
    stars = {inspect.Parameter.VAR_KEYWORD: "**", inspect.Parameter.VAR_POSITIONAL: "*"}
    expected = [stars.get(p.kind, "") + p.name for p in inspect.signature(function).parameters.values()]
    assert ", ".join(named).split(", ") == expected
    assert re.search(r"^    \S", section(text, "Returns"), flags=re.MULTILINE)
    assert section(text, "Raises")
