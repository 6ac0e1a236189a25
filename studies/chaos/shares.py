"""Which starts lead to fast drilling over the static load and over the amplitude; the same by the outside program."""

import json

import fixed_step
import numpy as np
import xarray as xr
from branches import FAST, SLOW
from findings import Claim, ended, table

AGAIN = {"b": (0.66, 0.7, 0.73, 0.758), "a": (0.22, 0.25, 0.28, 0.31)}
"""Values at which all starts are run again by the independent program."""

SHOWN = {"b": (0.65, 0.68, 0.7, 0.72, 0.74, 0.75), "a": (0.2, 0.23, 0.25, 0.26, 0.28, 0.32)}
"""Values of the table."""

NAMES = ("fast", "slow or standing", "runs away", "other")


def ends(found: xr.Dataset) -> xr.DataArray:
    """Return what every start leads to at every value, as an index of ``NAMES``; -1 if it is no start of the model."""
    rates = found["attractor_rate"]
    rate = rates.sel(attractor=found["reached"].clip(1)).where(found["reached"] > 0)
    kind = np.select(
        [rate > FAST, rate < SLOW, ended(found, "escaped"), ended(found, "invalid_start")], [0, 1, 2, -1], 3
    )
    return xr.DataArray(kind, found["reached"].coords, found["reached"].dims)


def compare(found: xr.Dataset) -> tuple[str, list[Claim]]:
    """Return the table of shares over the one parameter, and that the independent program ends most starts alike."""
    name = next(key for key in AGAIN if key in found.sizes)
    kinds = ends(found)
    rows = []
    for value in SHOWN[name]:
        at = kinds.sel({name: value}, method="nearest").values
        at = at[at >= 0]
        rows.append([f"{value:g}", *(f"{100 * np.mean(at == k):.0f} %" for k in range(3))])
    alike, runs = 0, 0
    law = json.loads(found.attrs["parameters"])
    for value in AGAIN[name]:
        at = kinds.sel({name: value}, method="nearest")
        p = fixed_step.parameters(**law | {name: float(at[name])})
        for start, kind in zip(found["initial_state"].values, at.values, strict=True):
            if kind in (0, 1, 2):
                rate = fixed_step.run(p, start, 200, 20, 1e-7)[0]
                runs += 1
                alike += kind == (2 if np.isnan(rate) else int(rate < SLOW))
    return table([f"${name}$", *NAMES[:3]], rows), [
        Claim(
            f"the independent program ends 98 of 100 starts alike, at four values of {name}",
            f"{alike} of {runs}",
            alike >= 0.98 * runs,
        ),
        *(_over_load(kinds) if name == "b" else _over_amplitude(kinds, found["attractor_rate"].max("attractor"))),
    ]


def _parts(kinds: xr.DataArray, kind: int) -> np.ndarray:
    return np.asarray((kinds == kind).sum("run") / (kinds >= 0).sum("run"))


def _over_load(kinds: xr.DataArray) -> list[Claim]:
    b, fast, gone = kinds["b"].values, _parts(kinds, 0), _parts(kinds, 2)
    return [
        Claim(
            "over b, fast drilling begins between 0.692 and 0.694 and ends between 0.754 and 0.756",
            f"{b[fast > 0].min():.3f} to {b[fast > 0].max():.3f}",
            bool(abs(b[fast > 0].min() - 0.694) < 1e-6 and abs(b[fast > 0].max() - 0.754) < 1e-6),
        ),
        Claim(
            "over b, the share of runaway grows from 0.65 on, and is 100 % from 0.756 on",
            f"{100 * gone[0]:.0f} % at {b[0]:g}, {100 * gone[b > 0.755].min():.0f} % beyond 0.755",
            bool(gone[b > 0.755].min() == 1 and (np.diff(gone[b >= 0.65]) > -0.02).all()),
        ),
    ]


def _over_amplitude(kinds: xr.DataArray, rate: xr.DataArray) -> list[Claim]:
    a, fast, slow, gone = kinds["a"].values, _parts(kinds, 0), _parts(kinds, 1), _parts(kinds, 2)
    before, after = rate.sel(a=[0.25, 0.28], method="nearest").values
    return [
        Claim(
            "over a, fast drilling begins at 0.2435, and the slow motion is gone from 0.266 on",
            f"{a[fast > 0].min():.4f}, {a[slow > 0].max():.4f}",
            bool(abs(a[fast > 0].min() - 0.2435) < 1e-6 and 0.2635 < a[slow > 0].max() < 0.266),
        ),
        Claim(
            "over a, the share of runaway decreases",
            f"{100 * gone[0]:.0f} % at {a[0]:g}, {100 * gone[-1]:.0f} % at {a[-1]:g}",
            bool(gone[0] > 2 * gone[-1] and (np.diff(gone) < 0.02).all()),
        ),
        Claim(
            "the rate of the fast motion at a = 0.28 is 40 to 50 per cent higher than at 0.25",
            f"{100 * (after / before - 1):.0f} %",
            bool(1.4 < after / before < 1.5),
        ),
    ]
