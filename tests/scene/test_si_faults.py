"""Quantities with a wrong unit, a wrong sign, missing, or of nothing that is simulated."""

import pytest

from chaosdrill.scene import parse_scene

CASES = [
    ('m1 = "250 kg"', 'm1 = "-250 kg"', "5: system.si.m1: must be greater than 0, received '-250 kg'"),
    (
        'm1 = "250 kg"',
        'm1 = "250 N"',
        "5: system.si.m1: has the wrong dimension, received '250 N'",
    ),
    ('m1 = "250 kg"', "m1 = 250", "5: system.si.m1: needs a unit, as in '250 kg'; received 250"),
    ('m1 = "250 kg"', "m1 = true", "5: system.si.m1: expected a quantity such as '250 kg', received True"),
    ('m1 = "250 kg"', 'M1 = "250 kg"', "5: system.si.M1: unknown quantity; did you mean 'm1'?"),
    ('m1 = "250 kg"', 'm1 = "1e300 kg"', "5: system.si.m1: received '1e300 kg', which makes m1/m2"),
    ('K = "4 MN/m"', 'K = "0 N/m"', "7: system.si.K: must be greater than 0"),
    ('C = "3.8 kN*s/m"', 'C = "-3.8 kN*s/m"', "8: system.si.C: must not be negative"),
    ('omega = "100 rad/s"', 'omega = "100 1/s"', "12: system.si.omega: has the wrong dimension"),
    ('omega = "100 rad/s"', 'rpm = "90 rpm"', "4: system.si.lobes: missing; a scene in SI units needs it, as in '3'"),
    ('omega = "100 rad/s"', 'omega = "9 Hz"\nlobes = 3', "4: system.si.rpm: missing"),
    ("mu_d = 0.48", "", "4: system.si.mu_d: missing; a scene in SI units needs it, as in '0.48'"),
    ("mu_d = 0.48", "mu_d = 0.9", "4: system.si: the friction ratio mu_d/mu_e must be at least 0 and at most 1"),
    ('k_c = "4.8e12 N/m"', 'k_c = "4.8e12 N/m^1.5"', "17: system.si.k_c: has the wrong dimension"),
    ('"hunt-crossley"', '"none"', "11: system.si.R: no chosen effect uses it"),
    ("[system.si]", "parameters.eta = 1\n[system.si]", "13: system.si.omega: system.parameters.eta is given too"),
]


@pytest.mark.parametrize(("old", "new", "message"), CASES, ids=[case[1] or case[0] for case in CASES])
def test_fault(in_si, faults, old, new, message):
    assert old in in_si
    assert any(line.startswith(f"scene.toml:{message}") for line in faults(in_si.replace(old, new, 1)))


def test_quantities_of_another_system(faults):
    text = '[system]\nmodel = "lorenz"\n[system.si]\nm1 = "250 kg"\n'
    assert faults(text)[0].startswith("scene.toml:3: system.si: only percussive-drill")


def test_lobes_and_rotation_make_the_frequency(in_si):
    direct = parse_scene(in_si.replace('"100 rad/s"', '"4.5 Hz"'))
    turned = parse_scene(in_si.replace('omega = "100 rad/s"', 'rpm = "90 rpm"\nlobes = 3'))
    assert turned.parameters["eta"] == pytest.approx(direct.parameters["eta"], rel=1e-14)
    assert "lobes" not in turned.parameters


def test_contact_of_another_exponent(in_si):
    scene = parse_scene(in_si.replace("n = 1", "n = 1.5").replace("4.8e12 N/m", "4.8e12 N/m^1.5"))
    # force at a depth of one dimensionless unit, which is 2 mm
    assert scene.parameters["k"] == pytest.approx(4.8e12 * 2e-3**1.5 / 8e3, rel=1e-12)
