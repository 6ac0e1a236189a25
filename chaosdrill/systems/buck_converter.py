"""Buck converter under voltage control: the switch closes where a ramp exceeds the amplified error.

    L i' = V_in - v or -v,  C v' = i - v/R,  ramp' = (upper - lower)/T
    closed while gain (v - reference) < ramp;   at ramp = upper: ramp := lower

Times in ms, L in mH, C in mF. The cycle of one ramp doubles at V_in = 24.5166 V, that of two at 31.1179 V, and chaos
begins at 32.34 V. Source: Fossas and Olivar 1996, doi:10.1109/81.481457.
"""

from chaosdrill.declared import event
from chaosdrill.limits import POSITIVE

NAME = "buck-converter"
SUMMARY = "buck converter under voltage control"
GROUP = "converters"
STATES = {"v": "output voltage", "i": "current of the inductor", "ramp": "voltage of the ramp"}
PARAMETERS = {
    "V_in": (24.0, "input voltage"),
    "R": (22.0, "load"),
    "L": (20.0, "inductance"),
    "C": (0.047, "capacitance"),
    "gain": (8.4, "gain of the error amplifier"),
    "reference": (11.3, "reference voltage"),
    "lower": (3.8, "lowest voltage of the ramp"),
    "upper": (8.2, "highest voltage of the ramp"),
    "T": (0.4, "period of the ramp"),
}
LIMITS = {"R": POSITIVE, "L": POSITIVE, "C": POSITIVE, "T": POSITIVE}
control = "gain*(v - reference)"
common = {"v": "(i - v/R)/C", "ramp": "(upper - lower)/T"}
clock = {"guard": "ramp - upper", "direction": +1, "reset": {"ramp": "lower"}, "kind": "clock"}
EQUATIONS = {
    "modes": {"closed": {**common, "i": "(V_in - v)/L"}, "open": {**common, "i": "-v/L"}},
    "transitions": [
        event("open", "closed", "open", guard=f"{control} - ramp", direction=+1, kind="switch"),
        event("close", "open", "closed", guard=f"{control} - ramp", direction=-1, kind="switch"),
        *(
            event(f"clock-{before}-{after}", before, after, condition=condition, **clock)
            for before in ("closed", "open")
            for after, condition in (("open", f"{control} > lower"), ("closed", None))
        ),
    ],
    "initial": {"mode": "open", "v": 12.0, "i": 0.5, "ramp": PARAMETERS["lower"][0]},
}
"""The buck converter with default parameters: a cycle of one ramp."""
