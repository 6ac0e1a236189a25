"""Words and numbers of equations that change with time and have no period: nothing says that they repeat.

A damped oscillator follows whatever drives it, so that all nearby motions come closer; what it comes to is told by
the drive.
"""

import numpy as np
import pytest

import chaosdrill as cd

DRIVES = {
    "cos(t)": "periodic",
    "cos(t) + sin(3*t)/2": "periodic",
    "cos(t) + cos(sqrt(2)*t)": "quasiperiodic",
    "t": "open",
    "exp(-t/100)*cos(t)": "transient",
    "cos(t**2/1000)": "",
    "log(1 + t)*cos(t)": "",
    "cos(t + t**2/100000)": "",
}
"""Drives, and the one word for each; none where only an open answer is right."""


def driven(drive):
    return cd.HybridSystem(
        name="driven", states="x v", time="t", parameters={"a": 1.0, "b": 0.0},
        modes={"on": {"x": "v", "v": f"-x - v/5 + a*({drive})"}},
    )  # fmt: skip


@pytest.mark.parametrize("drive", DRIVES)
def test_a_motion_that_follows_its_drive_has_the_word_of_that(drive):
    """Of a tone, of two without a common measure, of what grows, fades or changes its rate; in charts as in spectra."""
    system, lengths = driven(drive), {"duration": 600.0, "transient": 200.0}
    said = cd.lyapunov_spectrum(system, **lengths).cd.outcome
    assert said == DRIVES[drive] or (not DRIVES[drive] and said in ("undecided", "transient"))
    chart = cd.parameter_chart(system, {"a": [1.0], "b": [0.0]}, **lengths)
    assert cd.Outcome(int(chart.outcome.values.item())).meaning == said


@pytest.mark.parametrize("periods", [128, 256, 1024])
@pytest.mark.parametrize("drive", ["cos(t) + cos(sqrt(2)*t)", "cos(t)"])
def test_where_points_of_a_surface_are_counted_it_is_the_same(drive, periods):
    """One of the tones may turn almost whole times between the instants of so many returns."""
    system, lengths = driven(drive), {"at": "x > 0", "periods": periods, "transient": 50}
    assert cd.lyapunov_spectrum(system, **lengths).cd.outcome == DRIVES[drive]
    diagram = cd.bifurcation_diagram(system, {"a": [1.0]}, **lengths)
    assert cd.Outcome(int(diagram.outcome.values.item())).meaning == DRIVES[drive]


def test_what_is_asked_for_decides_and_no_longer_record():
    """A rate that swings slowly: later the equations are others."""
    word = cd.lyapunov_spectrum(driven("cos(t + sin(t/1000))"), duration=6000.0, transient=200.0).cd.outcome
    assert word in ("undecided", "transient")


def test_exponents_of_charts_are_those_of_the_time_that_passes():
    """Of x' = -x t/100 the exponent over times from t to t + T is -(t + T/2)/100."""
    system = cd.HybridSystem(
        name="faster", states="x", time="t", parameters={"a": 1.0, "b": 0.0}, modes={"on": {"x": "-a*x*t/100"}},
        initial={"x": 1.0},
    )  # fmt: skip
    chart = cd.parameter_chart(system, {"a": [1.0, 2.0], "b": [0.0]}, duration=20.0, transient=10.0)
    np.testing.assert_allclose(chart.lyapunov_exponent.values.ravel(), [-0.2, -0.4], rtol=1e-9)
