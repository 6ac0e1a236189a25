"""Text and expressions: what is written is read back, and means what it means in Python."""

import math
import re

import pytest
import sympy
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from chaosdrill.model import special
from chaosdrill.model.grammar import ExpressionError
from chaosdrill.model.text import FUNCTIONS, read_open_text, read_text, write_text

NAMES = {name: sympy.Symbol(name, real=True) for name in ("x", "v", "t", "lambda", "k_1")}

NUMBERS = st.one_of(
    st.integers(-(10**20), 10**20).map(sympy.Integer),
    st.fractions(-1000, 1000, max_denominator=10**6).map(lambda q: sympy.Rational(q.numerator, q.denominator)),
    st.floats(-1e9, 1e9).filter(lambda value: value == 0 or abs(value) > 1e-9).map(sympy.Float),
    st.just(sympy.pi),
)
LEAVES = st.one_of(st.sampled_from([*NAMES.values()]), NUMBERS)
POWERS = st.sampled_from([-3, -2, -1, 2, 3, sympy.Rational(1, 2), sympy.Rational(-3, 7), 0.5, 1.5])
UNBOUNDED = (sympy.zoo, sympy.nan, sympy.oo, sympy.I)


def moving(exponent):
    """An exponent that is no number: sympy would work out a power of 20 digits, if memory lasted."""
    return NAMES["x"] * exponent if exponent.is_number else exponent


def call(name, arguments):
    """A function of expressions; of constants it is tried in a test of its own."""
    shifted = [argument + NAMES["x"] for argument in arguments]
    if name == "Piecewise":
        one, edge, other = shifted
        return sympy.Piecewise((one, NAMES["v"] > edge), (other, True))
    return (getattr(special, name) if name in special.SPECIAL else getattr(sympy, name))(*shifted)


def calls(children):
    def of(name):
        arguments = st.lists(children, min_size=FUNCTIONS[name].least, max_size=FUNCTIONS[name].least)
        return arguments.map(lambda given: call(name, given))

    return st.sampled_from([name for name in FUNCTIONS if name != "Mod"]).flatmap(of)


def grow(children):
    some = st.lists(children, min_size=2, max_size=4)
    return st.one_of(
        some.map(lambda terms: sympy.Add(*terms)),
        some.map(lambda factors: sympy.Mul(*factors)),
        st.tuples(children, children).map(lambda ab: ab[0] / (2 + ab[1] ** 2)),
        st.tuples(children, POWERS).map(lambda ab: (ab[0] + NAMES["v"]) ** ab[1]),
        st.tuples(children, children).map(lambda ab: (2 + sympy.cos(ab[0])) ** moving(ab[1])),
        calls(children),
    )


EXPRESSIONS = st.recursive(LEAVES, grow, max_leaves=6).filter(lambda e: not e.has(*UNBOUNDED))
RELATIONS = st.sampled_from([sympy.Lt, sympy.Le, sympy.Gt, sympy.Ge, sympy.Eq, sympy.Ne])
COMPARISONS = st.tuples(RELATIONS, EXPRESSIONS, EXPRESSIONS).map(lambda drawn: drawn[0](drawn[1], drawn[2]))
CONDITIONS = st.recursive(
    COMPARISONS,
    lambda inner: st.one_of(
        st.lists(inner, min_size=1, max_size=3).map(lambda parts: sympy.And(*parts)),
        st.lists(inner, min_size=1, max_size=3).map(lambda parts: sympy.Or(*parts)),
        inner.map(sympy.Not),
    ),
    max_leaves=3,
)
# constants that are no doubles, and exponents of more than 1000, are refused; a test of hostile text has them
BOUNDS = "exponents up to|range of doubles|finite real number|larger than any double"
PATIENT = settings(max_examples=150, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much])


def read_again(expression, **how):
    assume(all(1e-300 < abs(float(n)) < 1e300 or n == 0 for n in expression.atoms(sympy.Float)))
    try:
        return read_text(write_text(expression), NAMES, **how)
    except ExpressionError as fault:
        assume(not re.search(BOUNDS, str(fault)))
        raise


@PATIENT
@given(EXPRESSIONS)
def test_expressions_come_back(expression):
    assert sympy.srepr(read_again(expression)) == sympy.srepr(expression)


@settings(PATIENT, max_examples=50)
@given(CONDITIONS)
def test_conditions_come_back(condition):
    # sympy makes a choice of two conditions of what was none; it is written with and, or, not
    assume(not condition.has(*UNBOUNDED, sympy.ITE))
    assert sympy.srepr(read_again(condition, condition=True)) == sympy.srepr(condition)


def test_a_choice_of_conditions_is_written():
    x, v = sympy.symbols("x v", real=True)
    choice = sympy.ITE(v > 0, v > x, v < x)
    again = read_text(write_text(choice), NAMES, condition=True)
    assert all(again.subs({x: a, v: b}) == choice.subs({x: a, v: b}) for a in (-2, 2) for b in (-1, 1))


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_doubles_come_back_to_the_last_bit(value):
    found = read_text(write_text(sympy.Float(value)), {})
    assert float(found) == value


@pytest.mark.parametrize(
    "text",
    [
        "-2**2",
        "2**-1",
        "2**3**2",
        "-x**2*v",
        "1 - 2 - 3",
        "8/4/2",
        "8/(4*2)",
        "2*(x + v)*t/(3*(x - v))",
        "-(x - v) - (v - x)*2",
        "+x - +v",
        "x*-v",
        ".5e1 + 2.",
        "sqrt(x) + atan2(v, -x) + Mod(-7, 3)*x",
    ],
)
def test_operators_bind_as_in_python(text):
    values = {"x": 0.7, "v": -1.3, "t": 2.1}
    functions = {"sqrt": math.sqrt, "atan2": math.atan2, "Mod": lambda a, b: a % b}
    found = read_text(text, NAMES).subs({NAMES[name]: value for name, value in values.items()})
    assert float(found) == pytest.approx(eval(text, functions, values), rel=1e-14)


@pytest.mark.parametrize(
    ("text", "true", "false"),
    [
        ("x > 0 and v > 0 or t > 0", (1, 1, -1), (1, -1, -1)),
        ("not x > 0 and v > 0", (-1, 1, 0), (1, 1, 0)),
        ("not (x > 0 and v > 0)", (1, -1, 0), (1, 1, 0)),
        ("0 < x <= 1", (1, 0, 0), (2, 0, 0)),
        ("x == 1 or v != 2", (1, 2, 0), (3, 2, 0)),
        ("x - 1 < v + 1", (1, 0, 0), (2, -1, 0)),
    ],
)
def test_conditions_bind_as_in_python(text, true, false):
    found = read_text(text, NAMES, condition=True)
    for values, expected in ((true, True), (false, False)):
        here = dict(zip("xvt", values, strict=True))
        assert bool(found.subs({NAMES[name]: value for name, value in here.items()})) is expected
        assert eval(text, {}, here) is expected


def test_names_are_taken_as_they_stand():
    names = {name: sympy.Symbol(name, real=True) for name in ("lambda", "µ", "mass 1", "pi", "and")}
    found = read_text("lambda*µ + `mass 1`*pi*`and`", names)
    assert found.free_symbols == set(names.values())


def test_names_that_look_alike_are_two():
    names = {name: sympy.Symbol(name, real=True) for name in ("ﬁ", "fi", "µ", "μ", "ω₀", "x²", "is", "None")}
    assert read_text(" + ".join(names), names) == sympy.Add(*names.values())


def test_a_sum_may_be_as_long_as_a_text():
    found = read_text("+".join(["x", "v"] * 2500), NAMES)
    assert found == 2500 * (NAMES["x"] + NAMES["v"])


X, V = NAMES["x"], NAMES["v"]
THREE = sympy.Piecewise((X, (X > 0) & (V < 1)), (2 * X, V > 3), (1, True))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("abs(x)", sympy.Abs(X)),
        ("mod(x, 2) + max(x, 1) - min(v, 0)", sympy.Mod(X, 2) + sympy.Max(X, 1) - sympy.Min(V, 0)),
        ("heaviside(x - 1)", sympy.Heaviside(X - 1)),
        ("piecewise(x, x > 0, -x)", sympy.Piecewise((X, X > 0), (-X, True))),
        ("piecewise(x, x > 0 and v < 1, 2*x, v > 3, 1)", THREE),
    ],
)
def test_small_letters_are_read_for_branches(text, expected):
    assert read_text(text, NAMES) == expected
    assert read_text(write_text(expected), NAMES) == expected


@pytest.mark.parametrize("text", ["Piecewise((x, x > 0), (-x, True))", "2*piecewise( (x, x > 0), (0, True))"])
def test_pairs_of_sympy_get_the_way_that_works(text):
    with pytest.raises(ExpressionError, match=r"write (Piecewise\(a, x > 0, b\)) for cases, without") as caught:
        read_text(text, NAMES)
    assert "comma" not in str(caught.value)
    assert read_open_text("Piecewise(a, x > 0, b)").has(sympy.Piecewise)


@pytest.mark.parametrize("text", ["sin x", "2 + cos v"])
def test_a_function_without_parentheses(text):
    with pytest.raises(ExpressionError, match=r"parentheses for a function, as in sin\(x\)"):
        read_text(text, NAMES)


def test_a_parameter_may_be_called_as_such_a_function():
    assert {str(one) for one in read_open_text("mod*abs(y) + piecewise").free_symbols} == {"mod", "y", "piecewise"}
