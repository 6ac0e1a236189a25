"""Den Hartog's oscillator: amplitudes of the motion without sticking, and its multipliers."""

import numpy as np
import pytest

import chaosdrill as cd


@pytest.mark.parametrize(("w", "friction", "amplitude"), [(0.8, 0.3, 2.626104875723477), (0.6, 0.2, 1.550602854686835)])
def test_amplitude(w, friction, amplitude):
    system = cd.build("den-hartog", {"omega": w, "S": friction})
    run = cd.trajectory(system, periods=4, transient=400)
    kinds = [run["event_kind"].attrs["flag_meanings"].split()[k] for k in run["event_kind"].values]
    assert set(kinds) == {"reverse-forward", "reverse-backward"}
    assert len(kinds) == 8
    np.testing.assert_allclose(np.abs(run["event_state_before"].values[:, 0]), amplitude, rtol=1e-12)


def test_multipliers(multipliers):
    section = cd.poincare_section(cd.build("den-hartog", {"omega": 0.8, "S": 0.3}), periods=64, transient=400)
    assert int(section["period"]) == 1
    pair = 0.0229404527 + 0.6967002989j
    np.testing.assert_allclose(multipliers(section), [pair, pair.conjugate()], atol=1e-9)


def test_a_mass_that_friction_outweighs_stays():
    system = cd.build("den-hartog", {"omega": 0.8, "S": 1.5})
    run = cd.trajectory(system, periods=20)
    assert run["mode"].attrs["flag_meanings"].split()[int(run["mode"][-1])] == "stick"
    assert float(run["state"].values[-1, 1]) == 0.0
