"""What stands in one picture is told apart by every kind of eyes, and in grey; scales are even.

A difference of 2.3 in CIELAB is just noticed when two patches touch; regions and legends lie apart.
"""

from itertools import combinations

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from chaosdrill.dataset import Outcome
from chaosdrill.plot import looks

# Machado, Oliveira and Fernandes 2009, full severity, for linear sRGB; doi:10.1109/TVCG.2009.113
EYES = {
    "all cones": np.eye(3),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "tritanopia": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    ),
}
_TO_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
_WHITE = np.array([0.95047, 1.0, 1.08883])


def lab(colours, eyes="all cones"):
    """CIELAB (D65) of colours as they are seen, shape (k, 3)."""
    srgb = np.array([to_rgb(colour) for colour in colours])
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    seen = np.clip(linear @ EYES[eyes].T, 0, 1)
    ratio = seen @ _TO_XYZ.T / _WHITE
    f = np.where(ratio > 216 / 24389, np.cbrt(ratio), (24389 / 27 * ratio + 16) / 116)
    return np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1)


def lightness(colours):
    """What a print in grey leaves of colours: CIE L*, from 0 to 100."""
    return lab(colours)[:, 0]


# most of those after "failed" are outcomes of looking for an orbit, which no chart shows
OUTCOMES = [looks.outcome_look(o.meaning) for o in Outcome if o <= Outcome.FAILED or o.meaning in looks.MOTIONS]
PERIODS = [looks.Look(f"period {n}", colour) for n, colour in enumerate(looks.PERIOD_COLOURS, 1)]
PERIODS.append(looks.Look("longer", looks.LONGER_COLOUR))
TOGETHER = {
    "outcomes": OUTCOMES,
    "periods": PERIODS + [look for look in OUTCOMES if look.name != "periodic"] + [looks.PERIOD_NOT_FOUND],
    "attractors": [looks.attractor_look(n, str(n)) for n in range(12)]
    + [look for look in OUTCOMES if look.name not in looks.ATTRACTED]
    + [looks.UNRECOGNISED, looks.FURTHER],
    "lines": [looks.Look(colour, colour) for colour in (*looks.LINE_COLOURS, looks.BACKGROUND)],
    "seeds": [looks.Look(colour, colour) for colour in looks.SEED_COLOURS],
}


@pytest.mark.parametrize("eyes", EYES)
@pytest.mark.parametrize("picture", TOGETHER)
def test_colours_with_the_same_hatching_are_told_apart(picture, eyes):
    for a, b in combinations(TOGETHER[picture], 2):
        if a.hatch == b.hatch:
            first, second = lab([a.colour, b.colour], eyes)
            assert np.linalg.norm(first - second) > 12, (a.name, b.name)


@pytest.mark.parametrize("picture", TOGETHER)
def test_they_are_told_apart_in_grey(picture):
    for a, b in combinations(TOGETHER[picture], 2):
        if a.hatch == b.hatch:
            first, second = lightness([a.colour, b.colour])
            assert abs(first - second) > 7, (a.name, b.name)


@pytest.mark.parametrize("look", [look for group in TOGETHER.values() for look in group], ids=lambda look: look.name)
def test_text_and_hatching_are_read_on_their_colour(look):
    first, second = lightness([look.ink, look.colour])
    assert abs(first - second) > 45


@pytest.mark.parametrize("colours", [looks.SEED_COLOURS, looks.LINE_COLOURS])
def test_dots_and_lines_are_seen_on_white(colours):
    assert (lightness(colours) < 75).all()


def test_the_diverging_scale_is_even_and_both_signs_alike():
    shades = looks.diverging()(np.linspace(0, 1, 129))[:, :3]
    light = lightness(shades)
    below, above = light[:64][::-1], light[65:]
    assert light[64] == light.max() > 95
    assert np.abs(below - above).max() < 2
    for arm in (below, above):
        assert (np.diff(arm) < 0).all()
        steps = -np.diff(arm[::8])
        assert steps.min() > 0.7 * steps.mean()
        assert steps.max() < 1.3 * steps.mean()


@pytest.mark.parametrize("eyes", EYES)
def test_signs_are_told_apart(eyes):
    shades = looks.diverging()(np.linspace(0, 1, 129))[:, :3]
    seen = lab(shades, eyes)
    apart = np.linalg.norm(seen[:64][::-1] - seen[65:], axis=1)
    assert (apart[8:] > 12).all()
    assert (apart[16:] > 25).all()


def test_eight_numbers_of_attractors_are_told_apart():
    light = lightness(looks.diverging()(np.linspace(0.5, 0, 8))[:, :3])
    assert (np.diff(light) < -7).all()


def test_the_sequential_scale_is_even():
    light = lightness(looks.sequential()(np.linspace(0, 1, 17))[:, :3])
    steps = -np.diff(light)
    assert steps.min() > 0.8 * steps.mean()
    assert steps.max() < 1.2 * steps.mean()
    # escape is black
    assert light[-1] > 15


def test_a_hatching_over_a_scale_means_one_thing():
    others = [look for look in OUTCOMES if look.name not in looks.ATTRACTED] + [looks.NO_NUMBER, looks.MINUS_INFINITY]
    hatches = [look.hatch for look in [*others, looks.POSITIVE] if look.hatch]
    assert len(set(hatches)) == len(hatches)


@pytest.mark.parametrize("eyes", EYES)
def test_what_has_no_number_is_no_shade_of_the_scale(eyes):
    """Either the colour is far from all of the scale, or a hatching marks it."""
    for scale in (looks.sequential(), looks.diverging()):
        shades = lab(scale(np.linspace(0, 1, 65))[:, :3], eyes)
        for look in [*OUTCOMES, looks.NO_NUMBER, looks.MINUS_INFINITY]:
            if look.name not in looks.MOTIONS and not look.hatch:
                assert np.linalg.norm(shades - lab([look.colour], eyes), axis=1).min() > 12, look.name
