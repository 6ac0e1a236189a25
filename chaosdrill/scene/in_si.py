"""Results in SI units for a scene in SI units, and the table from its quantities to the dimensionless parameters."""

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from chaosdrill.annotations import Dataset
from chaosdrill.dataset import SCHEMA, describe
from chaosdrill.dataset.label import axes_of
from chaosdrill.systems.drill.si import MADE, QUANTITIES, STATE_UNITS, UNITS, ReadSI, metres_per_hour

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

SUFFIX = "_si"


def in_si(result: Dataset, kind: str, system: "HybridSystem", scales: Mapping[str, float]) -> Dataset:
    """Add the variables in SI units that the table of variables declares to a result of the drill.

    These are ``progression_rate_si`` in m/h beside ``progression_rate``, times in s, the penetration in m, and the
    force of spring and damper along a trajectory in N; and what one unit of each state is in SI units. ``scales``:
    sizes of the dimensionless units; empty for a scene that is not in SI units, whose result stays as it is.
    """
    if not scales:
        return result
    factors = {
        "m h-1": metres_per_hour(scales),
        "s": scales["time_s"],
        "m": scales["length_m"],
        "m s-1": scales["length_m"] / scales["time_s"],
        "N": scales["force_N"],
    }
    dimensionless = dict(result.variables)
    if kind == "trajectory":
        # y + 2 xi (u - w), in static frictions; a rock that is fixed has no speed
        state = {name: result["states"].sel(state=name).variable for name in system.state_names}
        speed = state["u"] - state["w"] if "w" in state else state["u"]
        dimensionless["force"] = state["y"] + 2 * system.parameters["xi"] * speed
    added: dict[str, Any] = {}
    for name, declared in SCHEMA[kind].items():
        given = dimensionless.get(name.removesuffix(SUFFIX))
        if name.endswith(SUFFIX) and given is not None:
            added[name] = (given.dims, given.values * factors[declared.units])
    if "state" in result.coords:
        units = [STATE_UNITS[str(name)] for name in result["state"].values]
        added["state_scale_si"] = ("state", [factors[unit] for unit in units])
        added["state_units_si"] = ("state", units)
    if not added:
        return result
    settings = json.loads(result.attrs["settings"])
    return describe(result.assign(added), kind, system=system, sweep=axes_of(settings))


def si_table(si: ReadSI, system: "HybridSystem") -> dict[str, Any]:
    """Variables of an archive's root: the given SI quantities, the dimensionless units, and the parameters that follow.

    ``si``: empty for a scene that is not in SI units. ``system``: the drill.

    Returns: name -> scalar with its attributes: ``si_m1`` and so on as given, ``si_unit_of_time``,
    ``si_unit_of_length`` and ``si_unit_of_force``, and ``dimensionless_eps`` and so on.
    """
    table = {}
    for name, value in si.values.items():
        entry = QUANTITIES[name]
        makes = " and ".join(parameter for parameter in entry.makes if parameter in si.parameters)
        comment = f"Makes the parameter {makes}." if makes else "Makes the units of time, length and force."
        table[f"si_{name}"] = _scalar(value, entry.label, entry.units, comment)
    for name, value in si.scales.items():
        units, what, formula = UNITS[name]
        table[f"si_unit_of_{what}"] = _scalar(value, f"one dimensionless unit of {what}", units, f"Is {formula}.")
    for name, value in si.parameters.items():
        table[f"dimensionless_{name}"] = _scalar(value, system.labels.get(name, name), "1", f"Is {MADE[name].formula}.")
    return table


def _scalar(value: float, long_name: str, units: str, comment: str) -> tuple[tuple[()], float, dict[str, str]]:
    attributes = {"long_name": long_name, "units": units, "comment": comment}
    return (), value, {**attributes, "coverage_content_type": "auxiliaryInformation"}
