"""Exponents, 0-1 test and dimension of a series that was measured, or of one variable of a result."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any
from warnings import catch_warnings

from chaosdrill.analysis.tuning import RECURRENCES
from chaosdrill.errors import SettingsError
from chaosdrill.names import shown
from chaosdrill.settings import positive, whole

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr


def series_measures(
    values: "Sequence[float] | np.ndarray | xr.DataArray",
    *,
    embedding: int = 4,
    lag: int = 1,
    window: int = 10,
    step: float | None = None,
    followed: int = RECURRENCES.followed,
) -> "xr.Dataset":
    """Lyapunov exponents, growth K of the 0-1 test and correlation dimension of one series of values.

    Of vectors of ``embedding`` values ``lag`` apart the largest exponent is the rate at which neighbours part
    (Rosenstein et al. 1993, doi:10.1016/0167-2789(93)90009-P), over steps at which their mean logarithmic distance
    grows evenly, found as `dimensions` finds scaling regions. The package nolds (``pip install 'chaosdrill[series]'``)
    gives one exponent for each value of a vector, by linear maps fitted to neighbours (Eckmann et al. 1986,
    doi:10.1103/PhysRevA.34.4971). Where vectors have more values than the motion has dimensions, some of these are
    spurious and may be the largest: twice a true one, for example. The 0-1 test is that of `zero_one_test`, and the
    dimension of the vectors that of `dimensions`. Where equations are known, `lyapunov_spectrum` is better.

    Parameters
    ----------
    values : array_like or DataArray, shape (N,)
        At equal steps of time: 500 at least, at most 10,000; or one variable of a result, as in
        ``section["section"].sel(state="x")``. For the 0-1 test they must not follow each other too closely: of a flow
        take every value at a strobe, or after about a quarter of a turn.
    embedding : int, default 4
        Values of a vector, from 2 to 20; more than the dimension of the motion.
    lag : int, default 1
        Steps between them.
    window : int, default 10
        Steps up to which two vectors are no neighbours.
    step : float, optional
        Time of a step. Default: that of the times that a DataArray brings along, or else 1.
    followed : int, default 20
        Steps over which neighbours are followed at most, from 4 on; it ends where they are no longer near.

    Returns
    -------
    xarray.Dataset
        ``largest_exponent`` and ``largest_error``, NaN where neighbours coincide, or are near each other over less than
        4 steps; ``lyapunov_exponent`` and ``lyapunov_error`` (exponent), descending, NaN where no neighbours are of
        use, or none in a half of the values; all per unit of time. ``k`` and ``k_error``; ``dimension`` and
        ``dimension_error``, NaN without a scaling region. The attribute ``reason`` tells why any of these is NaN. The
        error of the largest exponent joins chance and how unevenly neighbours part, those of the others chance and what
        half of the values, and twice as many neighbours, change. Noise is in none. Their coverage is given in
        docs/howto/dimensions.md.

    Raises
    ------
    SettingsError
        An argument that cannot be used, or nolds is not installed.
    """
    from importlib.metadata import version

    import numpy as np
    import xarray as xr

    from chaosdrill.analysis.measures.evidence import growth

    embedding, lag = whole("embedding", embedding, 2, 20), whole("lag", lag, 1)
    window, followed = whole("window", window, 0), whole("followed", followed, RECURRENCES.shortest)
    series = _series(values)
    time = _step(values) if step is None else positive("step", step)
    count = len(series)
    reach = (embedding - 1) * lag
    needed = 2 * (reach + followed + 10 * window)
    if count < needed:
        raise SettingsError(
            f"values holds {count} numbers; vectors of {embedding}, {lag} apart, followed over {followed} steps and "
            f"compared beyond a window of {window}, need {needed}"
        )
    scaled = (series - series.mean()) / series.std()
    exponents, errors = fitted(scaled, embedding, lag, window)
    vectors = np.lib.stride_tricks.sliding_window_view(scaled, reach + 1)[:, ::lag]
    largest, largest_error, alone = parting(vectors, window, followed)
    dimension, dimension_error, refused = correlation(vectors, scaled, window)
    k, k_error, _ = growth(series)
    unmeasured = "no neighbours are of use, or none in a half of the values" if np.isnan(exponents).any() else ""
    reasons = {"largest_exponent": alone, "lyapunov_exponent": unmeasured, "dimension": refused}
    told = "; ".join(f"{name}: {reason}" for name, reason in reasons.items() if reason)
    attributes = {"reason": told} if told else {}
    return xr.Dataset(
        {
            "largest_exponent": ((), largest / time, {"long_name": "largest Lyapunov exponent, by Rosenstein"}),
            "largest_error": ((), largest_error / time, {"long_name": "standard error of it"}),
            "lyapunov_exponent": ("exponent", exponents / time, {"long_name": "Lyapunov exponent, by Eckmann"}),
            "lyapunov_error": ("exponent", errors / time, {"long_name": "standard error of the exponent"}),
            "k": ((), k, {"long_name": "growth K of the 0-1 test"}),
            "k_error": ((), k_error, {"long_name": "standard error of K"}),
            "dimension": ((), dimension, {"long_name": "correlation dimension"}),
            "dimension_error": ((), dimension_error, {"long_name": "standard error of it"}),
        },
        coords={"exponent": np.arange(1, embedding + 1, dtype=np.int32)},
        attrs={"step": time, "source": f"nolds {version('nolds')}", **attributes},
    )


def fitted(scaled: "np.ndarray", embedding: int, lag: int, window: int) -> "tuple[np.ndarray, np.ndarray]":
    """Exponents per step of linear maps fitted to neighbours, descending, and their errors; NaN where none could be."""
    import numpy as np

    from chaosdrill.analysis.judgement.statistics import in_blocks, standard_error

    nolds, few = package(), min(2 * embedding, embedding + 4)

    def fit(part: np.ndarray, neighbours: int) -> list[np.ndarray]:
        size = {"emb_dim": (embedding - 1) * lag + 1, "matrix_dim": embedding}
        found = nolds.lyap_e(part, **size, min_tsep=window, min_nb=neighbours, debug_data=True)
        # nolds has infinities where no neighbours are of use
        return [np.where(np.isfinite(one), one, np.nan) for one in found]

    exponents, each = fit(scaled, few)
    of_halves = np.mean([fit(half, few)[0] for half in np.array_split(scaled, 2)], axis=0)
    # of N values they are off by N^-0.45 at the slowest that was met, for the second one of the Henon map from 375 to
    # 3000 values: by 2.8 times what half as many change
    off = np.array([3 * (of_halves - exponents), fit(scaled, 2 * few)[0] - exponents])
    errors = np.sqrt(standard_error(in_blocks(each, RECURRENCES.blocks)) ** 2 + (off**2).sum(axis=0))
    exponents = np.where(np.isnan(errors), np.nan, exponents)
    order = np.argsort(-exponents, kind="stable")
    return exponents[order], errors[order]


def correlation(vectors: "np.ndarray", scaled: "np.ndarray", window: int) -> tuple[float, float, str]:
    """Correlation dimension of vectors of scaled values, its error, and why both are NaN, if they are."""
    import numpy as np

    from chaosdrill.analysis.measures.neighbours import SCALES
    from chaosdrill.analysis.measures.scaling import refusal, scaling_region, sums_of

    (sums,) = sums_of(np.ascontiguousarray(vectors), window, np.array([2]))
    different = np.unique(scaled)
    if len(different) < len(scaled):
        # below the step to which values are rounded all distances are 0
        sums = sums._replace(sound=sums.sound & (RECURRENCES.coarse * np.diff(different).min() < SCALES))
    region = scaling_region(sums)
    return (region.dimension, region.error, "") if region else (np.nan, np.nan, refusal(sums))


def parting(vectors: "np.ndarray", window: int, followed: int) -> tuple[float, float, str]:
    """Rate at which a vector and its nearest neighbour part, per step, its error, and why both are NaN, if they are."""
    import numpy as np
    from scipy.spatial import cKDTree

    from chaosdrill.analysis.judgement.statistics import in_blocks
    from chaosdrill.analysis.measures.scaling import STEP, Sums, even_region

    at, stride = np.arange(len(vectors) - followed), -(-followed // RECURRENCES.looked_at)
    apart, place = cKDTree(vectors[at]).query(vectors[at], k=min(2 * window + 2, len(at)))
    apart[(np.abs(place - at[:, np.newaxis]) <= window) | (apart == 0)] = np.inf
    nearest = place[at, apart.argmin(axis=1)]
    with np.errstate(divide="ignore"):
        pairs = (vectors[one[:, np.newaxis] + np.arange(0, followed + 1, stride)] for one in (at, nearest))
        logs = np.log(np.linalg.norm(np.subtract(*pairs), axis=2))
        far = np.log(np.linalg.norm(vectors[len(at) // 2 : len(at)] - vectors[: -(-len(at) // 2)], axis=1))
    logs = logs[np.isfinite(logs).all(axis=1) & np.isfinite(apart.min(axis=1))]
    if not len(logs):
        return np.nan, np.nan, "neighbours coincide, or there are none"
    mean = logs.mean(axis=0)
    near = np.logical_and.accumulate(mean < far[np.isfinite(far)].mean() - RECURRENCES.near)
    if 0 < (end := stride * int(near.sum())) < followed and stride > 1:
        return parting(vectors, window, end)
    none = np.zeros((3, len(mean)))
    sums = Sums(mean, in_blocks(logs - mean, RECURRENCES.blocks), none[0], near, none[1:])
    region = even_region(sums, RECURRENCES.shortest)
    if region is None:
        steps = max(int(near.sum()) - 1, 0)
        lacking = f"{steps} steps, and a rate needs {RECURRENCES.shortest}: take more values, or shorter steps"
        return np.nan, np.nan, f"neighbours are near each other over {lacking}"
    return region.dimension * STEP / stride, region.error * STEP / stride, ""


def package() -> Any:
    """Import nolds; raises `SettingsError` if it is not there."""
    # 0.6.3 raises a TypeError where Python is older than 3.12
    try:
        with catch_warnings(action="ignore"):
            # 0.6.2 finds its files in a way that setuptools warns of
            import nolds
    except (ImportError, TypeError) as fault:
        raise SettingsError(
            f"series_measures takes exponents from nolds, which is not installed, or not for this Python ({fault}); "
            "install it with: pip install 'chaosdrill[series]'"
        ) from fault
    return nolds


def _series(values: Any) -> "np.ndarray":
    """The values alone."""
    import numpy as np

    try:
        if np.ma.is_masked(values) or np.asarray(values).dtype.kind not in "biuf":
            raise TypeError
        series = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise SettingsError(f"values is {shown(values):.60}; it must be a series of numbers") from None
    if series.ndim != 1 or not RECURRENCES.fewest <= len(series) <= RECURRENCES.most:
        raise SettingsError(
            f"values has the shape {series.shape}; it must be one series of {RECURRENCES.fewest} to "
            f'{RECURRENCES.most} numbers, such as one state of a section, section["section"].sel(state="x")'
        )
    if not np.isfinite(series).all() or np.ptp(series) == 0:
        raise SettingsError("values holds a number that is not finite, or one number alone")
    # squares of values of any size are numbers then
    return series / np.abs(series).max()


def _step(values: Any) -> float:
    """The step of the times that values bring along, or 1."""
    import numpy as np
    import xarray as xr

    if not (isinstance(values, xr.DataArray) and "time" in values.coords and values["time"].dims == values.dims):
        return 1.0
    steps = np.diff(values["time"].values)
    mean = float(steps.mean())
    if not (mean > 0 and np.allclose(steps, mean, rtol=1e-6, atol=0)):
        raise SettingsError(
            "values has times at unequal steps; take values at equal ones, or give step, a mean of them"
        )
    return mean
