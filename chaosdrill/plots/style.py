"""Common style of all pictures: palettes, figures, labels from the attributes of the dataset, and categories.

Categories are distinct in colour, to colour-blind readers and in grey.
"""

import re
import textwrap
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.dataset.outcomes import MEASURED, flag_names
from chaosdrill.errors import SettingsError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    import xarray as xr
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

# Okabe and Ito's colours without yellow, which vanishes on white paper; told apart by all common kinds of colour vision
PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
# the outcomes of a run always have the same colour, in every picture
OUTCOME_COLOURS = {
    "ok": "#BBBBBB",
    "periodic": "#56B4E9",
    "quasiperiodic": "#009E73",
    "undecided": "#FFFFFF",
    "chaotic": "#D55E00",
    "escaped": "#000000",
}
OTHER_OUTCOME = "#CC79A7"
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
MODE_SHADES = ("#FFFFFF", "#DCE6F0", "#F5E6D3", "#E3EFE3", "#EFE3EC")
DOTS = (0, (1, 2))
"""Dashes of jumps."""
EVENT_MARKERS = ("v", "o", "s", "D", "^", "P", "X")
WIDTH = 7.2
_DENSEST = 300.0
_LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
_LETTERS = (
    "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau upsilon phi chi psi "
    "omega Gamma Delta Theta Lambda Xi Pi Sigma Phi Psi Omega"
)
_GREEK = dict(zip(_LETTERS.split(), "αβγδεζηθικλμνξπρστυφχψωΓΔΘΛΞΠΣΦΨΩ", strict=True))
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

_SETTINGS: Any = {
    "axes.axisbelow": True,
    "axes.labelsize": 9,
    "axes.linewidth": 0.7,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titlesize": 9,
    "figure.dpi": 150,
    "figure.titlesize": 10,
    "font.size": 9,
    "hatch.linewidth": 0.5,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "lines.linewidth": 1.1,
    "savefig.dpi": "figure",
    "svg.fonttype": "none",
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
}


_figures: "ContextVar[Callable[..., Figure] | None]" = ContextVar("figures", default=None)


@contextmanager
def made_by(figures: "Callable[..., Figure]") -> "Iterator[None]":
    """Let `new_figure` make figures by another function than matplotlib's class, such as that of pyplot."""
    token = _figures.set(figures)
    try:
        yield
    finally:
        _figures.reset(token)


def style() -> AbstractContextManager[None]:
    """Return a context in which matplotlib draws in the project's style; what was set before comes back after it."""
    import matplotlib as mpl

    return mpl.rc_context(_SETTINGS)


def new_figure(height: float, detail: float = 0.0) -> "Figure":
    """Return an empty figure of the common width, outside of pyplot's global list but for `made_by`.

    Parameters
    ----------
    height : float
        In inches.
    detail : float, default 0
        Cells an inch; where they are many, dots are so dense, up to 300 an inch, that each has one of its own.
    """
    from matplotlib.figure import Figure

    figure = (_figures.get() or Figure)(figsize=(WIDTH, height), layout="constrained")
    # labels and colour bars take their part of the width that the cells were counted over
    figure.set_dpi(float(np.clip(1.25 * detail, figure.dpi, _DENSEST)))
    return figure


def one_panel(ax: "Axes | None", height: float) -> "tuple[Figure, Axes]":
    """Return the axes that are given with their figure, or those of a new one."""
    if ax is None:
        figure = new_figure(height)
        return figure, figure.subplots()
    return owner(ax), ax


def owner(ax: "Axes") -> "Figure":
    """Return the figure that axes stand in."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    return figure


class OtherCountError(SettingsError):
    """Another number of states was asked for than the picture shows."""


def places_of(dataset: "xr.Dataset", state: "str | Sequence[str] | None", count: int) -> tuple[int, ...]:
    """Return the places of the states that a picture is asked for.

    Parameters
    ----------
    dataset : xarray.Dataset
    state : str or sequence of str, optional
        Names of states; default: the first ones.
    count : int
        How many the picture shows.

    Raises
    ------
    SettingsError
        A name that no state has, or another number of them, which is an `OtherCountError`.
    """
    names = [str(name) for name in dataset["state"].values]
    wanted = names[:count] if state is None else [state] if isinstance(state, str) else list(state)
    if unknown := [name for name in wanted if name not in names]:
        raise SettingsError(f"state names {unknown[0]!r:.60}; states are {', '.join(names)}")
    if len(wanted) != min(count, len(names)):
        example = f"state={tuple(names[:count])!r}" if count > 1 else f"state={names[0]!r}"
        raise OtherCountError(f"state is {state!r:.60}, but this picture shows {count}; give {example}")
    return tuple(names.index(name) for name in wanted)


def label(variable: "xr.DataArray", name: str | None = None) -> str:
    """Return ``long name (unit)`` of a variable or coordinate; a dimensionless one has no bracket."""
    text = name if name is not None else str(variable.attrs.get("long_name", variable.name))
    unit = str(variable.attrs.get("units", "1"))
    raised = re.sub(r"(?<=[A-Za-z])-?\d+", lambda power: power[0].translate(_RAISED), unit)
    return text if unit in ("1", "") else f"{text} ({raised})"


def symbol(name: str) -> str:
    """Return a name as a symbol, as far as plain text can: Greek letters by their names, and digits as an index."""
    parts = re.fullmatch(r"([A-Za-z]+)([0-9]*)", name)
    letter = "" if parts is None else _GREEK.get(parts[1], parts[1] if len(parts[1]) == 1 else "")
    return name if parts is None or not letter else letter + parts[2].translate(_LOWERED)


def axis_label(dataset: "xr.Dataset", name: str) -> str:
    """Return the axis label of a coordinate: its long name and its symbol, if they differ, and its unit."""
    return label(dataset[name], _with_symbol(str(dataset[name].attrs.get("long_name", name)), name))


def _with_symbol(text: str, name: str) -> str:
    """A long name and the symbol, if the name is one: a word such as ``amplitude`` says less than the long name."""
    if text in ("", name):
        return symbol(name)
    word = name.isalpha() and name.islower() and len(name) > 3 and symbol(name) == name
    return text if word or (len(name) > 1 and name in text.split()) else f"{text} {symbol(name)}"


def progression(dataset: "xr.Dataset") -> "xr.DataArray":
    """Return the progression rate, in SI units where the archive has it so."""
    return dataset["progression_rate_si" if "progression_rate_si" in dataset.variables else "progression_rate"]


def state_label(dataset: "xr.Dataset", index: int) -> str:
    """Return the axis label of state number ``index``: its long name where the archive has one, and its symbol."""
    name = str(dataset["state"].values[index])
    if "state_long_name" not in dataset.variables:
        return symbol(name)
    return _with_symbol(str(dataset["state_long_name"].values[index]), name)


def seed_names(dataset: "xr.Dataset") -> list[str]:
    """Return what each seed is called: by its name in the archive, or else by its number."""
    if "seed" in dataset.variables:
        return [readable(str(name)) for name in np.atleast_1d(dataset["seed"].values)]
    return [f"seed {number + 1}" for number in range(dataset.sizes["seed"])]


def wrapped(text: str, width: int = 18) -> str:
    """Return a label in lines of at most ``width`` characters, for an axis that is short."""
    return textwrap.fill(text, width, break_long_words=False, break_on_hyphens=False)


def readable(name: str) -> str:
    """Return a code's name as words."""
    return name.replace("_", " ").replace("-", " ")


def subscript(letter: str, number: int) -> str:
    """Return a letter with an index under it, as plain text that every backend can draw."""
    return letter + str(number).translate(_LOWERED)


def outcome_colour(name: str) -> str:
    """Return the colour of an outcome by its name."""
    return OUTCOME_COLOURS.get(name, OTHER_OUTCOME)


def shorten(value: float) -> str:
    """Return a number for a legend: four significant digits, a true minus sign, and infinity by its symbol."""
    if np.isneginf(value):
        return "−∞"
    return f"{value:.4g}".replace("-", "−")


MOST_PANELS = 12
"""Panels of a figure with one for each state or exponent, unless some are named: more cannot be read on a page."""

MOST_DIGITS = 6
"""Digits behind the point beyond which a value of a few digits is written with a power of ten."""


def uncertain(value: float, error: float) -> str:
    """Return ``value(error)`` with one digit of the error, in units of the value's last digit.

    Where both are very small that digit has its power of ten, as in ``2(4)e−15``. An error that is zero or not a number
    leaves the value alone with six significant digits.
    """
    if not np.isfinite(value):
        return shorten(value)
    if not np.isfinite(error) or error <= 0 or error < 1e-10 * abs(value):
        return f"{value:.6g}".replace("-", "−")
    digits = max(0, int(np.ceil(-np.log10(error))))
    last = round(error * 10**digits)
    if last == 10:
        digits, last = max(0, digits - 1), 1
    if digits > MOST_DIGITS and abs(round(value * 10**digits)) < 1000:
        return f"{round(value * 10**digits)}({last})e-{digits}".replace("-", "−")
    return f"{value:.{digits}f}({last})".replace("-", "−")


def legend_outside(
    figure: "Figure", handles: "Sequence[Artist]", ax: "Axes | None" = None, ncols: int = 0, **options: Any
) -> None:
    """Put one legend above all panels of a figure, with ``ncols`` columns; default: as many as find room, up to six.

    The handles bring their labels. That of a picture on axes of somebody else, ``ax``, stands above these.
    """
    if not handles:
        return
    if ax is not None:
        ax.legend(handles=handles)
        return
    labels = [str(handle.get_label()) for handle in handles]
    ncols = ncols or next((n for n in range(6, 1, -1) if _legend_width(labels, n) < 72 * WIDTH), 1)
    figure.legend(handles=handles, loc="outside upper left", ncols=ncols, **options)


def _legend_width(labels: "Sequence[str]", columns: int) -> float:
    """About how wide a legend is, in points; matplotlib fills one column after the other."""
    size = _SETTINGS["legend.fontsize"]
    longest = [
        max(len(line) for text in part for line in str(text).split("\n"))
        for part in np.array_split(labels, columns)
        if len(part)
    ]
    return float(size * sum(0.56 * letters + 4.8 for letters in longest))


def legend_above(axes: "Axes", columns: int = 6, **options: object) -> None:
    """Put the legend above the axes, where it covers no data."""
    axes.legend(
        loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, borderaxespad=0.2, handlelength=1.4, **options
    )


@dataclass(frozen=True)
class Category:
    """How cells of one category are drawn and named.

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


MINUS_INFINITY = Category("−∞ (all directions lost at events)", _BELOW[0], "ooo")
POSITIVE = Category("positive", "#FFFFFF", "....")
NO_RESULT = Category("no result", "#FFFFFF", "oo")
"""Where a run has not reached its end, or has no such number: the same in every picture."""
NO_ATTRACTOR = Category("none", "#FFFFFF", "xx")
UNRECOGNISED = Category("attractor not recognised", "#FFFFFF", "oo")
FURTHER = Category("further attractors", "#BBBBBB", "---")
PERIOD_NOT_FOUND = Category("period not found", OUTCOME_COLOURS["periodic"], "ooo")
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


def outcome_category(name: str) -> Category:
    """Return the category of an outcome by its name."""
    short = "" if name == "ok" else readable(name)
    return Category(readable(name), outcome_colour(name), _OUTCOME_HATCHES.get(name, ""), short)


def attractor_category(number: int, text: str) -> Category:
    """Return the category of an attractor by its place in the legend, from 0: colours come again with a hatching."""
    turn, place = divmod(number, len(ATTRACTOR_COLOURS))
    return Category(text, ATTRACTOR_COLOURS[place], ("", "////", "....")[turn % 3], str(number + 1))


def by_outcome(dataset: "xr.Dataset") -> "tuple[NDArray[np.int64], list[Category]]":
    """Sort points by how they ended.

    Parameters
    ----------
    dataset : xarray.Dataset
        With ``outcome`` of any shape.

    Returns
    -------
    codes : ndarray, the shape of ``outcome``
        Place of each point's category.
    categories : list of Category
        Those that occur.
    """
    codes = dataset["outcome"].values
    return classify([(codes == code, outcome_category(name)) for code, name in flag_names(dataset["outcome"]).items()])


def by_period(dataset: "xr.Dataset") -> "tuple[NDArray[np.int64], list[Category]]":
    """Sort points by period, and those without one by how they ended; parameters and results as for `by_outcome`."""
    codes, period = dataset["outcome"].values, dataset["period"].values
    names = {name: code for code, name in flag_names(dataset["outcome"]).items()}
    cycle = (period > 0) & np.isin(codes, [names.get("ok", -1), names.get("periodic", -1)])
    table: list[tuple[Any, Category]] = [
        (cycle & (period == n), Category(f"period {n}", colour, short=str(n)))
        for n, colour in enumerate(PERIOD_COLOURS, start=1)
    ]
    longer = cycle & (period > len(PERIOD_COLOURS))
    if longer.any():
        first, last = period[longer].min(), period[longer].max()
        text = f"period {first}" if first == last else f"periods {first} to {last}"
        table.append((longer, Category(text, LONGER_COLOUR, short=f"≥ {first}" if first < last else str(first))))
    for name, code in names.items():
        category = outcome_category(name)
        if name == "periodic":
            category = PERIOD_NOT_FOUND
        elif name == "ok":
            category = Category("no period found", category.colour, category.hatch)
        table.append((~cycle & (codes == code), category))
    return classify(table)


def classify(table: "list[tuple[Any, Category]]") -> "tuple[NDArray[np.int64], list[Category]]":
    """Return the place of each point's category, and those that occur, from a mask for each; masks do not overlap."""
    present = [(mask, category) for mask, category in table if mask.any()]
    codes = np.zeros(table[0][0].shape, dtype=np.int64)
    for index, (mask, _) in enumerate(present):
        codes[mask] = index
    return codes, [category for _, category in present]
