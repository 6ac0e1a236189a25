"""The rank of the tangents is that of the product of the resets, whatever the resets are.

One system, x := A x every time unit, with the nine entries of A for parameters.
"""

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.engine.structure import examine

STATES = sympy.symbols("x y z", real=True)
CLOCK = sympy.Symbol("s", real=True)
ENTRIES = sympy.symbols("a0:9", real=True)


@pytest.fixture(scope="module")
def mapped():
    matrix = sympy.Matrix(3, 3, ENTRIES)
    image = matrix * sympy.Matrix(STATES)
    system = cd.HybridSystem(
        name="map",
        states=(*STATES, CLOCK),
        parameters={e.name: 0.0 for e in ENTRIES},
        modes={"hold": {**dict.fromkeys(STATES, 0), CLOCK: 1}},
        transitions=[
            cd.Transition(
                "map",
                "hold",
                "hold",
                guard=CLOCK - 1,
                direction=+1,
                reset={**dict(zip(STATES, image, strict=True)), CLOCK: 0},
            )
        ],
        initial={CLOCK: 0.5, STATES[0]: 0.3, STATES[1]: -0.2, STATES[2]: 0.1},
    )
    return lambda a: system.with_parameters(**{e.name: v for e, v in zip(ENTRIES, np.ravel(a), strict=True)})


def turn(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


MATRICES = {
    "regular": np.array([[0.5, 0.2, 0], [0.1, 0.9, 0.3], [0, -0.4, 0.7]]),
    "projection": np.diag([0.9, 0.5, 0]),
    "nilpotent": np.array([[0, 1, 0], [0, 0, 1], [0, 0, 0.0]]),
    "nilpotent in two": np.array([[0, 1, 0], [0, 0, 0], [0, 0, 0.5]]),
    "projection and rotation": turn(0.7) @ np.diag([1, 0, 0.8]),
    "rank one": np.outer([0.3, 0.5, 0.2], [1.0, 1.0, 1.0]),
    "zero": np.zeros((3, 3)),
    "permutation": np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0.0]]),
    "badly scaled and regular": np.diag([1e-3, 1.0, 0.5]),
}


@pytest.mark.parametrize("name", MATRICES)
def test_rank_and_exponents(mapped, name):
    """Moduli of the eigenvalues, and -inf for each that is zero; the clock has the exponent 0."""
    spectrum = cd.lyapunov_spectrum(mapped(MATRICES[name]), duration=400, transient=20)
    power = np.linalg.matrix_power(MATRICES[name], 3)
    rank = np.linalg.matrix_rank(power) + 1
    assert int(spectrum["rank"]) == rank
    with np.errstate(divide="ignore"):
        moduli = np.abs(np.linalg.eigvals(MATRICES[name]))
        expected = np.sort([0.0, *np.log(np.where(moduli < 1e-5, 0, moduli))])[::-1]
    found = spectrum["lyapunov_exponent"].values
    assert np.array_equal(np.isneginf(found), np.isneginf(expected))
    finite = np.isfinite(expected)
    # non-normal maps turn their basis for ever: the mean converges as 1/length
    np.testing.assert_allclose(found[finite], expected[finite], atol=5e-3)
    assert np.isnan(spectrum["lyapunov_error"].values[~finite]).all()


@pytest.mark.parametrize("name", MATRICES)
def test_only_resets_that_lose_rank_are_watched(mapped, name):
    lost = np.linalg.matrix_rank(MATRICES[name]) < 3
    assert examine(mapped(MATRICES[name])).deficient == (frozenset({0}) if lost else frozenset())


def test_dimension_survives_minus_infinity(mapped):
    rest = mapped(np.diag([1.2, 0.9, 0])).with_initial(x=0.0)
    spectrum = cd.lyapunov_spectrum(rest, duration=200)
    # ln 1.2 + 0 + ln 0.9 > 0, and the lost direction adds nothing
    assert float(spectrum["kaplan_yorke_dimension"]) == 3.0
