"""A million forcing periods of the chaotic drill against a thousand runs of a thousand periods from stored states.

Each short run starts at phase zero from the state that the long one has reached, so that nothing accumulates in it:
no count of periods, no sum. A digit that the long run has lost in its time would be torn apart by chaos within a few
hundred periods, and the states at the end of the piece would differ.
"""

import math
import resource
from dataclasses import dataclass

import numpy as np

import chaosdrill as cd
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run

ETA = 0.448


@dataclass(frozen=True)
class LongRun:
    """What a long run lost against its pieces.

    Attributes
    ----------
    periods : int
        Length of the long run.
    state : float
        Largest distance of the states, over the ends of all pieces.
    phase : float
        Error of the phase of the load at the end, in radians.
    penetration : float
        Relative difference of the total penetration from the exactly rounded sum over the pieces.
    memory : float
        Growth of the process's largest memory over the last nine tenths, in MB.
    """

    periods: int
    state: float
    phase: float
    penetration: float
    memory: float


def compare(pieces: int = 1000, length: int = 1000) -> LongRun:
    """Run ``pieces * length`` periods at once and in pieces."""
    system = cd.drill(eta=ETA)
    period = 2 * math.pi / ETA
    whole = Run(system, period, Numerics())
    apart, drilled, early = 0.0, [], 0
    for number in range(pieces):
        piece = Run(system, period, Numerics())
        piece.continue_from(whole)
        piece.states.run["longest"] = whole.states.run["longest"]
        piece.advance(length)
        drilled.append(float(piece.integrals()[0]))
        whole.advance(length)
        apart = max(apart, float(np.abs(piece.x - whole.x).max()))
        if number == pieces // 10:
            early = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    late = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return LongRun(
        periods=whole.strobes,
        state=apart,
        phase=abs(math.remainder(ETA * float(whole.standing["time"]), 2 * math.pi)),
        penetration=abs(float(whole.integrals()[0]) / math.fsum(drilled) - 1),
        memory=(late - early) / 1024,
    )


def table(found: LongRun) -> str:
    """Return what was lost as Markdown."""
    rows = {
        "state at the ends of the pieces, largest distance": f"{found.state:.1e}",
        "phase of the load at the end, error in radians": f"{found.phase:.1e}",
        "penetration against the exactly rounded sum of the pieces, relative": f"{found.penetration:.1e}",
        "growth of memory over the last nine tenths, MB": f"{found.memory:.1f}",
    }
    lines = [f"| {found.periods} forcing periods, eta {ETA} | lost |", "| --- | --- |"]
    return "\n".join([*lines, *(f"| {name} | {value} |" for name, value in rows.items())]) + "\n"
