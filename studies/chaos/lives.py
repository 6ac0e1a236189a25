"""How long chaos lasts where the drill runs away: escape rates over the frequency ratio and over the static load.

Runs that start beyond the border of the runaway region leave at once, after as many periods as it takes to gain speed
from there; only older ones tell how long chaos lasts. A rate counts where every run has left, or nearly so: where many
stay, something attracts them, and the rate is a mixture of it and of what the others leave.
"""

import json

import numpy as np
import xarray as xr
from findings import Claim, ended
from fixed_step import parameters, run

import chaosdrill as cd

STARTS = {"count": 400, "seed": 1, "y": (-1.0, 0.5), "u": (-1.0, 1.0)}
PERIODS, GAINS_SPEED = 3000, 60
"""Longest time watched, and the age from which lifetimes count: who leaves at once is gone after 30 to 50."""

ETA, B = 0.65, 0.73
"""Where the other parameter is varied."""

AGAIN, AGE = (0.7285, 0.732, 0.7365), 200
"""Static loads at which the starts are run again by the independent program, and for how many periods."""

ENOUGH = 40
"""Escapes from which the analysis gives a rate."""

LINES = {"eta": np.linspace(0.55, 0.75, 81), "b": np.linspace(0.72, 0.745, 51)}


def along(name: str) -> xr.Dataset:
    """Return the escape rate a period, its error, and what part of the old runs has left, over one parameter."""
    rows = []
    for value in LINES[name]:
        drill = cd.drill(**({"eta": ETA, "b": B} | {name: float(value)}))
        found = cd.transient_chaos(drill, periods=PERIODS, transient=GAINS_SPEED, random=STARTS, saddle="sprinkler")
        period = float(found["forcing_period"])
        lives = found["lifetime"].values / period
        gone = ended(found, "escaped")
        old = lives > GAINS_SPEED
        rows.append(
            {
                "rate": float(found["escape_rate"]) * period,
                "error": float(found["escape_rate_error"]) * period,
                "drift": float(found["drift"]),
                "old": int(old.sum()),
                "left": int((old & gone).sum()),
                "largest_exponent": float(found["lyapunov_exponent"][0]),
                "exponent_error": float(found["lyapunov_error"][0]),
            }
        )
    return xr.Dataset({key: (name, [row[key] for row in rows]) for key in rows[0]}, {name: LINES[name]})


def decays(line: xr.Dataset) -> np.ndarray:
    """Return where chaos is a transient with a rate: enough escapes, no run stays, and lives are exponential."""
    return ((line["left"] >= ENOUGH) & (line["left"] == line["old"]) & (abs(line["drift"]) < 3)).values


def stays(line: xr.Dataset) -> np.ndarray:
    """Return where no run that has lived long leaves any more."""
    return ((line["left"] == 0) & (line["old"] >= ENOUGH)).values


def claims(over_eta: xr.Dataset, over_b: xr.Dataset) -> list[Claim]:
    """Return what the page says of the two lines."""
    b, lasting, decaying = over_b["b"].values, stays(over_b), decays(over_b)
    begins = b[lasting].max()
    shortest, longest = 1 / over_b["rate"].values[decaying].max(), 1 / over_b["rate"].values[decaying].min()
    chaotic = lasting & (over_b["largest_exponent"] > 3 * over_b["exponent_error"]).values
    eta = over_eta["eta"].values
    found = eta[decays(over_eta)]
    apart = [abs(ours - theirs) / max(np.hypot(*spread), 1e-12) for ours, theirs, *spread in map(survivors, AGAIN)]
    return [
        Claim(
            f"as many starts work after {AGE} periods as by the independent program, at three loads",
            f"apart by at most {max(apart):.1f} standard errors",
            max(apart) < 3,
        ),
        Claim(
            f"at η = {ETA} chaos lasts up to a static load of about 0.7268 and is a transient beyond",
            f"no old run leaves up to b = {begins:.4f}; chaos up to {b[chaotic].max():.4f}",
            bool(abs(begins - 0.7268) < 6e-4 and not (decaying & (b < begins)).any()),
        ),
        Claim(
            "mean lives beyond are tens to hundreds of periods",
            f"{shortest:.0f} to {longest:.0f} periods at {decaying.sum()} loads",
            bool(shortest > 5 and longest < 1000 and longest > 100),
        ),
        Claim(
            f"at b = {B} chaos is such a transient at some η between 0.60 and 0.68, and at none outside",
            f"{found.size} of {eta.size} values, {found.min():.4f} to {found.max():.4f}",
            bool(found.size >= 5 and found.min() > 0.6 and found.max() < 0.68),
        ),
    ]


def survivors(b: float) -> tuple[float, float, float, float]:
    """Return the part of the starts that stays, here and by the independent program, and both standard errors."""
    found = cd.transient_chaos(cd.drill(eta=ETA, b=b), periods=AGE, random=STARTS, saddle="sprinkler")
    law = parameters(**json.loads(found.attrs["parameters"]))
    begun = ~ended(found, "invalid_start")
    starts = found["initial_state"].values[begun]
    ours = float(np.mean(~ended(found, "escaped")[begun]))
    theirs = float(np.mean([not np.isnan(run(law, start, AGE, 1, 1e-7)[0]) for start in starts]))
    return ours, theirs, *(float(np.sqrt(part * (1 - part) / len(starts))) for part in (ours, theirs))
