"""What a user calls things changes no digit of any result."""

import hashlib
from pathlib import Path
from tempfile import TemporaryDirectory

import netCDF4
import numpy as np
import pytest
import sympy
from hypothesis import example, given
from hypothesis import settings as runs
from hypothesis import strategies as st

import chaosdrill as cd
from chaosdrill.analysis.registry import analyses
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


def doubling(system, words):
    """The system short of a period doubling."""
    return system.with_parameters(**{words[4]: 2.45})


ANALYSES = {
    "trajectory": lambda system, words: cd.trajectory(system, periods=20, samples=4),
    "dop853": lambda system, words: cd.trajectory(system, periods=10, method="dop853"),
    "rk4": lambda system, words: cd.trajectory(system, periods=10, method="rk4"),
    "spectrum": lambda system, words: cd.lyapunov_spectrum(system, periods=100, transient=20),
    "section": lambda system, words: cd.poincare_section(system, periods=50, at=words[7]),
    "test": lambda system, words: cd.zero_one_test(system, periods=50, at=words[7]),
    "regularity": lambda system, words: cd.regularity(system, periods=50, plane=[words[1], words[0]]),
    "dimensions": lambda system, words: cd.dimensions(system, periods=50, at=words[7]),
    "windows": lambda system, words: cd.finite_time_exponents(system, periods=50, transient=20),
    "vectors": lambda system, words: cd.covariant_vectors(system, periods=20, forward=20, backward=20),
    "transients": lambda system, words: cd.transient_chaos(
        system, periods=20, random={"count": 4, "seed": 1, words[0]: (-0.5, 0.1)}, until=words[7]
    ),
    "strobe": lambda system, words: cd.poincare_section(system, periods=10),
    "diagram": lambda system, words: cd.bifurcation_diagram(
        system, {words[4]: [2.6, 2.7, 2.8]}, exponents=2, seeds=[{words[0]: -0.5}], **SHORT
    ),
    "followed": lambda system, words: cd.bifurcation_diagram(
        system, {words[5]: [0.7, 0.8]}, follow="both", random={"count": 2, "seed": 3, words[0]: (-0.5, 0.1)}, **SHORT
    ),
    "chart": lambda system, words: cd.parameter_chart(
        system, {words[4]: [2.6, 2.8], words[5]: [0.7, 0.8]}, seeds=[{}, {words[1]: 0.3}], **SHORT
    ),
    "basins": lambda system, words: cd.basins(system, {words[0]: [-0.5, 0.0], words[1]: [-0.5, 0.5]}, **SHORT),
    "measures": lambda system, words: cd.basin_measures(
        system, {words[0]: [-0.5, 0.0], words[1]: [-0.5, 0.5]}, box=2, **SHORT
    ),
    "attractors": lambda system, words: cd.attractors(
        system, {words[4]: [2.6, 2.8]}, random={"count": 3, "seed": 2, words[0]: (-0.5, 0.1)}, **SHORT
    ),
    "edges": lambda system, words: cd.edge_states(
        system, random={"count": 3, "seed": 2, words[0]: (-0.5, 0.1)}, rounds=2, **SHORT
    ),
    "orbit": lambda system, words: cd.periodic_orbit(doubling(system, words)),
    "orbits": lambda system, words: cd.periodic_orbit(
        system, start="search", max_period=1, seeds=[{words[2]: 0.1}], tolerance=1e-9
    ),
    "branches": lambda system, words: cd.continue_orbit(
        doubling(system, words), {words[4]: (2.43, 2.47)}, step=0.005, doublings=1
    ),
    "curve": lambda system, words: cd.continue_orbit(
        doubling(system, words),
        {words[4]: (2.4, 2.5), words[5]: (0.75, 0.85)},
        step=0.01,
        max_points=6,
        follow="period_doubling",
    ),
    "curves": lambda system, words: cd.manifolds(doubling(system, words), start="attractor", length=0.1),
    "equilibria": lambda system, words: cd.equilibria(
        oscillator(words, forced=False), {words[4]: (2.0, 3.0)}, region={words[i]: (-1, 1) for i in range(3)}, starts=9
    ),
    "precision": lambda system, words: cd.work_precision(
        system, periods=1, methods=["taylor"], tolerances=[1e-6], repeats=1
    ).drop_vars(["wall_time", "wall_time_spread"]),
}


COORDINATES = {
    "diagram": (4,),
    "followed": (5,),
    "chart": (4, 5),
    "basins": (0, 1),
    "measures": (0, 1),
    "attractors": (4,),
    "branches": (4,),
    "curve": (4, 5),
    "equilibria": (4,),
}
"""Of which words the names of coordinates are made, which not every name can be."""


@pytest.fixture(scope="module")
def plain():
    """What every analysis gives where nothing is called by a strange name, and its archive."""
    found = {name: run(oscillator(), WORDS) for name, run in ANALYSES.items()}
    return {name: (ds, archived(ds)) for name, ds in found.items()}


def test_what_is_compared_is_of_every_kind_and_hits_doubles_and_follows(plain):
    assert {ds.attrs["kind"] for ds, _ in plain.values()} == set(analyses())
    assert plain["orbit"][0].sizes["event"] == 1
    assert plain["branches"][0].sizes["doubling"] == 1
    assert plain["curve"][0].sizes["point"] > 3


@runs(max_examples=1)
@example(words=WORST)
@given(words=names)
def test_every_analysis_gives_the_same_bits_whatever_things_are_called(plain, words):
    system = oscillator(words)
    for analysis, run in ANALYSES.items():
        if any(unfit(words[i]) for i in COORDINATES.get(analysis, ())):
            with pytest.raises(cd.SettingsError, match="rename the"):
                run(system, words)
        else:
            assert archived(run(system, words)) == plain[analysis][1], analysis


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
