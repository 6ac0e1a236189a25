"""What a user calls things changes no digit of any result."""

import hashlib
from pathlib import Path
from tempfile import TemporaryDirectory

import netCDF4
import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import settings as runs
from hypothesis import strategies as st

import chaosdrill as cd
from chaosdrill.dataset.schema import RESERVED

NASTY = (
    *("y0", "y1", "d_0", "d_1", "s_0", "s_1", "x0", "x_0", "x_1", "p_0", "p_1", "c", "c[0]", "t", "event", "value"),
    *("sqrt", "cos", "math", "exp", "pi", "E", "I", "S", "N", "Q", "zeta", "beta", "gamma", "lambda", "if", "None"),
    *("θ", "ω₀", "😀", "a b", "'", '"""', "#", "\\", "{0}", "%s", "$x$", "<b>", "&#47;", "a" * 200),
)  # fmt: skip

WORDS = ("x", "v", "z", "t", "w", "k", "free", "hit", "work", "oscillator")

names = st.lists(
    st.sampled_from(NASTY)
    | st.text(st.characters(categories=["L", "N", "P", "S"], exclude_characters="/"), min_size=1, max_size=8),
    min_size=len(WORDS),
    max_size=len(WORDS),
    unique=True,
).filter(lambda words: words[8] not in RESERVED and "mode" not in words[:3])


def oscillator(words=WORDS, forced=True):
    """An impact oscillator with a third state that it drives and is driven by; or one that a spring drives."""
    *symbols, mode, transition, quadrature, name = words
    x, v, z, t, w, k = (sympy.Symbol(s, real=True) for s in symbols)
    drop = sympy.Rational(1, 5)
    drive = sympy.cos(w * t) if forced else v / 2 - w * v * x**2
    return cd.HybridSystem(
        name=name,
        states=(x, v, z),
        time=t if forced else None,
        parameters={w.name: 2.7, k.name: 0.8},
        modes={mode: {x: v, v: -x - v / 10 + drive + z * x / 20, z: -z + x**2 * v}},
        transitions=[
            cd.Transition(transition, mode, mode, guard=x - drop, direction=1, reset={v: -k * v, z: z + v * x}),
        ],
        period=2 * sympy.pi / w if forced else None,
        quadratures={quadrature: v**2 + w * x},
        initial={x: -0.3},
    )


def numbers(dataset):
    """All numbers of a dataset, to the bit: shapes and digests."""
    held = [v.values for v in dataset.variables.values() if np.issubdtype(v.dtype, np.number)]
    return sorted((values.shape, hashlib.sha256(values.tobytes()).hexdigest()[:8]) for values in held)


def archived(dataset):
    """All numbers of the archive of a dataset, to the bit: types, shapes and digests."""
    with TemporaryDirectory() as folder:
        path = cd.save(dataset, Path(folder) / "result.nc")
        with netCDF4.Dataset(path) as file:
            file.set_auto_maskandscale(False)
            held = [variable[...] for variable in file.variables.values() if variable.dtype is not str]
    return sorted(
        (str(values.dtype), values.shape, hashlib.sha256(values.tobytes()).hexdigest()[:8]) for values in held
    )


ARCHIVED = ("trajectory", "section")
"""Analyses whose archives are compared, all that stands in the file."""

ANALYSES = {
    "trajectory": lambda system, words: cd.trajectory(system, periods=20, samples=4),
    "dop853": lambda system, words: cd.trajectory(system, periods=10, method="dop853"),
    "rk4": lambda system, words: cd.trajectory(system, periods=10, method="rk4"),
    "spectrum": lambda system, words: cd.lyapunov_spectrum(system, periods=100, transient=20),
    "section": lambda system, words: cd.poincare_section(system, periods=50, at=words[7]),
    "diagram": lambda system, words: cd.bifurcation_diagram(
        system, {words[4]: [2.6, 2.7, 2.8]}, transient=50, periods=50, exponents=2, seeds=[{words[0]: -0.5}]
    ),
    "chart": lambda system, words: cd.parameter_chart(
        system, {words[4]: [2.6, 2.8], words[5]: [0.7, 0.8]}, transient=50, periods=50
    ),
    "basins": lambda system, words: cd.basins(
        system, {words[0]: [-0.5, 0.0], words[1]: [-0.5, 0.5]}, transient=50, periods=50
    ),
    "orbit": lambda system, words: cd.periodic_orbit(system),
    "branch": lambda system, words: cd.continue_orbit(system, {words[4]: (2.65, 2.75)}, max_points=15),
}


@pytest.fixture(scope="module")
def known():
    return {}


@pytest.mark.parametrize("analysis", ANALYSES)
@runs(max_examples=8)
@given(words=names)
def test_every_analysis_gives_the_same_bits_whatever_things_are_called(analysis, known, words):
    run, digests = ANALYSES[analysis], archived if analysis in ARCHIVED else numbers
    if analysis not in known:
        known[analysis] = digests(run(oscillator(), WORDS))
    assert digests(run(oscillator(words), words)) == known[analysis]


@runs(max_examples=8)
@given(words=names)
def test_an_autonomous_system_may_call_anything_t(known, words):
    words = ["t", *words[1:]] if "t" not in words else words
    if "cycle" not in known:
        known["cycle"] = numbers(cd.periodic_orbit(oscillator(forced=False)))
    assert numbers(cd.periodic_orbit(oscillator(words, forced=False))) == known["cycle"]


def falls(name, value, rate="-{0}*x"):
    """x' = -k x as text, the parameter called otherwise."""
    return cd.HybridSystem(
        name="falls",
        states=["x"],
        parameters={name: value},
        modes={"all": {"x": rate.format(name)}},
        initial={"x": 1.0},
    )


@pytest.mark.parametrize("name", ["E", "pi", "I", "S", "N", "Q", "zeta", "beta", "gamma", "lambda", "t"])
def test_a_name_in_a_text_is_the_symbol_of_that_name(name):
    end = cd.trajectory(falls(name, 4.0), duration=1.0)["state"].values[-1, 0]
    assert end == pytest.approx(np.exp(-4.0), rel=1e-11)


def test_pi_is_the_number_where_nothing_is_called_so():
    end = cd.trajectory(falls("k", 2.0, "-pi*{0}*x"), duration=1.0)["state"].values[-1, 0]
    assert end == pytest.approx(np.exp(-2.0 * np.pi), rel=1e-10)


@pytest.mark.parametrize(
    "text", ["__import__('os').system('touch {0}')", "x.__class__", "(lambda: x)()", "open('{0}', 'w')", "exec('1')"]
)
def test_a_text_is_never_run(tmp_path, text):
    made = tmp_path / "made"
    with pytest.raises(cd.ModelError, match="mode 'all', dx/dt: "):
        falls("k", 1.0, text.replace("{0}", str(made)).replace("{", "{{"))
    with pytest.raises(cd.ModelError, match="guard: "):
        cd.Transition("hit", "all", "all", guard=text.replace("{0}", str(made)), direction=1)
    with pytest.raises(cd.ModelError, match="condition: "):
        cd.Transition("hit", "all", "all", guard="x", direction=1, condition=text.replace("{0}", str(made)))
    assert not made.exists()
