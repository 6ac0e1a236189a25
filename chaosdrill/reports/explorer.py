"""The data of a chart in which one points at a parameter and sees what happens there."""

import json
from base64 import b64encode
from typing import TYPE_CHECKING, Any

from chaosdrill.reports.html import Html, element, joined
from chaosdrill.reports.numbers import count

if TYPE_CHECKING:
    import xarray as xr

KINDS = ("bifurcation-diagram", "parameter-chart")
SECTION_BYTES = 6_000_000
GRID_BYTES = 6_000_000
"""At most so many bytes go into one chart, for its sections and for the rest."""


def explorer(dataset: "xr.Dataset", name: str, number: int, share: float = 1.0) -> Html:
    """A chart's frame and its data; the page's script fills it.

    Parameters
    ----------
    dataset : xarray.Dataset
        A diagram or a parameter chart; of any other kind there is no chart.
    name : str
        Name of its group.
    number : int
        Of the chart in the page, for ids.
    share : float, default 1
        Part of the largest size that it may have, where many share a page.
    """
    if dataset.attrs.get("kind") not in KINDS:
        return Html("")
    data, left_out = explorer_data(dataset, share)
    data["name"] = name
    key = f"explorer-{number}"
    held = "sections, exponents, period and outcome" if "section" in dataset else "exponents, period and outcome"
    keys = (
        "Click or drag in the chart. With the keyboard: arrow keys go to the next point, Page Up and Page Down by ten, "
        "Home and End to the first and the last."
    )
    if "section" not in dataset:
        keys += " This chart has no section points: they are kept if section_points says how many."
    return element(
        "div",
        element("h3", f"Point by point: {held}", id=f"{key}-title"),
        element("noscript", element("p", "This chart needs scripts; nothing else of this page does.", class_="note")),
        *(element("p", line, class_="left-out") for line in left_out),
        element(
            "div",
            element("p", keys, id=f"{key}-keys", class_="note"),
            element("div", class_="controls"),
            element(
                "div",
                element("canvas", aria_hidden="true"),
                class_="chart",
                tabindex="0",
                role="application",
                aria_roledescription="interactive chart",
                aria_labelledby=f"{key}-title",
                aria_describedby=f"{key}-keys",
            ),
            element("div", class_="legend"),
            element("p", class_="readout", role="status", aria_live="polite", aria_atomic="true"),
            element("div", class_="details"),
            class_="stage",
            hidden=True,
        ),
        element("script", _json(data), type="application/json", class_="data"),
        class_="explorer",
        id=key,
    )


def explorer_data(dataset: "xr.Dataset", share: float = 1.0) -> tuple[dict[str, Any], list[str]]:
    """What the chart shows, ready for JSON, and what had to be left out, in words.

    Numbers are 32-bit floats in base64, axes 64-bit; more cells than fit are thinned evenly in every direction, and of
    longer sections the last points are kept, among which every cycle that fits is whole.
    """
    import numpy as np

    axes = [str(name) for name in dataset["outcome"].dims if name != "seed"]
    dataset = dataset.sortby(axes).transpose(*axes, "seed", ...)
    if not all(np.isfinite(dataset[name].values).all() for name in axes):
        raise ValueError(f"{' and '.join(axes)}: not all values are finite numbers")
    left_out = []
    quantities = _quantities(dataset, axes)
    depth = sum(4 * dataset["lyapunov_exponent"].shape[-1] if name == "lyapunov_exponent" else 4 for name in quantities)
    cells = int(np.prod([dataset.sizes[name] for name in (*axes, "seed")]))
    stride = int(np.ceil((max(1.0, cells * (depth + 3) / (share * GRID_BYTES))) ** (1 / len(axes))))
    if stride > 1:
        whole = " x ".join(str(dataset.sizes[name]) for name in axes)
        dataset = dataset.isel({name: slice(None, None, stride) for name in axes})
        held = " x ".join(str(dataset.sizes[name]) for name in axes)
        left_out.append(f"Of {whole} points this chart holds {held}, one in {stride} each way; the archive has all.")
    data: dict[str, Any] = {
        "kind": str(dataset.attrs["kind"]),
        "axes": [_axis(dataset, name) for name in axes],
        "seeds": _seeds(dataset),
        "states": _states(dataset),
        "outcomes": _outcomes(dataset),
        "periods": _period_colours(),
        "outcome": _base64(dataset["outcome"].values, "i1"),
        "period": _base64(dataset["period"].values, "<i2"),
        "quantities": [_quantity(dataset, name) for name in quantities],
        "colours": _scales(),
    }
    if "section" in dataset:
        section = dataset["section"].transpose(*axes, "seed", "iterate", "state").values
        most = max(1, int(share * SECTION_BYTES) // max(1, 4 * section[..., 0, :].size))
        if section.shape[-2] > most:
            left_out.append(f"Of {section.shape[-2]} section points of each run this chart holds the last {most}.")
            section = section[..., -most:, :]
        data["section"] = {"iterates": section.shape[-2], "values": _base64(section, "<f4")}
    return data, left_out


def _quantities(dataset: "xr.Dataset", axes: list[str]) -> list[str]:
    """Variables with a number for every point, the exponents among them."""
    grid = {*axes, "seed"}
    kept = ["lyapunov_exponent", "lyapunov_error"]
    kept += [str(n) for n, v in dataset.data_vars.items() if set(v.dims) == grid and v.dtype.kind == "f"]
    if "attractor_count" in dataset and dataset["attractor_count"].dims == tuple(axes):
        kept.append("attractor_count")
    return [name for name in kept if name in dataset]


def _quantity(dataset: "xr.Dataset", name: str) -> dict[str, Any]:
    import numpy as np

    variable = dataset[name]
    values = variable.values
    if "seed" not in variable.dims:
        values = np.repeat(values[..., None], dataset.sizes["seed"], axis=-1)
    count_ = variable.sizes.get("exponent", 1)
    unit = str(variable.attrs.get("units", ""))
    return {
        "name": name,
        "label": str(variable.attrs.get("long_name", name)),
        "unit": "" if unit == "1" else unit,
        "count": count_,
        "values": _base64(values, "<f4"),
    }


def _axis(dataset: "xr.Dataset", name: str) -> dict[str, Any]:
    from chaosdrill.plot.style import axis_label

    return {"name": name, "label": axis_label(dataset, name), "values": _base64(dataset[name].values, "<f8")}


def _seeds(dataset: "xr.Dataset") -> list[str]:
    from chaosdrill.plot.style import seed_names

    return seed_names(dataset)


def _states(dataset: "xr.Dataset") -> list[dict[str, str]]:
    from chaosdrill.plot.style import state_label

    names = [str(name) for name in dataset["state_name"].values]
    return [{"name": name, "label": state_label(dataset, i)} for i, name in enumerate(names)]


def _outcomes(dataset: "xr.Dataset") -> list[dict[str, Any]]:
    from chaosdrill.dataset.outcomes import Outcome
    from chaosdrill.plot.style import flag_names, outcome_colour, readable

    advice = {outcome.meaning: outcome.advice for outcome in Outcome}
    return [
        {"code": code, "words": readable(name), "advice": advice.get(name, ""), "colour": outcome_colour(name)}
        for code, name in flag_names(dataset["outcome"]).items()
    ]


def _period_colours() -> list[str]:
    from chaosdrill.plot.looks import LONGER_COLOUR, PERIOD_COLOURS

    return [*PERIOD_COLOURS, LONGER_COLOUR]


def _scales() -> dict[str, list[str]]:
    """Colours of a scale around zero and of one that ascends, at even steps."""
    import numpy as np
    from matplotlib.colors import to_hex

    from chaosdrill.plot.looks import diverging, sequential

    at = np.linspace(0, 1, 33)
    return {"diverging": [to_hex(c) for c in diverging()(at)], "sequential": [to_hex(c) for c in sequential()(at)]}


def _base64(values: Any, dtype: str) -> str:
    import numpy as np

    with np.errstate(over="ignore", invalid="ignore"):
        return b64encode(np.ascontiguousarray(values, dtype=dtype).tobytes()).decode()


def _json(data: dict[str, Any]) -> Html:
    """JSON that cannot end the element in which it stands."""
    written = json.dumps(data, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return Html(written.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026"))


def summary(dataset: "xr.Dataset") -> Html:
    """One sentence: how many points there are over what."""
    axes = [str(name) for name in dataset["outcome"].dims if name != "seed"] if "outcome" in dataset else []
    if dataset.attrs.get("kind") not in KINDS:
        return Html("")
    over = " and ".join(f"{name} ({count(dataset.sizes[name], 'value')})" for name in axes)
    return joined([element("p", f"Over {over}, {count(dataset.sizes['seed'], 'seed')} each.")])
