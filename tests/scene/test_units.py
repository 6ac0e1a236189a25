"""Quantities are read in SI, and a wrong unit is never taken for a right one."""

import math

import pytest

from chaosdrill.units import parse_quantity


@pytest.mark.parametrize(
    ("text", "value", "dimension"),
    [
        ("250 kg", 250.0, (1, 0, 0, 0)),
        ("0.25t", 250.0, (1, 0, 0, 0)),
        ("2 mm", 2e-3, (0, 1, 0, 0)),
        ("-1.5e-3 km", -1.5, (0, 1, 0, 0)),
        ("40 kN/m", 4e4, (1, 0, -2, 0)),
        ("3.8 kN*s/m", 3800.0, (1, 0, -1, 0)),
        ("3.8 kN s/m", 3800.0, (1, 0, -1, 0)),
        ("3.8 kN·s/m", 3800.0, (1, 0, -1, 0)),
        ("1 MN/mm", 1e9, (1, 0, -2, 0)),
        ("2 N/m^1.5", 2.0, (1, -0.5, -2, 0)),
        ("2 kg m/s2", 2.0, (1, 1, -2, 0)),
        ("12 s/m", 12.0, (0, -1, 1, 0)),
        ("90 rpm", 3 * math.pi, (0, 0, -1, 1)),
        ("2 Hz", 4 * math.pi, (0, 0, -1, 1)),
        ("180 deg", math.pi, (0, 0, 0, 1)),
        ("1 1/min", 1 / 60, (0, 0, -1, 0)),
        ("0.8", 0.8, (0, 0, 0, 0)),
    ],
)
def test_quantity(text, value, dimension):
    quantity = parse_quantity(text)
    assert quantity.value == pytest.approx(value, rel=1e-15)
    assert quantity.dimension == pytest.approx(dimension)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("kg", "not a number"),
        ("", "not a number"),
        ("2,5 kg", "cannot read the unit"),
        ("5 lbf", "unknown unit 'lbf'; known are 1, kg"),
        ("5 12", "cannot read the unit"),
        ("5 kg//m", "cannot read the unit"),
        ("5 kg**", "cannot read the unit"),
        ("1e999 kg", "not a finite number"),
        ("1 km^9999999", "cannot read the unit"),
        ("nan kg", "not a number"),
        ("1 kg" + " " * 200, "not a number"),
        ("__import__('os')", "not a number"),
    ],
)
def test_refused(text, reason):
    with pytest.raises(ValueError, match=reason):
        parse_quantity(text)
