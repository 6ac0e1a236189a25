"""Places on motions from which runs go on: what was taken there last is known, and not guessed from the state."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.engine import lap as at
from chaosdrill.engine.run import Run
from chaosdrill.engine.setup import values_of_pins

if TYPE_CHECKING:
    from chaosdrill.engine.numerics import Numerics
    from chaosdrill.model import HybridSystem
    from chaosdrill.orbits.family import Family
    from chaosdrill.orbits.orbit import Orbit


@dataclass(frozen=True)
class Place:
    """Where a motion is.

    Attributes
    ----------
    system : HybridSystem
        With the state and the mode there as its initial ones.
    phase : float
        Time in the forcing period.
    came : Run, optional
        A run that has come there, from which the standing of the guards is taken over. Without one the motion begins.
    """

    system: "HybridSystem"
    phase: float = 0.0
    came: Run | None = None

    def run(self, period: float, numerics: "Numerics", **options: object) -> Run:
        """A run that goes on from there; the arguments are those of `Run`."""
        run = Run(self.system, period, numerics, **options)  # type: ignore[arg-type]
        if self.came is not None:
            state = run.x.copy()
            run.continue_from(self.came)
            run.x[:] = state
        if self.system.period is not None:
            run.begin_at(origin=self.phase)
        return run


def started(system: "HybridSystem", state: np.ndarray, mode: str) -> "HybridSystem":
    """The system with another initial state."""
    return system.with_initial(**dict(zip(system.state_names, state.tolist(), strict=True)), mode=mode)


def reached(run: Run, numerics: "Numerics") -> Place:
    """Where a run has come to, at a strobe; the run may go on."""
    system = started(run.system, run.x, run.mode)
    here = Run(system, run.period, numerics)
    here.continue_from(run)
    return Place(system, 0.0, here)


def standpoint(family: "Family", orbit: "Orbit") -> tuple[int, float, np.ndarray]:
    """Middle of the longest arc: its number, the time since the start of the orbit, the state.

    There no event is near, so that a run that begins there meets all of them.
    """
    longest = int(orbit.durations.argmax())
    step = (family.unit or 1.0) / (family.numerics.steps or 200)
    clock = orbit.phase if family.forced else 0.0
    middle = float(orbit.durations[:longest].sum() + orbit.durations[longest] / 2)
    # fixed steps fall where those of the orbit fell
    on_grid = round((clock + middle) / step) * step - clock
    if abs(on_grid - middle) < orbit.durations[longest] / 2:
        middle = on_grid
    return longest, middle, family.at([orbit], np.array([[middle]]))[0][0, 0]


def place_on(family: "Family", orbit: "Orbit", arc: int, time: float, state: np.ndarray) -> Place:
    """A place within an arc of an orbit.

    How the guards stand there is seen by a run from the event at which the arc began. States that the mode leaves no
    freedom are what the mode makes of them: on which side of a guard they lie is not left to their last digit.

    Parameters
    ----------
    family : Family
    orbit : Orbit
    arc, time, state : int, float, ndarray
        Number of the arc, time since the start of the orbit, state of shape (d,).
    """
    values = dict(zip(family.free, orbit.starts[0, family.states :].tolist(), strict=True))
    system = family.plain.with_parameters(**values)
    mode = system.mode_names[orbit.arcs[arc, at.ARC_MODE]]
    forcing = system.forcing_period()
    before = float(orbit.durations[:arc].sum())
    phase, began = orbit.phase + time, orbit.phase + before
    if forcing:
        phase, began = phase % forcing, began % forcing
    state, start = (
        _pinned(system, int(orbit.arcs[arc, at.ARC_MODE]), there, when)
        for there, when in ((state, phase), (orbit.starts[arc, : family.states], began))
    )
    came = None
    taken = int(orbit.arcs[arc - 1, at.ARC_OUTCOME])
    if taken >= 0 and time > before:
        run = Place(started(system, start, mode), began).run(time - before, family.numerics)
        run.fix_step(step_of(family, forcing))
        run.just_took(taken)
        came = run if run.advance(1)[0] == Outcome.OK and run.mode == mode else None
    return Place(started(system, state, mode), phase, came)


def _pinned(system: "HybridSystem", mode: int, state: np.ndarray, time: float) -> np.ndarray:
    """A state with what a mode pins put where the mode holds it."""
    held = state.copy()
    for i, value in values_of_pins(system, {}, mode, time).items():
        held[i] = value
    return held


def step_of(family: "Family", forcing: float | None) -> float:
    """Step of methods of fixed step, the same wherever a run of a system begins."""
    return (forcing or family.unit or 1.0) / (family.numerics.steps or 200)


def run_from(
    family: "Family", orbit: "Orbit", arc: int, time: float, state: np.ndarray, parts: int = 1, **options: object
) -> Run:
    """A run of the ordinary engine that begins on an orbit.

    Parameters
    ----------
    family : Family
    orbit : Orbit
    arc, time, state : int, float, ndarray
        Where, as for `place_on`.
    parts : int
        A period of the run is one of the forcing, or all of an orbit without forcing; if parts are asked for, that
        part of the whole orbit.
    options
        Passed on to `Run`.
    """
    place = place_on(family, orbit, arc, time, state)
    forcing = place.system.forcing_period()
    period = float(orbit.durations.sum()) / parts if parts > 1 or not forcing else forcing
    run = place.run(period, family.numerics, **options)
    run.fix_step(step_of(family, forcing))
    return run
