"""No text is run as code, takes for ever, or ends in anything but an expression or one clear error."""

import sys
from contextlib import suppress

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from support.effort import Effort

from chaosdrill.model.grammar import ExpressionError
from chaosdrill.model.text import read_text

NAMES = {name: sympy.Symbol(name, real=True) for name in ("x", "v", "t", "lambda")}
WATCHED = ("os.", "subprocess.", "compile", "exec", "import", "open", "socket.")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("__import__('os').system('touch owned')", "no text in an expression"),
        ("().__class__.__bases__", "cannot stand"),
        ("x.__class__", "stand alone"),
        ("eval(x)", "unknown function 'eval'"),
        ("lambda: 0", "cannot stand"),
        ("(" * 10**6 + "x" + ")" * 10**6, "letters long"),
        ("(" * 4000 + "x" + ")" * 4000, "nested"),
        ("-" * 9000 + "x", "nested"),
        ("x" + "**x" * 3000, "nested"),
        ("9**9**9", "exponent"),
        ("9**(x - x + 9**9)", "exponent"),
        ("(3*x)**999999999", "exponent"),
        ("((3*x)**1000)**1000", "too large"),
        ("0.5**1000000000", "exponent"),
        ("exp(1000000000*log(3*x))", "exponent"),
        ("exp(-1000000000*log(2.0))", "out of the range"),
        ("exp(exp(exp(10)))", "not a finite"),
        ("positive_power(2, 10**9)", "exponent"),
        ("Mod((x + v + t)**900, 2)", "remainder of a power"),
        (f"Mod(x{'+v*sin(t)' * 3}{'+x*cos(v*t)' * 3}+x/sin(x*v)+v/sin(x*t)+t/sin(v*t), 1)", "write x - y\\*floor"),
        ("1" * 5000, "digits"),
        ("1e400", "larger than any double"),
        ("1e-400*x", "'1e-400' is nearer to 0 than any double"),
        ("1e-200*1e-200*x", "or nearer to 0"),
        ("1e300*1e300*x", "larger than any double"),
        ("(10**300*10**300)*x", "larger than any double"),
        ("9" * 310 + "*x", "larger than any double"),
        ("v/0", "divides by zero"),
        ("1/0", "divides by zero"),
        ("1/(x - x)", "divides by zero"),
        ("Mod(x, 0)", "cannot be made"),
        ("log(-1)", "not a finite"),
        ("(-8)**(1/3)", "not a finite"),
        ("tan(pi/2)", "not finite"),
        ("*".join(f"sin({i}*x)" for i in range(1, 150)), "factors"),
        ("x^2", "write \\*\\* for a power"),
        ("x = 1", "write == to compare"),
        ("2x", "write \\* for a product"),
        ("fabs(x)", "write Abs"),
        ("piecewise(x, 2, 3)", "argument 2 of piecewise must be a comparison"),
        ("piecewise(x, x > 0, 1, x > 1)", "ends with the value that it has elsewhere"),
        ("piecewise(x > 0, x, 3)", "not a number"),
        ("sinn(x)", "did you mean 'sin'"),
        ("vv + x", "did you mean 'v'"),
        ("sin", "give it an argument"),
        ("sin(x, v)", "1 argument, received 2"),
        ("x(3)", "no function"),
        ("", "is empty"),
        ("x +", "ends where"),
        ("(x", "ends where"),
        ("x > 1", "not a comparison"),
        ("(x > 1)*2", "not a number"),
    ],
    ids=lambda text: text[:24],
)
def test_refused_at_once(text, told):
    with Effort() as effort, pytest.raises(ExpressionError, match=told) as caught:
        read_text(text, NAMES)
    assert effort.calls < 3_000_000
    assert len(str(caught.value)) < 500


SIGNS = ("**", "*", "/", "+", "-", "(", ")", ",", "<", ">=", "==", "and", "or", "not", "True", "`", "'", ".", " ")
TOKENS = ["x", "v", "lambda", "pi", "1", "2.5", "1e9", "999999999", "é", *SIGNS]
TOKENS += ["sin(", "exp(", "log(", "Max(", "Mod(", "floor(", "sqrt("]


@given(st.lists(st.sampled_from(TOKENS), max_size=25).map(" ".join), st.booleans())
def test_any_row_of_tokens(text, condition):
    try:
        found = read_text(text, NAMES, condition=condition)
    except ExpressionError:
        return
    assert isinstance(found, sympy.logic.boolalg.Boolean if condition else sympy.Expr)
    assert found.free_symbols <= set(NAMES.values())


@given(st.text(max_size=60))
def test_any_text(text):
    with suppress(ExpressionError):
        read_text(text, NAMES)


def test_nothing_is_compiled_imported_or_opened():
    read_text("sin(x)", NAMES)
    events = []
    recording = [True]

    def hook(event, arguments):
        if recording and event.startswith(WATCHED):
            events.append(event)

    sys.addaudithook(hook)
    for text in ("__import__('os').system('true')", "exec(x)", "lambda*x + exp(-v)", "open(x)"):
        with suppress(ExpressionError):
            read_text(text, NAMES)
    recording.clear()
    assert events == []
