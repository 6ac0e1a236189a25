"""Colours, shades, dashes and markers: distinct in colour, to colour-blind readers and in grey."""

import matplotlib as mpl
import numpy as np
from matplotlib.colors import LinearSegmentedColormap, ListedColormap

from chaosdrill.plots._types import Colormap

# Okabe and Ito's colours without yellow, which vanishes on white paper; distinct for all common kinds of colour vision
PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
OTHER_OUTCOME = "#CC79A7"
# the outcomes of a run always have the same colour, and hatching in matplotlib's letters, in every picture
OUTCOMES = {
    "ok": ("#BBBBBB", "---"),
    "periodic": ("#56B4E9", ""),
    "quasiperiodic": ("#009E73", "...."),
    "undecided": ("#FFFFFF", ".."),
    "transient": ("#FFFFFF", "\\\\"),
    "contracting": ("#0072B2", "++"),
    "chaotic": ("#D55E00", ""),
    "escaped": ("#000000", ""),
    "open": (OTHER_OUTCOME, "OO"),
    "event_limit": (OTHER_OUTCOME, "xxx"),
    "stalled": (OTHER_OUTCOME, "///"),
    "nonfinite": (OTHER_OUTCOME, "\\\\\\"),
    "step_underflow": (OTHER_OUTCOME, "|||"),
    "invalid_start": (OTHER_OUTCOME, "+++"),
    "failed": (OTHER_OUTCOME, "**"),
    "equilibrium": (OTHER_OUTCOME, "o"),
    "no_return": (OTHER_OUTCOME, "--"),
}
# Equal steps of lightness between the black of escape and white, with that of chaos left free; a hue for each odd
# factor, darker with every doubling: 1, 2, 4, 8 are blue and 3, 6 yellow.
PERIOD_COLOURS = ("#EAF1FA", "#9BC9EE", "#F2DA6F", "#0E6FB7", "#AD8BCB", "#DCA438", "#1F6037", "#0D3B81")
LONGER_COLOUR = "#281C37"
# the same steps of lightness, the first ones farthest apart: there are seldom more than three
ATTRACTOR_COLOURS = ("#F2DA6F", "#0E6FB7", "#9BC9EE", "#1F6037", "#AD8BCB", "#0D3B81", "#EAF1FA", "#D55E00")
# of dots on white, which lie on each other: more than these cannot be distinguished
SEED_COLOURS = ("#DCA438", "#0D3B81", "#D55E00")
# of lines on white and over the dots of a diagram, or with a white rim on any colour of a chart; even in lightness
LINE_COLOURS = ("#000000", "#33208A", "#98105E", "#C9471B", "#2F9B72", "#E0A936")
BACKGROUND = "#9E9E9E"
"""Dots of a diagram behind lines."""

# lightness in CIELAB falls evenly and alike on both sides, and so does chroma
BELOW = ("#00467D", "#005D9D", "#0D75B9", "#4F8DCB", "#7CA6D8", "#A5BFE3", "#CBD9EE")
_ZERO = "#F4F3F4"
_ABOVE = ("#EFD2C8", "#E2B3A2", "#D3947E", "#C1765C", "#AB5A3F", "#8E432A", "#6F2F1A")
MODE_SHADES = ("#FFFFFF", "#DCE6F0", "#F5E6D3", "#E3EFE3", "#EFE3EC")
DASHES = ("-", "--", "-.", ":")
DOTS = (0, (1, 2))
"""Dashes of jumps."""
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
"""Of methods and of periods, beside their colours."""
EVENT_MARKERS = ("v", "o", "s", "D", "^", "P", "X")


def event_look(number: int) -> tuple[str, str]:
    """Return the marker and the colour of a kind of event, along a trajectory in the first colour."""
    return EVENT_MARKERS[number % len(EVENT_MARKERS)], PALETTE[1 + number % (len(PALETTE) - 1)]


def diverging() -> Colormap:
    """Return the colours of a quantity with a sign: blue below zero, brown above, equally dark at equal distance."""
    return LinearSegmentedColormap.from_list("diverging", [*BELOW, _ZERO, *_ABOVE])


def sequential() -> Colormap:
    """Return the colours of a quantity from small (light) to large (dark): viridis without its darkest end."""
    return ListedColormap(mpl.colormaps["viridis_r"](np.linspace(0, 0.9, 256)), "sequential")
