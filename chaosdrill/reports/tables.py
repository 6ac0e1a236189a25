"""Tables of results, each from one dataset; empty if the dataset lacks the variables."""

from collections.abc import Mapping
from math import log
from typing import Any

import numpy as np
from markupsafe import Markup

from chaosdrill.annotations import DataArray, Dataset, Variable
from chaosdrill.dataset.elasticities import elasticities
from chaosdrill.dataset.outcomes import ADVICE, count_outcomes, flag_names
from chaosdrill.dataset.references import mapping
from chaosdrill.reports.html import (
    MISSING,
    NOTHING,
    Quantity,
    count,
    joined,
    known_columns,
    number,
    part,
    seconds,
    table,
    uncertain,
)
from chaosdrill.reports.tuning import TUNING

_PERIODIC = ("ok", "periodic")


def single_numbers(dataset: Dataset) -> Markup:
    """All scalar variables, with error and unit."""
    rows = []
    for name, variable in dataset.variables.items():
        is_error = str(name).endswith("_error") and _owner(dataset, name)
        if name == "outcome" or variable.ndim or variable.dtype.kind not in "iuf" or is_error:
            continue
        errors = [dataset[key].values for key in _errors(str(name)) if key in dataset and not dataset[key].ndim]
        if "flag_meanings" in variable.attrs:
            shown: Any = meaning(variable.values, variable)
        else:
            shown = Quantity(uncertain(variable.values, errors[0])) if errors else variable.values
        rows.append((long_name(dataset, name), shown, unit(variable.attrs), str(variable.attrs.get("comment", ""))))
    return table("Numbers", ("quantity", "value", "unit", "note"), rows)


def exponents(dataset: Dataset) -> Markup:
    """Exponents of one run, largest first, with their standard errors."""
    if "lyapunov_exponent" not in dataset or dataset["lyapunov_exponent"].dims != ("exponent",):
        return NOTHING
    pairs = zip(dataset["lyapunov_exponent"].values, dataset["lyapunov_error"].values, strict=True)
    rows = [(i, value, _error(error)) for i, (value, error) in enumerate(pairs, 1)]
    note = part("paragraph", "Per unit of model time. −∞ stands for a direction that is lost at events.", "note")
    return table("Lyapunov exponents", ("number", "exponent", "standard error"), rows) + note


def multipliers(dataset: Dataset) -> Markup:
    """Multipliers of the cycle of one run."""
    if "multiplier_real" not in dataset or dataset["multiplier_real"].ndim != 1:
        return NOTHING
    rows = [(i, one.real, one.imag, abs(one)) for i, one in enumerate(_multipliers(dataset), 1) if one == one]
    return table("Multipliers of the cycle", ("number", "real part", "imaginary part", "modulus"), rows)


def event_counts(dataset: Dataset) -> Markup:
    """Number of times that each transition was taken in a run."""
    if "event_count" in dataset and "transition" in dataset.coords:
        counted = zip(map(str, dataset["transition"].values), dataset["event_count"].values, strict=True)
        return table("Events counted", ("transition", "times"), counted)
    if dataset.attrs.get("kind") != "trajectory":
        return NOTHING
    kinds, speeds = dataset["event_kind"], abs(dataset["event_speed"].values)
    rows = []
    for run, here in _runs(dataset).items():
        for code, name in flag_names(kinds).items():
            hit = kinds.values[here] == code
            if hit.any():
                rows.append((run, name, int(hit.sum()), float(speeds[here][hit].min())))
    head = ("run", "transition", "times", "smallest normal speed")
    return table("Events on the way", *known_columns(head, rows))


def _runs(dataset: Dataset) -> dict[str, slice]:
    """Events of each of joined runs; all events if it is one."""
    if "run" not in dataset.dims:
        return {"": slice(None)}
    ends = dataset["event_count"].values.cumsum()
    starts = ends - dataset["event_count"].values
    return {str(n): slice(a, b) for n, a, b in zip(dataset["run"].values, starts, ends, strict=True)}


def outcomes(dataset: Dataset) -> Markup:
    """Number of runs for each outcome, with advice."""
    if "outcome" not in dataset:
        return NOTHING
    total = dataset["outcome"].size
    counts = count_outcomes(dataset["outcome"].values)
    rows = [(_words(name), n, Quantity(f"{100 * n / total:.3g} %"), ADVICE.get(name, "")) for name, n in counts.items()]
    shown = table("Outcomes", ("outcome", "runs", "share", "what it means, and what to try"), rows)
    told = filter(None, (dataset.attrs.get(key) for key in ("message", "disagreement")))
    return joined([shown, *(part("paragraph", str(text), "fault") for text in told)])


def _precise(value: Any) -> Quantity:
    return Quantity(number(value, TUNING.digits))


def _error(value: Any) -> Quantity:
    return Quantity(number(value, 2))


def meaning(code: Any, variable: DataArray | Variable) -> str:
    """Name of a code, in words."""
    return flag_names(variable).get(int(code), f"code {int(code)}").replace("_", " ")


def long_name(dataset: Dataset, name: Any) -> str:
    """Long name of a variable."""
    return str(dataset[name].attrs.get("long_name", name))


def unit(attributes: Any) -> str:
    """Unit of a variable; empty if dimensionless."""
    from chaosdrill.plots.labels import raised

    found = str(attributes.get("units", ""))
    return "" if found == "1" else raised(found)


def _errors(name: str) -> tuple[str, str]:
    return f"{name}_error", f"{name.rsplit('_', 1)[0]}_error"


def _owner(dataset: Dataset, error: Any) -> bool:
    """Whether the dataset contains the value to which an error belongs."""
    return any(str(error) in _errors(str(name)) for name in dataset.variables if name != error)


def motions(dataset: Dataset) -> Markup:
    """Number of points of each period and of each other kind of motion."""
    if "seed" not in dataset.dims or "period" not in dataset:
        return NOTHING
    names = _kinds(dataset).ravel()
    largest = _largest(dataset)
    rows = []
    for name in dict.fromkeys(sorted(names, key=_rank)):
        here = names == name
        span = (largest.ravel()[here].min(), largest.ravel()[here].max()) if largest is not None else ()
        rows.append((name, int(here.sum()), Quantity(f"{100 * here.mean():.3g} %"), *span))
    ends = ("least largest exponent", "greatest largest exponent") if largest is not None else ()
    return table("Cycles and other motions", ("motion", "points", "share", *ends), rows)


def without_results(dataset: Dataset) -> Markup:
    """Number of points without an exponent."""
    if "seed" not in dataset.dims:
        return NOTHING
    largest = _largest(dataset)
    missing = 0 if largest is None else int(np.isnan(largest).sum())
    if not missing:
        return NOTHING
    return part("paragraph", f"{missing} of {count(largest.size, 'point')} have no exponent.", "note")


def intervals(dataset: Dataset) -> Markup:
    """Intervals of one parameter in which the first seed has the same kind of motion."""
    if dataset.attrs.get("kind") != "bifurcation-diagram":
        return NOTHING
    parameter = str(dataset["outcome"].dims[0])
    # sorting copies all variables that it is given
    told = [name for name in ("outcome", "period", "lyapunov_exponent") if name in dataset]
    ordered = dataset[told].isel(seed=0).sortby(parameter)
    values, names, largest = ordered[parameter].values, _kinds(ordered), _largest(ordered)
    starts = np.flatnonzero(np.r_[True, names[1:] != names[:-1]])
    ends = np.r_[starts[1:], len(names)]
    rows = []
    for start, end in zip(starts, ends, strict=True):
        most = () if largest is None else (largest[start:end].max(),)
        rows.append((values[start], values[end - 1], names[start], int(end - start), *most))
    head = [f"from {parameter}", "to", "motion", "points", *(["greatest exponent"] if largest is not None else [])]
    of = " of the first seed" if dataset.sizes["seed"] > 1 else ""
    return table(f"Motions along {long_name(dataset, parameter)} {parameter}{of}", head, rows, TUNING.intervals)


def attractors(dataset: Dataset) -> Markup:
    """Attractors found from the grid of initial states, or along a parameter."""
    if "end_below" in dataset:
        return _followed(dataset)
    dim = next((name for name in ("attractor_number", "attractor") if name in dataset.dims), None)
    if dim is None:
        return NOTHING
    names = flag_names(dataset["attractor_outcome"])
    told = {
        "part of the starts": ("fraction", "fraction_error"),
        "largest exponent": ("attractor_exponent", "attractor_error"),
        "progression rate": ("attractor_rate", "attractor_rate_error"),
    }
    told = {words: pair for words, pair in told.items() if pair[0] in dataset}
    rows = []
    for i, place in enumerate(dataset[dim].values):
        one = dataset.isel({dim: i, "exponent": 0}, missing_dims="ignore")
        period = int(one["attractor_period"])
        motion = f"period {period}" if period else _words(names.get(int(one["attractor_outcome"]), ""))
        numbers = [Quantity(uncertain(one[n], one.get(error, float("nan")))) for n, error in told.values()]
        rows.append([int(place), motion, *numbers, *one["attractor_state"].values])
    states = (f"{name} at a point of it" for name in dataset["state"].values)
    return table("Attractors", ("attractor", "motion", *told, *states), rows)


def _followed(dataset: Dataset) -> Markup:
    """Attractors along a parameter: their ranges, and what becomes of them at the ends."""
    parameter = str(dataset["outcome"].dims[0])
    ends = {side: flag_names(dataset[f"end_{side}"]) for side in ("below", "above")}
    rows = []
    for i, place in enumerate(dataset["attractor"].values):
        one = dataset.isel(attractor=i)
        most = one["fraction"].isel({parameter: int(np.nanargmax(one["fraction"].values))})
        part_of = Quantity(uncertain(most, one["fraction_error"].sel({parameter: most[parameter]})))
        words = (_words(names.get(int(one[f"end_{side}"]), "")) for side, names in ends.items())
        rows.append((int(place), float(one["first_value"]), float(one["last_value"]), part_of, *words))
    head = ["attractor", f"from {parameter}", "to", "largest part of the starts", "end below", "end above"]
    return table(f"Attractors along {long_name(dataset, parameter)} {parameter}", head, rows, TUNING.intervals)


def _kinds(dataset: Dataset) -> Any:
    """Name of the motion of every point."""
    names = flag_names(dataset["outcome"])
    codes, periods = dataset["outcome"].values, dataset["period"].values
    kinds = np.full(codes.shape, "", dtype=object)
    for code in np.unique(codes):
        name = names.get(int(code), f"code {int(code)}")
        here = codes == code
        if name not in _PERIODIC:
            kinds[here] = _words(name)
            continue
        for period in np.unique(periods[here]):
            kinds[here & (periods == period)] = f"period {period}" if period > 0 else "period not found"
    return kinds


def _largest(dataset: Dataset) -> Any:
    return dataset["lyapunov_exponent"].isel(exponent=0).values if "lyapunov_exponent" in dataset else None


def _rank(name: str) -> tuple[int, str]:
    """Periods in ascending order, then the rest."""
    last = name.rsplit(" ", 1)[-1]
    return (int(last), "") if name.startswith("period ") and last.isdigit() else (2**31, name)


def _words(name: str) -> str:
    return name.replace("_", " ")


def orbits(dataset: Dataset) -> Markup:
    """Every orbit found, with a point, its multipliers and its checks."""
    if dataset.attrs.get("kind") != "periodic-orbit":
        return NOTHING
    many = dataset if "orbit" in dataset.dims else dataset.expand_dims("orbit")
    states = [str(name) for name in dataset["state"].values]
    points, checks = [], []
    for i in range(many.sizes["orbit"]):
        one = many.isel(orbit=i)
        name = str(int(one["orbit"])) if "orbit" in one.coords else "requested"
        length = [int(one["period"]), float(one["period_time"])]
        stable = "stable" if int(one["stable"]) else "unstable"
        state = [_precise(value) for value in one["orbit_state"].values]
        points.append((name, *length, stable, *state, Quantity(_list(_multipliers(one)))))
        differences = [float(one[f"{key}_difference"]) for key in ("exponent", "determinant", "recurrence")]
        agrees = "yes" if int(one["consistent"]) else "no"
        checks.append(
            (name, float(one["residual"]), *differences, agrees, int(one["event_count"]), float(one["smallest_speed"]))
        )
    head = ("orbit", "period", "duration", "stability", *(f"{name} at phase 0" for name in states), "multipliers")
    checked = ("orbit", "residual", "exponents against multipliers", "sum rule", "recurrence", "agrees with itself")
    accuracy = table("Accuracy of the orbits", (*checked, "events", "smallest normal speed"), checks)
    events = _events(dataset) if "orbit" not in dataset.dims else NOTHING
    return joined([table("Orbits", head, points), accuracy, events])


def derivatives(dataset: Dataset) -> Markup:
    """Effect of one percent of each parameter on the period and mean rates of an orbit, in percent."""
    if "period_time_derivative" not in dataset or dataset["period_time_derivative"].dims != ("parameter",):
        return NOTHING
    effects = elasticities(dataset)
    columns = zip(dataset["parameter_value"].values, *effects.values(), strict=True)
    named = zip(map(str, dataset["parameter"].values), columns, strict=True)
    rows = [(parameter, *(Quantity(number(float(value), 5)) for value in values)) for parameter, values in named]
    titles = (f"{long_name(dataset, name)}, %" for name in effects if name != "lyapunov_exponent")
    head = ("parameter", "value", *titles, *["largest exponent"] * ("lyapunov_exponent" in effects))
    note = "By one percent more of each parameter, to first order: changes in percent, and of the exponent as it is. "
    told = str(dataset.attrs.get("derivatives_message", ""))
    return table("What moves the orbit", head, rows) + part("paragraph", note + told, "note")


def branches(dataset: Dataset) -> Markup:
    """Branches of orbits or of equilibria with their starts and ends, their special points, and the cascade."""
    kind = dataset.attrs.get("kind")
    if kind not in ("continuation", "equilibria") or "branch" not in dataset:
        return NOTHING
    rest = kind == "equilibria"
    parameters = [str(name) for name in mapping(dataset.attrs.get("settings")).get("sweep", {})]
    rows = []
    for i, branch in enumerate(dataset["branch_number"].values):
        own = (dataset["branch"].values == branch).nonzero()[0]
        along = (dataset[name].values[own] for name in parameters)
        spans = [
            Quantity(f"{number(values.min())} to {number(values.max())}" if values.size else "–") for values in along
        ]
        counts = [int(own.size), int(dataset["stable"].values[own].sum())]
        if rest:
            what: Any = meaning(dataset["mode"].values[own[0]], dataset["mode"])
            counts.insert(1, int((dataset["admissible"].values[own] == 0).sum()))
        else:
            what = int(dataset["branch_period"].values[i])
        texts = (str(dataset[f"branch_{name}"].values[i]) for name in ("start", "end_text"))
        rows.append((int(branch), what, *spans, *counts, *texts))
    counted = ("points", "admissible", "stable") if rest else ("points", "stable")
    head = ("branch", "mode" if rest else "period", *parameters, *counted, "begins", "ends")
    shown = table("Branches of equilibria" if rest else "Branches", head, rows)
    return joined([shown, _special(dataset, parameters), _note(dataset) if rest else _cascade(dataset)])


def equilibria(dataset: Dataset) -> Markup:
    """Every equilibrium with its mode, type and eigenvalues."""
    if dataset.attrs.get("kind") != "equilibria" or "branch" in dataset:
        return NOTHING
    states = [str(name) for name in dataset["state"].values]
    rows = []
    for i in range(dataset.sizes["point"]):
        one = dataset.isel(point=i)
        words = [meaning(one[name].values, dataset[name]) for name in ("mode", "admissible", "type")]
        values = [_precise(value) for value in one["equilibrium_state"].values]
        free = int(one["free"])
        found = one["eigenvalue_real"].values[:free] + 1j * one["eigenvalue_imag"].values[:free]
        error = max(one["eigenvalue_error"].values[:free], default=float("nan"))
        stable = "stable" if int(one["stable"]) else "unstable"
        rows.append((*words, stable, *values, Quantity(_list(found)), float(error)))
    head = ("mode", "place", "type", "stability", *states, "eigenvalues", "their largest error")
    return joined([table("Equilibria", head, rows), _note(dataset)])


def _note(dataset: Dataset) -> Markup:
    message = str(dataset.attrs.get("message", ""))
    return part("paragraph", message, "note") if message else NOTHING


def _special(dataset: Dataset, parameters: list[str]) -> Markup:
    kinds = dataset["special_kind"]
    owner = dataset["branch"].values
    values = [dataset[name].values for name in ("special_value", "special_value_2")[: len(parameters)]]
    rows = []
    for i, place in enumerate(dataset["special_index"].values):
        at = [_precise(column[i]) for column in values]
        error = _error(dataset["special_error"].values[i])
        kind, words = meaning(kinds.values[i], kinds), str(dataset["special_text"].values[i])
        code = int(dataset["special_onset"].values[i]) if "special_onset" in dataset else 0
        onset = meaning(code, dataset["special_onset"]) if code else MISSING
        rows.append((kind, *at, error, int(owner[place]), _coefficient(dataset, i), onset, words))
    coefficient = "first Lyapunov coefficient" if "special_frequency" in dataset else "cubic coefficient"
    head = ("kind", *parameters, "error", "branch", coefficient, "after grazing", "what happens")
    return table("Special points", *known_columns(head, rows))


def _coefficient(dataset: Dataset, i: int) -> Quantity:
    """The normal form's coefficient at a special point with its error."""
    if "special_coefficient" not in dataset:
        return Quantity(MISSING)
    value, error = (float(dataset[f"special_coefficient{name}"].values[i]) for name in ("", "_error"))
    return Quantity(f"{number(value, 4)} ± {number(error, 2)}" if value == value else MISSING)


def _cascade(dataset: Dataset) -> Markup:
    if "doubling_value" not in dataset:
        return NOTHING
    columns = [dataset[name].values for name in ("doubling_period", "doubling_value", "feigenbaum_ratio")]
    rows = [(int(period), _precise(at), float(ratio)) for period, at, ratio in zip(*columns, strict=True)]
    note = "The ratios tend to Feigenbaum's 4.6692 where one smooth direction doubles."
    shown = table("Period doublings", ("period that doubles", "at", "ratio of distances"), rows)
    return shown + part("paragraph", note, "note") if rows else shown


def _events(orbit: Dataset) -> Markup:
    kinds, names = orbit["event_kind"], flag_names(orbit["event_kind"])
    states = [str(name) for name in orbit["state"].values]
    rows = []
    for i in range(int(orbit["event_count"])):
        after = list(orbit["event_state_after"].values[i])
        name = names.get(int(kinds.values[i]), "")
        rows.append((name, float(orbit["event_time"].values[i]), float(orbit["event_speed"].values[i]), *after))
    head = ("event", "time", "normal speed", *(f"{name} after" for name in states))
    return table("Events of the orbit", head, rows)


def _multipliers(orbit: Any) -> Any:
    return orbit["multiplier_real"].values + 1j * orbit["multiplier_imag"].values


def _list(values: Any) -> str:
    """Complex numbers in a row."""
    pairs = ((value.real, value.imag) for value in values)
    return ", ".join(number(a) + (f"{'+' if b > 0 else '−'}{number(abs(b))}i" if b else "") for a, b in pairs)


def accuracy_section(groups: Mapping[str, Dataset]) -> Markup:
    """One table over all analyses."""
    rows = []
    for name, dataset in groups.items():
        wall, runs = dataset.attrs.get("wall_time_s"), dataset["outcome"].size if "outcome" in dataset else 1
        tolerance = number(dataset.attrs["tolerance"], 3) if "tolerance" in dataset.attrs else MISSING
        row: list[Any] = [name, str(dataset.attrs.get("method", MISSING)), Quantity(tolerance), runs]
        row += [Quantity(MISSING if wall is None else seconds(float(wall) / shared)) for shared in (1, max(runs, 1))]
        errors, speeds = _finite(dataset, "lyapunov_error"), _finite(dataset, "closest_grazing", "smallest_speed")
        row += [_error(errors.max() if errors.size else np.nan)]
        row += [Quantity(number(speeds.min() if speeds.size else np.nan, 3)), Quantity(_horizon(dataset))]
        rows.append(row)
    head = ["analysis", "method", "tolerance", "runs", "wall time", "a run", "largest standard error of an exponent"]
    head += ["smallest normal speed", f"trajectory known to {TUNING.trusted:g} until"]
    note = (
        "The tolerance bounds the error of a step. A chaotic trajectory is known only for the time "
        f"ln({TUNING.trusted:g}/tolerance)/λ₁. Averages have standard errors instead; two of them to either side "
        "contain the true value in 95 % of cases. Tangents, and with them errors, grow without bound as the smallest "
        "normal speed at an event goes to zero."
    )
    return table("Accuracy and cost", head, rows) + part("paragraph", note, "note")


def work_precision(dataset: Dataset) -> Markup:
    """Errors, times and steps of every method at every tolerance, with a recommendation."""
    if dataset.attrs.get("kind") != "work-precision":
        return NOTHING
    quantities = [str(name) for name in dataset["quantity"].values]
    rows = []
    for method in range(dataset.sizes["method"]):
        for place in range(dataset.sizes["tolerance"]):
            cell = dataset.isel(method=method, tolerance=place)
            fixed = int(cell["steps_per_period"])
            asked = f"{fixed} steps" if fixed else number(cell["tolerance"].values, 3)
            errors = [_error(value) for value in cell["error"].values]
            cost = [Quantity(seconds(cell["wall_time"])), float(cell["steps"]), float(cell["evaluations"])]
            ended = meaning(cell["outcome"], cell["outcome"])
            rows.append([str(cell["method"].values), Quantity(asked), *errors, *cost, ended])
    head = ["method", "asked", *(f"error: {_words(name)}" for name in quantities)]
    head += ["time a period", "steps a period", "evaluations a period", "outcome"]
    shown = table("Work and precision", *known_columns(head, rows))
    advice = [line for line in str(dataset.attrs.get("recommendation", "")).splitlines() if line.strip()]
    return part("bullets", advice) + shown if advice else shown


def _finite(dataset: Dataset, *names: str) -> Any:
    """The finite values of the first of some variables that a dataset has."""
    values = next((dataset[name].values for name in names if name in dataset), np.empty(0))
    return values[np.isfinite(values)]


def _horizon(dataset: Dataset) -> str:
    """Time up to which the most chaotic motion of the dataset is predictable."""
    tolerance, known = float(dataset.attrs.get("tolerance", 0.0)), _finite(dataset, "lyapunov_exponent")
    if not 0 < tolerance < TUNING.trusted or not known.size or known.max() <= 0:
        return MISSING
    return f"t = {number(log(TUNING.trusted / tolerance) / float(known.max()), 3)}"
