"""The contact over time, for figure 2: hits at several approach speeds, and one impact of the period-1 orbit.

The force comes from the contact that is integrated (``compliant``). The impact is seen twice: so integrated, and as the
paper has it (``hunt-crossley-timed``): the contact's duration passes, then the new speeds hold.
"""

import json
import tomllib
from pathlib import Path

import numpy as np
import xarray as xr

import chaosdrill as cd

HERE = Path(__file__).resolve().parent
SPEEDS = (0.1, 0.2, 0.3, 0.4, 0.5)
CONTACTS = ("hunt-crossley-timed", "compliant")
BEFORE, AFTER = 1e-3, 5.5e-3


def simulate(out: Path) -> Path:
    """Write ``contact.nc`` into a folder: a group ``hit_<speed>`` a speed, and one a contact around an impact."""
    parameters = tomllib.loads((HERE / "period1.toml").read_text(encoding="utf-8"))["system"]["parameters"]
    groups = {f"hit_{speed:g}": hit(speed, parameters) for speed in SPEEDS}
    groups |= {contact: impact(contact, parameters) for contact in CONTACTS}
    path = out / "contact.nc"
    cd.save(xr.DataTree.from_dict(groups), path)
    return path


def hit(speed: float, parameters: dict[str, float]) -> xr.Dataset:
    """Return a bit that meets resting rock at ``speed``, without a load that varies, until they are apart again."""
    constant = {key: value for key, value in parameters.items() if key not in ("a", "eta", "phi")}
    start = {"y": parameters["r"], "u": speed, "mode": "slip-contact"}
    return cd.trajectory(
        cd.drill(drive="none", contact="compliant", initial=start, **constant), duration=3e-3, samples=600
    )


def force(hit: xr.Dataset) -> np.ndarray:
    """Return the contact force of a hit over time, in units of the static friction."""
    law = json.loads(hit.attrs["parameters"])
    state = {name: hit["states"].sel(state=name).values for name in ("u", "w", "depth")}
    depth = np.maximum(state["depth"], 0.0)
    return law["k"] * depth ** law["n"] * (1 + law["lam"] * (state["u"] - state["w"]))


def impact(contact: str, parameters: dict[str, float]) -> xr.Dataset:
    """Return the orbit of period 1 near its impact, with time counted from when bit and rock meet."""
    orbit = cd.trajectory(cd.drill(contact=contact, **parameters), periods=1, transient=1000, samples=200_000)
    kinds = str(orbit["event_kind"].attrs["flag_meanings"]).split()
    hits = [i for i, code in enumerate(orbit["event_kind"].values) if kinds[code].startswith(("hit", "touch"))]
    meets = float(orbit["event_time"].values[hits[0]])
    near = {}
    for dimension, name in (("time", "time"), ("event", "event_time")):
        after = orbit[name].values - meets
        near[dimension] = np.flatnonzero((after >= -BEFORE) & (after <= AFTER))
    orbit = orbit.isel(near)
    return orbit.assign_coords(time=orbit["time"] - meets).assign(event_time=orbit["event_time"] - meets)
