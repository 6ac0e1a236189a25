"""No fault hides another, and they come in the order of their lines."""

import re

SCENE = """\
titel = "x"
[system]
model = "percussive-drill"
[system.effects]
friction = "stribek"
rock = "moving"
[system.parameters]
etta = 0.448
eps = -1
xi = true
[system.initial]
q = 1.0
[numerics]
method = "tailor"
tolerance = 0
[analysis.spectrum]
kind = "lyapunov-spectrum"
transient = -3
periods = 2.0
[analysis.diagram]
kind = "bifurcation-diagram"
sweep.eta = []
transient = 1
[analysis.other]
kind = "bifurcation"
"""


def test_all_faults_at_once(faults):
    told = [re.match(r"scene\.toml:(\d+): ([^:]+): ", line).groups() for line in faults(SCENE)]
    assert told == [
        ("1", "titel"),
        ("5", "system.effects.friction"),
        ("8", "system.parameters.etta"),
        ("9", "system.parameters.eps"),
        ("10", "system.parameters.xi"),
        ("12", "system.initial.q"),
        ("14", "numerics.method"),
        ("15", "numerics.tolerance"),
        ("18", "analysis.spectrum.transient"),
        ("19", "analysis.spectrum.periods"),
        ("20", "analysis.diagram"),
        ("22", "analysis.diagram.sweep.eta"),
        ("25", "analysis.other.kind"),
    ]


def test_a_flood_of_faults_is_cut(faults, sound):
    told = faults(sound + "".join(f"unknown{i} = 1\n" for i in range(5000)))
    assert len(told) == 51
    assert told[-1] == "scene.toml: and 4950 more"
