"""Looks of all kinds of cells, distinct in colour, to colour-blind readers and in grey."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.dataset.outcomes import MEASURED, flag_names
from chaosdrill.plots.style import OUTCOME_COLOURS, outcome_colour, readable

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.colors import Colormap
    from numpy.typing import NDArray

# Equal steps of lightness between the black of escape and white, with that of chaos left free; a hue for each odd
# factor, darker with every doubling: 1, 2, 4, 8 are blue and 3, 6 yellow.
PERIOD_COLOURS = ("#EAF1FA", "#9BC9EE", "#F2DA6F", "#0E6FB7", "#AD8BCB", "#DCA438", "#1F6037", "#0D3B81")
LONGER_COLOUR = "#281C37"
# the same steps of lightness, the first ones farthest apart: there are seldom more than three
ATTRACTOR_COLOURS = ("#F2DA6F", "#0E6FB7", "#9BC9EE", "#1F6037", "#AD8BCB", "#0D3B81", "#EAF1FA", "#D55E00")
# of dots on white, which lie on each other: more than these are not told apart
SEED_COLOURS = ("#DCA438", "#0D3B81", "#D55E00")
# of lines on white and over the dots of a diagram, or with a white rim on any colour of a chart; even in lightness
LINE_COLOURS = ("#000000", "#33208A", "#98105E", "#C9471B", "#2F9B72", "#E0A936")
BACKGROUND = "#9E9E9E"
"""Dots of a diagram that lies behind lines."""

_OUTCOME_HATCHES = {
    "ok": "---",
    "quasiperiodic": "....",
    "undecided": "..",
    "open": "OO",
    "event_limit": "xxx",
    "stalled": "///",
    "nonfinite": "\\\\\\",
    "step_underflow": "|||",
    "invalid_start": "+++",
    "failed": "**",
    "equilibrium": "o",
    "no_return": "--",
}

# lightness in CIELAB falls evenly and alike on both sides, and so does chroma
_BELOW = ("#00467D", "#005D9D", "#0D75B9", "#4F8DCB", "#7CA6D8", "#A5BFE3", "#CBD9EE")
_ZERO = "#F4F3F4"
_ABOVE = ("#EFD2C8", "#E2B3A2", "#D3947E", "#C1765C", "#AB5A3F", "#8E432A", "#6F2F1A")


@dataclass(frozen=True)
class Look:
    """How cells of one kind are drawn and named.

    Parameters
    ----------
    name : str
        Entry of the legend.
    colour : str
        Colour of the cells.
    hatch : str, default ""
        Hatching over them, in matplotlib's letters.
    short : str, default ""
        Text to write into large regions; none if empty.
    """

    name: str
    colour: str
    hatch: str = ""
    short: str = ""

    @property
    def ink(self) -> str:
        """Black or white, whichever is readable on the colour."""
        from matplotlib.colors import to_rgb

        red, green, blue = (part**2.2 for part in to_rgb(self.colour))
        return "black" if 0.2126 * red + 0.7152 * green + 0.0722 * blue > 0.2 else "white"


MINUS_INFINITY = Look("−∞ (all directions lost at events)", _BELOW[0], "ooo")
POSITIVE = Look("positive", "#FFFFFF", "....")
NO_RESULT = Look("no result", "#FFFFFF", "oo")
"""Where a run has not reached its end, or has no such number: the same in every picture."""
NO_ATTRACTOR = Look("none", "#FFFFFF", "xx")
UNRECOGNISED = Look("attractor not recognised", "#FFFFFF", "oo")
FURTHER = Look("further attractors", "#BBBBBB", "---")
PERIOD_NOT_FOUND = Look("period not found", OUTCOME_COLOURS["periodic"], "ooo")
MOTIONS = tuple(outcome.meaning for outcome in MEASURED)
"""Outcomes of runs that reached their end."""
ATTRACTED = tuple(name for name in MOTIONS if name != "open")
"""Outcomes of runs that stay somewhere."""


def diverging() -> "Colormap":
    """Return the colours of a quantity whose sign matters: blue below zero, brown above, as dark at equal distance."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("diverging", [*_BELOW, _ZERO, *_ABOVE])


def sequential() -> "Colormap":
    """Return the colours of a quantity from little, light, to much, dark: viridis without its darkest end."""
    import matplotlib as mpl
    from matplotlib.colors import ListedColormap

    return ListedColormap(mpl.colormaps["viridis_r"](np.linspace(0, 0.9, 256)), "sequential")


def outcome_look(name: str) -> Look:
    """Return the look of an outcome by its name."""
    short = "" if name == "ok" else readable(name)
    return Look(readable(name), outcome_colour(name), _OUTCOME_HATCHES.get(name, ""), short)


def attractor_look(number: int, text: str) -> Look:
    """Return the look of an attractor by its place in the legend, from 0: colours come again with a hatching."""
    turn, place = divmod(number, len(ATTRACTOR_COLOURS))
    return Look(text, ATTRACTOR_COLOURS[place], ("", "////", "....")[turn % 3], str(number + 1))


def outcomes(dataset: "xr.Dataset") -> "tuple[NDArray[np.int64], list[Look]]":
    """Sort points by how they ended.

    Parameters
    ----------
    dataset : xarray.Dataset
        With ``outcome`` of any shape.

    Returns
    -------
    kinds : ndarray, the shape of ``outcome``
        Index of each point's kind.
    looks : list of Look
        The kinds that occur.
    """
    codes = dataset["outcome"].values
    return sort_out([(codes == code, outcome_look(name)) for code, name in flag_names(dataset["outcome"]).items()])


def motions(dataset: "xr.Dataset") -> "tuple[NDArray[np.int64], list[Look]]":
    """Sort points by period, and those without one by how they ended; parameters and results as for `outcomes`."""
    codes, period = dataset["outcome"].values, dataset["period"].values
    names = {name: code for code, name in flag_names(dataset["outcome"]).items()}
    cycle = (period > 0) & np.isin(codes, [names.get("ok", -1), names.get("periodic", -1)])
    table: list[tuple[Any, Look]] = [
        (cycle & (period == n), Look(f"period {n}", colour, short=str(n)))
        for n, colour in enumerate(PERIOD_COLOURS, start=1)
    ]
    longer = cycle & (period > len(PERIOD_COLOURS))
    if longer.any():
        first, last = period[longer].min(), period[longer].max()
        text = f"period {first}" if first == last else f"periods {first} to {last}"
        table.append((longer, Look(text, LONGER_COLOUR, short=f"≥ {first}" if first < last else str(first))))
    for name, code in names.items():
        look = outcome_look(name)
        if name == "periodic":
            look = PERIOD_NOT_FOUND
        elif name == "ok":
            look = Look("no period found", look.colour, look.hatch)
        table.append((~cycle & (codes == code), look))
    return sort_out(table)


def sort_out(table: "list[tuple[Any, Look]]") -> "tuple[NDArray[np.int64], list[Look]]":
    """Return the index of each point's kind, and the kinds that occur, from a mask for each; masks do not overlap."""
    present = [(mask, look) for mask, look in table if mask.any()]
    kinds = np.zeros(table[0][0].shape, dtype=np.int64)
    for index, (mask, _) in enumerate(present):
        kinds[mask] = index
    return kinds, [look for _, look in present]
