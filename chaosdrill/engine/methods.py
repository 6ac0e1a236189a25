"""Methods of integration: every file of this folder that declares ``METHOD`` is one, of its name.

The declaration is a literal, which is read without importing what the method computes with.
"""

import ast
import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from chaosdrill.declared import METHODS
from chaosdrill.package import modules, source


@dataclass(frozen=True)
class Method:
    """What a method says of itself.

    Parameters
    ----------
    summary : str
        One line.
    cites : tuple of str
        Keys of its references.
    fixed_step : bool
        Whether the user sets how many steps a period has, and it looks at guards at the ends of steps alone.
    implicit : bool
        Whether a step is solved for by Newton's method.
    series : bool
        Whether it takes series of expressions, which a Python function has none of, and is part of the engine itself.
    lanes : bool
        Whether eight runs are stepped side by side.
    tightest : float
        Tolerance at which its errors are smallest, as those of a reference are.
    """

    summary: str
    cites: tuple[str, ...] = ()
    fixed_step: bool = False
    implicit: bool = False
    series: bool = False
    lanes: bool = False
    tightest: float = 1e-16


def _found() -> Iterator[tuple[str, Method]]:
    for name in modules("engine"):
        text = source(f"chaosdrill.engine.{name}").decode()
        if "\nMETHOD = " in text:
            yield name, Method(**_literal(text.partition("\nMETHOD = ")[2]))


def _literal(text: str) -> dict[str, Any]:
    """The table with which a text begins; to parse the whole file takes a hundred times as long."""
    for end in re.finditer("}", text):
        with suppress(SyntaxError):
            found: dict[str, Any] = ast.literal_eval(text[: end.end()])
            return found
    raise SyntaxError(text[:60])


_methods = dict(_found())
for _name, _method in _methods.items():
    METHODS.enter(_name, _method)

DEFAULT = "taylor"
"""Taken unless another is named."""

NAMES = sorted(_methods, key=lambda name: (name != DEFAULT, name))
"""In order, first the default."""
