"""Whether two runs on different machines or versions agree: by what can be compared of each variable.

Round-off differs between processors and libraries. Cycles, multipliers and everything else that attracts agree within
the error of the method all the same; in chaos two runs part, and only averages agree, within their standard errors.
"""

from typing import TYPE_CHECKING, Any

from chaosdrill.dataset.outcomes import Outcome
from chaosdrill.dataset.schema import SCHEMA

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

STATED = 1e-8
"""Relative error within which cycles and multipliers agree, at tolerances of 1e-11 and less."""

PER_TOLERANCE = 1e3
"""That error over the tolerance of the method, at larger tolerances."""

DEVIATIONS = 8.0
"""Standard errors within which averages agree: few frequencies are behind one, and five are passed once in 10,000."""

BAR = 30.0
"""Factor within which the error bars of two runs agree: with so few frequencies ten is passed in one of 500."""

LEADERS = {"time": "states", "iterate": "section", "event": "event_state_before"}
"""Dimensions along which a run is recorded, and the variable that tells from where on two runs have parted."""

_UNDECIDED = (Outcome.OK, Outcome.QUASIPERIODIC, Outcome.CHAOTIC, Outcome.UNDECIDED)
_ORBITS = ("periodic-orbit", "continuation")
_ROUND_OFF = 1e-9
_GROWTH = 1e4
_LEAST = 1e-15
_MARGIN = 0.25


def agreement(name: str, first: "xr.Dataset", second: "xr.Dataset") -> tuple[str, "np.ndarray"]:
    """How one variable of two runs is compared, and where it disagrees.

    Parameters
    ----------
    name : str
        A variable of the same shape in both.
    first, second : xarray.Dataset
        One group of each archive.

    Returns
    -------
    how : str
        In words, for a table.
    wrong : ndarray of bool
        Where the two disagree.
    """
    import numpy as np

    table = SCHEMA.get(str(second.attrs.get("kind")), {})
    declared = table.get(name)
    rule, bar = ("", "") if declared is None else (declared.rule, declared.bar)
    one, other = first[name].variable, second[name].variable
    if one.dtype.kind in "OUT" or other.dtype.kind in "OUT":
        return "exactly", np.asarray(one.values, dtype=str) != np.asarray(other.values, dtype=str)
    a, b = one.values.astype(float), other.values.astype(float)
    loose = ~np.broadcast_to(_settled(first, second, one), a.shape)
    axis = name in first.coords
    bound = STATED if axis else _stated(second)
    with np.errstate(invalid="ignore", over="ignore"):
        apart = np.where((a == b) | (np.isnan(a) & np.isnan(b)), 0.0, np.abs(a - b))
    apart = np.where(np.isnan(apart), np.inf, apart)
    allowed = bound * np.maximum(1.0, np.where(np.isfinite(b), np.abs(b), 1.0))
    if rule == "magnitude":
        least = np.minimum(np.abs(a), np.abs(b))
        return "order of magnitude", apart > np.maximum(9 * np.where(np.isfinite(least), least, 0.0), _ROUND_OFF)
    whole = one.dtype.kind in "iub" and rule != "average"
    if not loose.any():
        return ("exactly", apart > 0) if whole else (f"within {bound:.0e}", apart > allowed)
    if bar and _in_both(bar, first, second):
        bars = _spread(bar, first, second, one)
        return f"within {DEVIATIONS:g} standard errors", apart > allowed + np.where(loose, DEVIATIONS * bars, 0.0)
    if name in {variable.bar for variable in table.values()}:
        least = np.minimum(np.abs(a), np.abs(b))
        allowed = allowed + np.where(loose & np.isfinite(least), (BAR - 1) * least, 0.0)
        return f"within a factor of {BAR:g}", apart > allowed
    if rule == "average":
        return "within a tenth", apart > allowed + np.where(loose, 0.1 * np.abs(np.nan_to_num(b)) + 0.1, 0.0)
    if rule == "sampled":
        return "not in chaos", (apart > allowed) & ~loose
    wrong = apart > (0.0 if whole else allowed)
    if not axis and any(dim in LEADERS for dim in one.dims):
        return _recorded(name, first, second, wrong, loose, bound)
    return "exactly" if whole else f"within {bound:.0e}", wrong


def _stated(ds: "xr.Dataset") -> float:
    try:
        tolerance = float(ds.attrs["tolerance"])
    except (KeyError, TypeError, ValueError):
        return STATED
    return max(STATED, PER_TOLERANCE * tolerance)


def _in_both(name: str, first: "xr.Dataset", second: "xr.Dataset") -> bool:
    """Whether both have numbers of that name and of one shape, as an altered archive may not."""
    if name not in first or name not in second:
        return False
    one, other = first[name].variable, second[name].variable
    return one.sizes == other.sizes and one.dims == other.dims and {one.dtype.kind, other.dtype.kind} <= set("iufb")


def _settled(first: "xr.Dataset", second: "xr.Dataset", variable: "xr.Variable") -> Any:
    """Where both runs are known to be regular, in the shape of a variable as far as its dimensions go."""
    import numpy as np

    if second.attrs.get("kind") in _ORBITS:
        return True
    name = "attractor_outcome" if "attractor_number" in variable.dims else "outcome"
    if not _in_both(name, first, second):
        return False
    outcome = second[name].variable
    regular = ~np.isin(outcome.values, _UNDECIDED) & ~np.isin(first[name].values, _UNDECIDED)
    if not set(outcome.dims) <= set(variable.dims):
        return bool(regular.all())
    return np.asarray(outcome.copy(data=regular).set_dims(dict(variable.sizes)).transpose(*variable.dims).values)


def _spread(name: str, first: "xr.Dataset", second: "xr.Dataset", variable: "xr.Variable") -> "np.ndarray":
    """Standard error of the difference of two estimates, in the shape of the estimates."""
    import numpy as np

    bars = second[name].variable
    total = np.hypot(np.nan_to_num(first[name].values), np.nan_to_num(bars.values))
    wide = bars.copy(data=total).set_dims(dict(variable.sizes)).transpose(*variable.dims)
    if "block" not in variable.dims:
        return np.asarray(wide.values)
    # the mean over a part of the blocks is that much less certain
    count = variable.sizes["block"]
    shape = [-1 if dim == "block" else 1 for dim in variable.dims]
    return np.asarray(wide.values * np.sqrt(count / np.arange(1, count + 1)).reshape(shape))


def _parting(dim: str, first: "xr.Dataset", second: "xr.Dataset", bound: float) -> "tuple[Any, Any]":
    """From which row of a record on two runs have parted, and where they do so with a jump, which no divergence is."""
    import numpy as np

    name = LEADERS[dim]
    if not _in_both(name, first, second):
        return None, None
    leader = second[name].variable
    a, b = first[name].values, leader.values
    with np.errstate(invalid="ignore"):
        apart = np.where((a == b) | (np.isnan(a) & np.isnan(b)), 0.0, np.abs(a - b))
    distance = np.where(np.isnan(apart), np.inf, apart).max(axis=-1, initial=0.0)
    size = np.maximum(1.0, np.nan_to_num(np.abs(b)).max(axis=-1, initial=0.0))
    axis = leader.dims.index(dim)
    distance, size = np.moveaxis(distance, axis, 0), np.moveaxis(size, axis, 0)
    parted = np.logical_or.accumulate(distance > bound * size, axis=0)
    before = np.concatenate([distance[:1], distance[:-1]])
    jump = parted & (distance > bound * size) & (distance > _GROWTH * np.maximum(before, _LEAST))
    jump &= ~np.concatenate([parted[:1], parted[:-1]])
    rows = leader.isel({leader.dims[-1]: 0})
    return rows.copy(data=np.moveaxis(parted, 0, axis)), rows.copy(data=np.moveaxis(jump, 0, axis))


def _recorded(
    name: str, first: "xr.Dataset", second: "xr.Dataset", wrong: "np.ndarray", loose: "np.ndarray", bound: float
) -> tuple[str, "np.ndarray"]:
    """Records of runs that may be chaotic: they agree until they part gradually, and then in range."""
    import numpy as np

    variable = second[name].variable
    dim = next(dim for dim in variable.dims if dim in LEADERS)
    parted, jump = _parting(dim, first, second, bound)
    if parted is None:
        return f"within {bound:.0e}", wrong
    parted, jump = (mask.set_dims(dict(variable.sizes)).transpose(*variable.dims).values for mask in (parted, jump))
    excused = loose & parted
    if variable.dtype.kind == "f" and variable.size:
        a, b, axis = first[name].values, variable.values, variable.dims.index(dim)
        low, high = (pick(b, axis=axis, keepdims=True) for pick in (np.min, np.max))
        with np.errstate(invalid="ignore"):
            margin = _MARGIN * (high - low) + bound
            excused = excused & (a >= low - margin) & (a <= high + margin)
    if name == LEADERS[dim]:
        excused = excused & ~jump
    return "until the runs part, then by their range", wrong & ~excused
