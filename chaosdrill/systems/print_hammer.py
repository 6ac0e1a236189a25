"""Hammer of a Braille or line printer: held on a backstop by a magnet, thrown at the paper by pulses of current.

    x'' = k x - preload + pulse                                  in flight, 0 < x < gap
    x'' = k x - preload + pulse - stiffness (x - gap) - damping x'   in the paper
    pulse = amplitude sin(omega t) where that is positive, else 0;   at the backstop: x' := -e x'
    x' = 0 on the backstop, until the pulse exceeds the preload

The magnet pulls the harder the closer the hammer is, which is a negative stiffness. Source: Tung and Shaw 1988,
Journal of Vibration, Acoustics, Stress, and Reliability in Design 110, 193-200.
"""

from chaosdrill.declared import Event, event
from chaosdrill.limits import NOT_NEGATIVE, POSITIVE, RESTITUTION

NAME = "print-hammer"
SUMMARY = "hammer of a Braille printer between backstop and paper"
GROUP = "machines"
STATES = {"x": "distance from the backstop", "v": "velocity of the hammer"}
PARAMETERS = {
    "k": (0.5, "negative stiffness of the magnet over the mass"),
    "preload": (0.8, "pull at the backstop over the mass"),
    "amplitude": (5.0, "height of a pulse over the mass"),
    "omega": (2.0, "frequency of the pulses"),
    "gap": (1.0, "distance of the paper"),
    "stiffness": (100.0, "stiffness of the paper over the mass"),
    "damping": (2.0, "damping of the paper over the mass"),
    "e": (0.5, "coefficient of restitution at the backstop"),
}
LIMITS = {"omega": POSITIVE, "gap": POSITIVE, "stiffness": NOT_NEGATIVE, "damping": NOT_NEGATIVE, "e": RESTITUTION}
BODIES = {"hammer": "x", "paper": "gap", "backstop": "0"}


def _places(current: str) -> list[Event]:
    """How the hammer comes from place to place, with current or without."""
    flight, paper, held = (f"{place}-{current}" for place in ("flight", "paper", "held"))
    return [
        event(f"print-{current}", flight, paper, guard="x - gap", direction=+1, kind="print"),
        event(f"leave-{current}", paper, flight, guard="x - gap", direction=-1, kind="leave"),
        event(f"impact-{current}", flight, flight, "x", -1, reset={"v": "-e*v"}, kind="impact"),
        event(f"hold-{current}", flight, held, "x", -1, reset={"x": "0", "v": "0"}, completes=f"impact-{current}"),
    ]


pull, pulse, paper = "k*x - preload", "amplitude*sin(omega*t)", "(stiffness*(x - gap) + damping*v)"
EQUATIONS = {
    "time": "t",
    "modes": {
        "flight-pulse": {"x": "v", "v": f"{pull} + {pulse}"},
        "flight-rest": {"x": "v", "v": pull},
        "paper-pulse": {"x": "v", "v": f"{pull} + {pulse} - {paper}"},
        "paper-rest": {"x": "v", "v": f"{pull} - {paper}"},
        "held-pulse": {"x": "0", "v": "0"},
        "held-rest": {"x": "0", "v": "0"},
    },
    "transitions": [
        *(
            event(f"{name}-{place}", f"{place}-{before}", f"{place}-{after}", "sin(omega*t)", sign, kind=name)
            for name, before, after, sign in (("begin", "rest", "pulse", +1), ("end", "pulse", "rest", -1))
            for place in ("flight", "paper", "held")
        ),
        *_places("pulse"),
        *_places("rest"),
        event("release", "held-pulse", "flight-pulse", guard=f"{pulse} - preload", direction=+1),
    ],
    "period": "2*pi/omega",
    "initial": {"mode": "flight-pulse", "x": 0.2, "v": 0.0},
}
"""The print hammer with default parameters; chaotic."""
