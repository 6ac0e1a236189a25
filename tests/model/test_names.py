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
from support.short_calls import short_calls

import chaosdrill as cd
from chaosdrill.analysis.registry import FUNCTIONS
from chaosdrill.codegen.kernels import write
from chaosdrill.declared import unfit

NASTY = (
    *("y0", "y1", "d_0", "d_1", "s_0", "s_1", "x0", "x_0", "x_1", "p_0", "p_1", "c", "c[0]", "t", "event", "value"),
    *("sqrt", "cos", "math", "exp", "pi", "E", "I", "S", "N", "Q", "zeta", "beta", "gamma", "lambda", "if", "None"),
    *("θ", "ω₀", "😀", "a b", "'", '"""', "#", "\\", "{0}", "%s", "$x$", "<b>", "&#47;", "a" * 200),
)  # fmt: skip

WORDS = ("x", "v", "z", "t", "w", "k", "free", "hit", "work", "oscillator")

WORST = ("y0", "d_0", "sqrt", "t", "E", "lambda", "if", "&#47;", "None", "<b>")

names = st.lists(
    st.sampled_from(NASTY)
    | st.text(st.characters(categories=["L", "N", "P", "S"], exclude_characters="/"), min_size=1, max_size=8),
    min_size=len(WORDS),
    max_size=len(WORDS),
    unique=True,
).filter(lambda words: unfit(words[8]) is None and "mode" not in words[:3])


def oscillator(words=WORDS, forced=True):
    """An impact oscillator with a third state that it drives and is driven by; or one that a spring drives."""
    *symbols, mode, transition, quadrature, name = words
    x, v, z, t, w, k = (sympy.Symbol(s, real=True) for s in symbols)
    drop = sympy.Rational(1, 10)
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


SHORT = {"transient": 50, "periods": 50}


def calls(words):
    """Function and arguments of every analysis, of some with more of the arguments that hold names."""
    x, v, z, _, w, k, _, hit, *_ = words
    starts, plane = {x: (-0.5, 0.1)}, {x: [-0.5, 0.0], v: [-0.5, 0.5]}
    more = {
        "trajectory": [
            {"periods": 20, "samples": 4},
            {"periods": 10, "method": "dop853"},
            {"periods": 10, "method": "rk4"},
        ],
        "lyapunov_spectrum": [{"periods": 100, "transient": 20}],
        "poincare_section": [{"periods": 50, "at": hit}, {"periods": 10}],
        "zero_one_test": [{"periods": 50, "at": hit}],
        "regularity": [{"periods": 50, "plane": [v, x]}],
        "dimensions": [{"periods": 50, "at": hit}],
        "covariant_vectors": [{"periods": 20, "forward": 20, "backward": 20}],
        "transient_chaos": [{"periods": 20, "random": {"count": 4, "seed": 1, **starts}, "until": hit}],
        "bifurcation_diagram": [
            {"sweep": {w: [2.6, 2.7, 2.8]}, "exponents": 2, "seeds": [{x: -0.5}], **SHORT},
            {"sweep": {k: [0.7, 0.8]}, "follow": "both", "random": {"count": 2, "seed": 3, **starts}, **SHORT},
        ],
        "parameter_chart": [{"sweep": {w: [2.6, 2.8], k: [0.7, 0.8]}, "seeds": [{}, {v: 0.3}], **SHORT}],
        "basins": [{"grid": plane, **SHORT}],
        "basin_measures": [{"grid": plane, "box": 2, **SHORT}],
        "attractors": [{"sweep": {w: [2.6, 2.8]}, "random": {"count": 3, "seed": 2, **starts}, **SHORT}],
        "edge_states": [{"random": {"count": 3, "seed": 2, **starts}, "rounds": 2, **SHORT}],
        "periodic_orbit": [{}, {"start": "search", "max_period": 1, "seeds": [{z: 0.1}], "tolerance": 1e-9}],
        "continue_orbit": [
            {"sweep": {w: (2.43, 2.47)}, "step": 0.005, "doublings": 1},
            {
                "sweep": {w: (2.4, 2.5), k: (0.75, 0.85)},
                "step": 0.01,
                "max_points": 6,
                "follow": "period_doubling",
            },
        ],
        "equilibria": [{"sweep": {w: (2.0, 3.0)}, "region": dict.fromkeys((x, v, z), (-1, 1)), "starts": 9}],
    }
    short = short_calls((x, [-0.5, 0.0]), (v, [-0.5, 0.5]), (w, [2.6, 2.8]), (k, [0.7, 0.8]))
    return [(name, arguments) for name in FUNCTIONS for arguments in more.get(name) or [short[name]]]


def results(words):
    """Each of these in turn: its function, its dataset without what a clock says, and its archive."""
    forced, free = oscillator(words), oscillator(words, forced=False)
    # short of a period doubling
    doubling = forced.with_parameters(**{words[4]: 2.45})
    systems = {**dict.fromkeys(("periodic_orbit", "continue_orbit", "manifolds"), doubling), "equilibria": free}
    for name, arguments in calls(words):
        ds = getattr(cd, name)(systems.get(name, forced), **arguments)
        ds = ds.drop_vars(["wall_time", "wall_time_spread"], errors="ignore")
        yield name, ds, archived(ds)


@pytest.fixture(scope="module")
def plain():
    """What every analysis gives where nothing is called by a strange name."""
    return list(results(WORDS))


def test_what_is_compared_hits_doubles_and_follows(plain):
    (orbit, _), (branch, curve) = (
        [ds for name, ds, _ in plain if name == wanted] for wanted in ("periodic_orbit", "continue_orbit")
    )
    assert orbit.sizes["event"] == 1
    assert branch.sizes["doubling"] == 1
    assert curve.sizes["point"] > 3


def test_every_analysis_gives_the_same_bits_whatever_things_are_called(plain):
    for (name, _, expected), (_, _, found) in zip(plain, results(WORST), strict=True):
        assert found == expected, name


@pytest.mark.parametrize("forced", [True, False])
@runs(max_examples=5)
@given(words=names)
def test_names_change_no_letter_of_the_code(forced, words):
    """An autonomous system may call anything t."""
    words = ["t", *words[1:]] if not forced and "t" not in words else words
    plain, named = (write(oscillator(of, forced).placed) for of in (WORDS, words))
    assert (named.single, named.lanes()) == (plain.single, plain.lanes())


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
    end = cd.trajectory(falls(name, 4.0), duration=1.0)["states"].values[-1, 0]
    assert end == pytest.approx(np.exp(-4.0), rel=1e-11)


def test_pi_is_the_number_where_nothing_is_called_so():
    end = cd.trajectory(falls("k", 2.0, "-pi*{0}*x"), duration=1.0)["states"].values[-1, 0]
    assert end == pytest.approx(np.exp(-2.0 * np.pi), rel=1e-10)


@pytest.mark.parametrize(
    "text", ["__import__('os').system('touch {0}')", "x.__class__", "(lambda: x)()", "open('{0}', 'w')", "exec('1')"]
)
def test_a_text_is_never_run(tmp_path, text):
    made = tmp_path / "made"
    with pytest.raises(cd.ModelError, match=r"modes.all.x: "):
        falls("k", 1.0, text.replace("{0}", str(made)).replace("{", "{{"))
    with pytest.raises(cd.ModelError, match=r"guard: "):
        cd.Transition("hit", "all", "all", guard=text.replace("{0}", str(made)), direction=1)
    with pytest.raises(cd.ModelError, match="condition: "):
        cd.Transition("hit", "all", "all", guard="x", direction=1, condition=text.replace("{0}", str(made)))
    assert not made.exists()
