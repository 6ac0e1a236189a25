"""Tilted switch: all stretching is saltation, ln(3)/5 exactly; a code without it prints 0."""

from math import log

import numpy as np

import chaosdrill as cd


def test_spectrum_is_exact():
    spectrum = cd.lyapunov_spectrum(cd.build("tilted-switch"), duration=5 * 2000, transient=5 * 20)
    exponents = spectrum["lyapunov_exponent"].values
    np.testing.assert_allclose(exponents, [log(3) / 5, 0.0], atol=1e-10)
    assert abs(exponents[0] - 0.21972245773362) < 1e-10


def test_every_return_takes_five_and_triples():
    run = cd.trajectory(cd.build("tilted-switch"), duration=5 * 60, samples=2)
    names = run["event_kind"].attrs["flag_meanings"].split()
    back = run["event_kind"].values == names.index("return")
    np.testing.assert_allclose(np.diff(run["event_time"].values[back]), 5, atol=1e-12)
    x = run["event_state_after"].values[back, 0]
    np.testing.assert_allclose((x[1:] - 3 * x[:-1] + 0.5) % 1, 0.5, atol=1e-12)
