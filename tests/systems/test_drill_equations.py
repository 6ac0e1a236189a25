"""The dimensionless drill is the drill in SI units: forces on both masses, written out once more by hand."""

from math import cos, exp, pi, sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

import chaosdrill as cd
from chaosdrill import systems

positive = st.floats(0.1, 10.0)
real = st.floats(-2.0, 2.0)


@given(
    si=st.fixed_dictionaries(dict.fromkeys(("m1", "m2", "K", "C", "A", "B", "w", "F_N", "mu_e", "gamma"), positive)),
    ratio=st.floats(0.1, 1.0),
    stretch=real,
    speeds=st.tuples(real, st.floats(0.0, 2.0)),
    instant=st.floats(0.0, 10.0),
)
def test_accelerations_agree_with_newton_in_si_units(number, si, ratio, stretch, speeds, instant):
    m1, m2, stiffness, damping, gamma = si["m1"], si["m2"], si["K"], si["C"], si["gamma"]
    bit, rock = speeds
    friction = si["mu_e"] * si["F_N"]
    rate = sqrt(stiffness / m1)
    length = friction / stiffness
    inner = stiffness * stretch + damping * (bit - rock)
    grip = si["F_N"] * (ratio * si["mu_e"] + (1 - ratio) * si["mu_e"] * exp(-gamma * rock))
    bit_si = (si["A"] * cos(si["w"] * instant + pi / 2) + si["B"] - inner) / m1
    rock_si = (inner - grip) / m2

    system = cd.drill(
        a=si["A"] / friction,
        b=si["B"] / friction,
        xi=damping / (2 * m1 * rate),
        eps=m1 / m2,
        eta=si["w"] / rate,
        mu=ratio,
        g=gamma * rate * length,
    )
    here = {
        **system.parameters,
        "t": rate * instant,
        "y": stretch / length,
        "u": bit / (length * rate),
        "w": rock / (length * rate),
    }
    slip = {state.name: number(f, here) for state, f in system.modes["slip"].items()}
    assert slip["u"] * length * rate**2 == pytest.approx(bit_si, rel=1e-9, abs=1e-9)
    assert slip["w"] * length * rate**2 == pytest.approx(rock_si, rel=1e-9, abs=1e-9)
    assert slip["y"] * length * rate == pytest.approx(bit - rock, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("mode", ["stick", "slip"])
@given(st.tuples(real, real, st.floats(0.0, 2.0)), st.floats(-3.0, 3.0), st.floats(-50.0, 50.0))
def test_the_five_dimensional_form_is_the_same_flow(number, mode, state, phase, advance):
    reduced, full = cd.drill(phi=0.0), systems.build("percussive-drill-5d", {"phi": 0.0})
    y, u, w = state if mode == "slip" else (*state[:2], 0.0)
    here = {**reduced.parameters, "t": phase / reduced.parameters["eta"], "y": y, "u": u, "w": w}
    there = {**full.parameters, "x1": y + advance, "x2": u, "x3": advance, "x4": w, "x5": phase}
    small = [number(f, here) for f in reduced.modes[mode].values()]
    x1, x2, x3, x4, x5 = (number(f, there) for f in full.modes[mode].values())
    assert small == pytest.approx([x1 - x3, x2, x4], rel=1e-12, abs=1e-12)
    assert x3 == w
    assert x5 == full.parameters["eta"]


def test_friction_is_continuous_where_a_stribeck_rock_starts_to_slide(number):
    system = cd.drill()
    start = {**system.parameters, "t": 0.3, "u": 0.4, "w": 0.0}
    start["y"] = 1 - 2 * system.parameters["xi"] * start["u"]
    for state in system.states:
        before, after = (number(system.modes[mode][state], start) for mode in ("stick", "slip"))
        assert after == pytest.approx(before, abs=1e-15)


def test_a_coulomb_rock_starts_with_a_jerk(number):
    system = cd.drill(friction="coulomb", mu=0.6)
    start = {**system.parameters, "t": 0.3, "u": 0.4, "w": 0.0}
    start["y"] = 1 - 2 * system.parameters["xi"] * start["u"]
    assert number(system.modes["slip"][system.states[2]], start) == pytest.approx(0.4)


def test_lobes_shake_at_their_number_times_the_rotation(number):
    lobes = cd.drill(drive="lobes", lobes=6, spin=0.105)
    harmonic = cd.drill(eta=0.63)
    assert lobes.forcing_period() == pytest.approx(harmonic.forcing_period(), rel=1e-15)
    here = {"t": 1.7, "y": 0.2, "u": 0.1, "w": 0.0}
    for state in lobes.states:
        assert number(lobes.modes["slip"][state], {**lobes.parameters, **here}) == pytest.approx(
            number(harmonic.modes["slip"][state], {**harmonic.parameters, **here}), rel=1e-14
        )
