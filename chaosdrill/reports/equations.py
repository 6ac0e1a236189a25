"""The equations that a scene simulates, in MathML, which browsers set without a script."""

from typing import TYPE_CHECKING, Any

from chaosdrill.model.grammar import PLAIN_NAME
from chaosdrill.reports.html import Html, element, facts, joined, scrolled

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem, Transition

_WAYS = {1: "rises through 0", -1: "falls through 0", 0: "passes 0"}


def math(expression: Any, *, block: bool = False) -> Html:
    """A sympy expression as an element ``math``, with its plain text for those who do not see it."""
    return _math(_inner(expression), str(expression), block)


def equations(system: "HybridSystem") -> Html:
    """Rates of all states in all modes, quadratures, and the forcing's period."""
    time = system.time if system.time is not None else "t"
    parts = []
    for mode, rates in system.modes.items():
        first = " (at first)" if mode == system.initial["mode"] else ""
        lines = [_rate(state, rate, time) for state, rate in rates.items()]
        parts += [element("h4", f"Mode {mode}{first}"), _lines(f"Equations of mode {mode}", lines)]
    if system.quadratures:
        lines = [_rate(name, rate, time) for name, rate in system.quadratures.items()]
        parts += [element("h4", "Integrals along the way"), _lines("Integrals", lines)]
    if system.period is not None:
        period = _math(Html(f"<mi>T</mi><mo>=</mo>{_inner(system.period)}"), f"T = {system.period}", True)
        parts += [element("h4", "Period of the forcing"), _lines("Period", [period])]
    return joined(parts, "\n")


def events(system: "HybridSystem") -> Html:
    """Guards, conditions and resets."""
    return joined((_event(event) for event in system.transitions), "\n")


def _event(event: "Transition") -> Html:
    rows = [
        ("modes", f"{' or '.join(event.source)} → {event.target}"),
        ("class", event.kind),
        ("when", joined([math(event.guard), f" {_WAYS[event.direction]}"])),
    ]
    if event.condition is not None:
        rows.append(("if", math(event.condition)))
    resets = [element("li", _assignment(state, value)) for state, value in event.reset.items()]
    rows.append(("new state", element("ul", *resets, class_="equations") if resets else "as before"))
    return joined([element("h4", f"Event {event.name}"), scrolled(f"Event {event.name}", facts(rows))])


def _lines(name: str, lines: list[Html]) -> Html:
    return scrolled(name, element("ul", *(element("li", line) for line in lines), class_="equations"))


def _rate(state: Any, rate: Any, time: Any) -> Html:
    left = f"<mfrac><mrow><mi>d</mi>{_inner(state)}</mrow><mrow><mi>d</mi>{_inner(time)}</mrow></mfrac>"
    return _math(Html(f"{left}<mo>=</mo>{_inner(rate)}"), f"d{state}/d{time} = {rate}", True)


def _assignment(state: Any, value: Any) -> Html:
    return _math(Html(f"{_inner(state)}<mo>≔</mo>{_inner(value)}"), f"{state} := {value}", False)


def _math(inner: Html, plain: str, block: bool) -> Html:
    return element(
        "math", element("mrow", inner), display="block" if block else None, displaystyle="true", alttext=plain
    )


def _inner(expression: Any) -> Html:
    """The expression in MathML; sympy sets words of letters and digits itself, other names are put in as text."""
    import sympy
    from sympy.printing.mathml import mathml

    if isinstance(expression, str):
        expression = sympy.Symbol(expression)
    symbols = expression.free_symbols
    longest = max((len(s.name) for s in symbols), default=0)
    strange = [s for s in symbols if not PLAIN_NAME.fullmatch(s.name)]
    # longer than any name, so that none of them is called so
    stands_for = {s: sympy.Symbol(f"{'q' * longest}q{i}q", real=True) for i, s in enumerate(strange)}
    written = mathml(expression.xreplace(stands_for), printer="presentation")
    # browsers set a hyphen as a hyphen, and the entity for e as a doubled letter
    written = written.replace("<mo>-</mo>", "<mo>−</mo>").replace("&ExponentialE;", "e")
    for symbol, placeholder in stands_for.items():
        written = written.replace(f"<mi>{placeholder.name}</mi>", element("mi", symbol.name))
    return Html(written)
