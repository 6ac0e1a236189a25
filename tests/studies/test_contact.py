"""Hits of the paper's figure 2: momentum goes over as the law says, in the time that the law says."""

import importlib
import json
import sys
from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest

from chaosdrill.codegen.contacts import hunt_crossley_exit

PARAMETERS = {"b": 0.7, "xi": 0.06, "eps": 1.0, "mu": 0.6, "g": 3.0, "r": 1.0, "lam": 0.6}
PERIOD1 = {**PARAMETERS, "a": 0.25, "eta": 0.8, "phi": pi / 2}


@pytest.fixture(scope="module")
def contact():
    folder = Path(__file__).parents[2] / "studies" / "paper"
    sys.path.insert(0, str(folder))
    yield importlib.import_module("contact")
    sys.path.remove(str(folder))


@pytest.mark.parametrize("speed", [0.1, 0.5])
def test_the_force_carries_the_impulse(speed, contact):
    hit = contact.hit(speed, PERIOD1)
    law, force = json.loads(hit.attrs["parameters"]), contact.force(hit)
    impulse = np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(hit["time"].values))
    # load, spring and friction, below 1, act too, for 2e-3 of a unit of time
    assert impulse == pytest.approx((speed + hunt_crossley_exit(speed, law["lam"])) / 2, abs=1e-3)
    # damping hardly changes the duration of a linear contact, load and friction less
    assert hit["time"].values[np.flatnonzero(force)[-1]] == pytest.approx(pi / sqrt(2 * law["k"]), rel=1e-2)


def test_both_contacts_leave_with_the_same_speeds(contact):
    timed, compliant = (contact.impact(name, PERIOD1) for name in contact.CONTACTS)
    for orbit in (timed, compliant):
        assert orbit["event_time"].values[0] == 0.0
        assert orbit["event_time"].values[1] == pytest.approx(pi / sqrt(2 * 12e5), rel=1e-2)
    ends = [orbit["event_state_after"].values[1, 1:3] for orbit in (timed, compliant)]
    np.testing.assert_allclose(*ends, atol=1e-3)
