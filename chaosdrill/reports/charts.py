"""Embedded pictures, and interactive charts that show the motion at a selected parameter."""

from base64 import b64encode
from collections.abc import Mapping, Sequence
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup
from matplotlib.colors import to_hex

from chaosdrill.annotations import Dataset
from chaosdrill.dataset.outcomes import ADVICE, flag_names
from chaosdrill.reports.html import NOTHING, count, part, render
from chaosdrill.reports.tables import unit
from chaosdrill.reports.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.plots import Picture

KINDS = ("bifurcation-diagram", "parameter-chart")


def figure(picture: "Picture", names: Sequence[str], groups: Mapping[str, Dataset]) -> Markup:
    """Draw a picture of one group, or of several groups that belong together.

    ``names``: groups that it shows. ``groups``: all groups of the archive, one of which may be the background.
    """
    from chaosdrill.plots import behind
    from chaosdrill.plots.style import page_style

    with page_style():
        drawn = picture.draw(*(groups[name] for name in names), over=behind(picture, groups[names[0]], dict(groups)))
        stored, kind = BytesIO(), "svg+xml"
        drawn.savefig(stored, format="svg", metadata={"Date": None})
        if stored.tell() > TUNING.svg_bytes:
            stored, kind = BytesIO(), "png"
            drawn.savefig(stored, format="png")
        width, height = drawn.get_size_inches()
        # a function that draws more or less, depending on what there is, says so itself
        summary = str(drawn.get_label()) or picture.summary
        drawn.clear()
    title = in_words(picture.name)
    title = title[:1].upper() + title[1:]
    shown = ", ".join(name for name in names if not is_said(name, picture))
    return part(
        "figure",
        kind,
        Markup(b64encode(stored.getvalue()).decode()),
        f"{title} of {shown}" if shown else title,
        summary,
        round(96 * width),
        round(96 * height),
    )


def in_words(name: str) -> str:
    """Name of a kind or of a picture as words."""
    return name.replace("-", " ").replace("poincare", "Poincaré")


def is_said(name: str, picture: "Picture") -> bool:
    """Whether a group has the name of its picture or analysis, so that it is written once."""
    said = {word for one in (picture.name, picture.kind) for word in one.lower().split("-")}
    return set(name.lower().replace("_", "-").split("-")) <= said


def explorer(dataset: Dataset, name: str, number: int, share: float = 1.0) -> Markup:
    """The frame and data of a chart, which the script of the page draws; nothing for kinds without a chart.

    ``name``: name of the dataset's group. ``number``: number of the chart in the page, for ids. ``share``: fraction of
    the largest size that it may have, when many share a page.
    """
    if dataset.attrs.get("kind") not in KINDS:
        return NOTHING
    data, left_out = explorer_data(dataset, share)
    return render(
        "explorer.html",
        key=f"explorer-{number}",
        has_section="section" in dataset,
        left_out=left_out,
        data={**data, "name": name},
    )


def explorer_data(dataset: Dataset, share: float = 1.0) -> tuple[dict[str, Any], list[str]]:
    """Contents of the chart, ready for JSON, and a note on omitted points.

    Numbers are 32-bit floats in base64, axes 64-bit. Larger grids are thinned evenly in every direction, and the last
    points of longer sections are kept, which include a whole turn of every cycle that fits.
    """
    from chaosdrill.plots.contents import shown_in_si
    from chaosdrill.plots.labels import axis_label, seed_names, state_label
    from chaosdrill.plots.palette import LONGER_COLOUR, PERIOD_COLOURS

    dataset = shown_in_si(dataset)
    axes = [str(name) for name in dataset["outcome"].dims if name != "seed"]
    # sorting copies all variables
    if not all(dataset.indexes[name].is_monotonic_increasing for name in axes):
        dataset = dataset.sortby(axes)
    if not all(np.isfinite(dataset[name].values).all() for name in axes):
        raise ValueError(f"{' and '.join(axes)}: not all values are finite numbers")
    left_out = []
    quantities = _quantities(dataset, axes)
    depth = sum(4 * dataset["lyapunov_exponent"].shape[-1] if name == "lyapunov_exponent" else 4 for name in quantities)
    cells = int(np.prod([dataset.sizes[name] for name in (*axes, "seed")]))
    stride = int(np.ceil((max(1.0, cells * (depth + 3) / (share * TUNING.grid_bytes))) ** (1 / len(axes))))
    if stride > 1:
        whole = " x ".join(str(dataset.sizes[name]) for name in axes)
        dataset = dataset.isel({name: slice(None, None, stride) for name in axes})
        held = " x ".join(str(dataset.sizes[name]) for name in axes)
        left_out.append(f"Of {whole} points this chart holds {held}, one in {stride} each way; the archive has all.")
    data: dict[str, Any] = {
        "kind": str(dataset.attrs["kind"]),
        "axes": [
            {"name": name, "label": axis_label(dataset, name), "values": _base64(dataset[name].values, "<f8")}
            for name in axes
        ],
        "seeds": seed_names(dataset),
        "states": [
            {"name": str(name), "label": state_label(dataset, i)} for i, name in enumerate(dataset["state"].values)
        ],
        "outcomes": _outcomes(dataset),
        "periods": [*PERIOD_COLOURS, LONGER_COLOUR],
        "outcome": _base64(dataset["outcome"].values, "i1"),
        "period": _base64(dataset["period"].values, "<i2"),
        "quantities": [_quantity(dataset, name) for name in quantities],
        "colours": _scales(),
    }
    if "section" in dataset:
        section = dataset["section"].transpose(*axes, "seed", "iterate", "state").values
        most = max(1, int(share * TUNING.section_bytes) // max(1, 4 * section[..., 0, :].size))
        if section.shape[-2] > most:
            left_out.append(f"Of {section.shape[-2]} section points of each run this chart holds the last {most}.")
            section = section[..., -most:, :]
        data["section"] = {"iterates": section.shape[-2], "values": _base64(section, "<f4")}
    return data, left_out


def _quantities(dataset: Dataset, axes: list[str]) -> list[str]:
    """Variables with a number for every point, the exponents among them."""
    grid = {*axes, "seed"}
    kept = ["lyapunov_exponent", "lyapunov_error"]
    kept += [str(n) for n, v in dataset.data_vars.items() if set(v.dims) == grid and v.dtype.kind == "f"]
    if "attractor_count" in dataset and dataset["attractor_count"].dims == tuple(axes):
        kept.append("attractor_count")
    return [name for name in kept if name in dataset]


def _quantity(dataset: Dataset, name: str) -> dict[str, Any]:
    variable = dataset[name]
    values = variable.values
    if "seed" not in variable.dims:
        values = np.repeat(values[..., None], dataset.sizes["seed"], axis=-1)
    return {
        "name": name,
        "label": str(variable.attrs.get("long_name", name)),
        "unit": unit(variable.attrs),
        "count": variable.sizes.get("exponent", 1),
        "values": _base64(values, "<f4"),
    }


def _outcomes(dataset: Dataset) -> list[dict[str, Any]]:
    from chaosdrill.plots.categories import outcome_category

    looks = {name: (code, outcome_category(name)) for code, name in flag_names(dataset["outcome"]).items()}
    return [
        {"code": code, "words": look.name, "advice": ADVICE.get(name, ""), "colour": look.colour}
        for name, (code, look) in looks.items()
    ]


def _scales() -> dict[str, list[str]]:
    """Colours of a diverging and of a sequential scale, at even steps."""
    from chaosdrill.plots.palette import diverging, sequential

    at = np.linspace(0, 1, 33)
    return {"diverging": [to_hex(c) for c in diverging()(at)], "sequential": [to_hex(c) for c in sequential()(at)]}


def _base64(values: Any, dtype: str) -> str:
    with np.errstate(over="ignore", invalid="ignore"):
        return b64encode(np.ascontiguousarray(values, dtype=dtype).tobytes()).decode()


def summary(dataset: Dataset) -> Markup:
    """One sentence: the number of points and the parameters."""
    axes = [str(name) for name in dataset["outcome"].dims if name != "seed"] if "outcome" in dataset else []
    if dataset.attrs.get("kind") not in KINDS:
        return NOTHING
    over = " and ".join(f"{name} ({count(dataset.sizes[name], 'value')})" for name in axes)
    return part("paragraph", f"Over {over}, {count(dataset.sizes['seed'], 'seed')} each.")
