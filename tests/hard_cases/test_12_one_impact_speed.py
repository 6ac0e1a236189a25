"""Case 12: a period-1 orbit has one impact speed; without event location it shows hundreds."""

import numpy as np
import pytest

import chaosdrill as cd


@pytest.mark.parametrize(
    ("settings", "spread"),
    [
        ({"tolerance": 1e-12}, 1e-11),
        ({"tolerance": 1e-6}, 1e-5),
        ({"method": "rk4", "steps": 200, "tolerance": 1e-12}, 1e-10),
        ({"method": "rk4", "steps": 50, "tolerance": 1e-12}, 1e-10),
    ],
    ids=str,
)
def test_all_impacts_have_one_speed(settings, spread):
    system = cd.build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "omega": 2.6, "e": 0.8})
    run = cd.trajectory(system, periods=400, transient=2000, samples=2, **settings)
    speeds = run["event_speed"].values
    assert len(speeds) == 400
    assert np.ptp(speeds) < spread * speeds.mean()
