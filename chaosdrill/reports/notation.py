"""A system as its equations: in HTML for notebooks, and in LaTeX. Names are text, whatever they hold."""

from typing import Any

from markupsafe import Markup

from chaosdrill.model import HybridSystem
from chaosdrill.model.grammar import PLAIN_NAME
from chaosdrill.reports.html import shown
from chaosdrill.reports.origin import system_part

MOST_EQUATIONS = 200
"""Equations above which a system is not written out: a notebook would hold them for every cell that ends in it."""

_STYLE = Markup(
    "<style>.chaosdrill-system .equations {list-style: none; padding: 0; margin: 0}"
    ".chaosdrill-system .equations li {padding: 0.2em 0} .chaosdrill-system .equations math {display: inline math}"
    ".chaosdrill-system .scroll {overflow: auto hidden; padding-bottom: 0.2em}"
    ".chaosdrill-system :is(th, td, caption) {text-align: left; padding: 0 1em 0 0}"
    ".chaosdrill-system dd {display: inline; margin: 0}"
    ".chaosdrill-system dt {display: inline; opacity: 0.7} .chaosdrill-system dt::after {content: ': '}</style>"
)

_IN_MATHEMATICS = str.maketrans(
    {
        "\\": r"\backslash ",
        "^": r"\wedge ",
        "~": r"\sim ",
        " ": r"\ ",
        "-": r"\text{-}",
        **{letter: f"\\{letter}" for letter in "{}$%#&_"},
    }
)

_CROSSES = {1: r"\nearrow 0", -1: r"\searrow 0", 0: r"= 0"}


def system_html(system: HybridSystem) -> str | None:
    """The system as HTML with its equations in MathML, which loads nothing; None if it is too large."""
    if _equations(system) > MOST_EQUATIONS:
        return None
    return str(Markup('<div class="chaosdrill-system">{}{}</div>').format(_STYLE, system_part(system)))


def system_latex(system: HybridSystem) -> str | None:
    """The equations of the modes and the events in LaTeX, one display; None if it is too large.

    An event is its guard, with an arrow for the direction in which it passes zero, the condition of its outcome, and
    its reset.
    """
    if _equations(system) > MOST_EQUATIONS:
        return None
    time = r"\mathrm{d}" + ("t" if system.time is None else _latex(system.time))
    lines = []
    for mode, field in system.modes.items():
        lines.append(rf"&{_words(mode)}:")
        lines += [rf"\frac{{\mathrm{{d}}{_latex(state)}}}{{{time}}} &= {_latex(rate)}" for state, rate in field.items()]
    for event in system.transitions:
        sources = r",\ ".join(map(_words, event.source))
        lines.append(rf"&{_words(event.name)}:\ {sources} \to {_words(event.target)}")
        conditions = {} if event.condition is None else event.conditions
        if len(set(conditions.values())) == 1:
            conditions = {"": next(iter(conditions.values()))}
        where = "".join(
            rf",\quad {_latex(condition)}" + (rf"\ ({_words(mode)})" if mode else "")
            for mode, condition in conditions.items()
        )
        lines.append(rf"{_latex(event.guard)} &{_CROSSES[event.direction]}{where}")
        lines += [rf"{_latex(state)} &:= {_latex(value)}" for state, value in event.reset.items()]
    return "$$\\begin{aligned}\n" + " \\\\\n".join(lines) + "\n\\end{aligned}$$"


def _equations(system: HybridSystem) -> int:
    fields = len(system.modes) * len(system.states)
    return fields + sum(1 + len(event.reset) for event in system.transitions) + len(system.quadratures)


def _latex(expression: Any) -> str:
    import sympy

    # a word in italics would be the product of its letters
    upright = {s: _words(s.name) for s in expression.free_symbols if not _is_set(s.name)}
    written: str = sympy.latex(expression, symbol_names=upright)
    return written


def _is_set(name: str) -> bool:
    """Whether sympy sets a name as a letter, with an index or an accent, or as a Greek one."""
    import sympy

    if not PLAIN_NAME.fullmatch(name) or not name.strip("_"):
        return False
    return len(name) == 1 or any(sign in sympy.latex(sympy.Symbol(name)) for sign in "\\_^")


def _words(text: str) -> str:
    return rf"\mathrm{{{shown(text).translate(_IN_MATHEMATICS)}}}"
