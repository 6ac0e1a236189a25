from textwrap import dedent

import pytest

from chaosdrill.errors import SceneError
from chaosdrill.scene import parse_scene

SOUND = """\
title = "A sound scene"
[system]
model = "percussive-drill"
[system.effects]
drive = "harmonic"
friction = "stribeck"
rock = "moving"
contact = "hunt-crossley"
[system.parameters]
eta = 0.448
[system.initial]
y = 0.0
[numerics]
method = "taylor"
tolerance = 1e-12
[analysis.spectrum]
kind = "lyapunov-spectrum"
transient = 10
periods = 20
[analysis.diagram]
kind = "bifurcation-diagram"
sweep.eta = { start = 0.4, stop = 0.9, num = 3 }
transient = 3
periods = 8
"""

IN_SI = """\
[system]
model = "percussive-drill"
effects = { drive = "harmonic", friction = "stribeck", rock = "moving", contact = "hunt-crossley" }
[system.si]
m1 = "250 kg"
m2 = "0.125 t"
K = "4 MN/m"
C = "3.8 kN*s/m"
A = "2 kN"
B = "5.6 kN"
R = "2 mm"
omega = "100 rad/s"
F_N = "10 kN"
mu_e = 0.8
mu_d = 0.48
gamma = "12 s/m"
k_c = "4.8e12 N/m"
lambda = "2.4 s/m"
n = 1
"""


@pytest.fixture
def sound():
    """Text of a scene without faults."""
    return SOUND


@pytest.fixture(scope="session")
def in_si():
    """Text of a scene in SI units without faults."""
    return IN_SI


@pytest.fixture
def faults():
    """Function that parses a scene and returns the lines of the error."""

    def parse(text):
        with pytest.raises(SceneError) as caught:
            parse_scene(dedent(text), "scene.toml")
        return str(caught.value).splitlines()

    return parse
