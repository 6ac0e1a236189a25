"""Long runs

Time that is summed up and displacements that grow without bound lose digits: after a million periods the phase of the
load is off by 3.5e-4, and the gap between two masses by 1e-10. This package stores time as a number of periods and a
local time, integrates only the gap, and sums up the penetration with compensation.
"""

import math

import numpy as np
from tools import Finding, show

import chaosdrill as cd

LONG, ETA = 1_000_000, 0.8
POINT = (0.5117707419326684, 0.2579689590074009, 0.3668787222623992)
PROGRESSION = 0.1163908540290498


def summed_time(periods: int, parts: int) -> float:
    """Return the error of the phase after this number of periods, if time is summed up in ``parts`` steps a period."""
    step = 2 * math.pi / ETA / parts
    time = float(np.cumsum(np.full(periods * parts, step))[-1])
    return abs(math.remainder(ETA * time, 2 * math.pi))


def findings() -> list[Finding]:
    """A cycle after a million periods: its point, its phase, and what it has drilled."""
    section = cd.poincare_section(cd.drill(eta=ETA), periods=2, transient=LONG)
    point = section["section"].values[-1]
    strobe = float(section["time"].values[-1]) * ETA / (2 * math.pi)
    spectrum = cd.lyapunov_spectrum(cd.drill(eta=ETA), periods=LONG // 10, transient=200)
    far = PROGRESSION * 2 * math.pi / ETA * LONG
    return [
        Finding(
            "error of the phase after 1e6 periods",
            0.0,
            abs(math.remainder(2 * math.pi * (strobe - round(strobe)), 2 * math.pi)),
            1e-8,
            f"{show(summed_time(LONG, 4), 2)} (time summed up, four steps a period)",
        ),
        Finding(
            "error of the strobe point after 1e6 periods",
            0.0,
            float(np.abs(point - POINT).max()),
            1e-12,
            f"at least {show(float(np.spacing(far)), 2)} (difference of two displacements near {show(far, 2)})",
        ),
        Finding("progression rate over 1e5 periods", PROGRESSION, float(spectrum["progression_rate"]), 1e-13),
    ]
