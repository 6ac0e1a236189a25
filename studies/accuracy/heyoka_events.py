"""The drill by heyoka.py: one Taylor integrator a mode, its guards as terminal events, saltation around it.

    python studies/accuracy/heyoka_events.py ETA PERIODS TOLERANCE [--lyap] [--numba]

Between two events it is Python, or with ``--numba`` functions compiled by numba. It needs ``heyoka``, which is no
dependency of the package.
"""

import math
import sys

import numba
import numpy as np
from equations import as_it_is, event_function, orthonormalise, write_out
from programs import report

import chaosdrill as cd

# slip begins where w and w' are both zero; so far from its guard no root of it is found at the start
OFF_THE_GUARD = 1e-15


class HeyokaEvents:
    """The drill from rest, strobe by strobe, with Python between the events."""

    name = "heyoka.py, Python between events"
    compiled = False

    def __init__(self, eta: float, tolerance: float, tangents: int) -> None:
        import heyoka

        system = cd.drill(eta=eta)
        jit = numba.njit if self.compiled else as_it_is
        self.tangents, self.period = tangents, 2 * math.pi / eta
        self.mode, self.events = "stick", 0
        self.logs = np.zeros(tangents)
        self.orthonormalise = jit(orthonormalise)
        self.time_limit = heyoka.taylor_outcome.time_limit
        self.integrators, self.views, self.takes, self.targets = {}, {}, {}, {}
        written = write_out(system, tangents)
        for name, mode in written.items():
            known = {s: heyoka.expression(s.name) for s in mode.symbols} | {system.time: heyoka.time}
            directions = {1: heyoka.event_direction.positive, -1: heyoka.event_direction.negative}
            integrator = heyoka.taylor_adaptive(
                [(known[s], heyoka.from_sympy(r, known)) for s, r in zip(mode.symbols, mode.rates, strict=True)],
                [0.0] * len(mode.symbols),
                t_events=[
                    heyoka.t_event(heyoka.from_sympy(e.guard, known), direction=directions[e.direction])
                    for e in mode.events
                ],
                tol=tolerance,
            )
            self.integrators[name], self.views[name] = integrator, integrator.state
            self.takes[name] = [event_function(system, event, mode, jit) for event in mode.events]
        for name, mode in written.items():
            self.targets[name] = [[target for target, _, _ in event.outcomes] for event in mode.events]
        self.states = {name: len(view) // (tangents + 1) for name, view in self.views.items()}
        for v in range(tangents):
            self.views["stick"][self.states["stick"] * (v + 1) + v] = 1.0

    def advance(self, periods: int) -> None:
        """Continue for a number of forcing periods."""
        for _ in range(periods):
            self._one_period()
            self.orthonormalise(self.views[self.mode], self.states[self.mode], self.tangents, self.logs)

    def _one_period(self) -> None:
        while True:
            mode = self.mode
            integrator = self.integrators[mode]
            ended = integrator.propagate_until(self.period)[0]
            if ended == self.time_limit:
                integrator.time = 0.0
                return
            index = -int(ended) - 1
            targets = self.targets[mode][index]
            after = [self.views[target] for target in targets]
            time = integrator.time
            before = self.views[mode].copy() if mode in targets else self.views[mode]
            self.mode = targets[self.takes[mode][index](time, before, *after)]
            if self.mode == "slip" and self.views["slip"][2] == 0.0:
                self.views["slip"][2] = OFF_THE_GUARD
            following = self.integrators[self.mode]
            following.time = time
            following.reset_cooldowns()
            self.events += 1

    def strobe(self) -> list[float]:
        """State at the last strobe: stretch, speed of the bit, speed of the rock."""
        return [float(v) for v in (*self.views[self.mode][: self.states[self.mode]], 0.0)][:3]


class HeyokaNumba(HeyokaEvents):
    """The same with functions compiled by numba between the events."""

    name = "heyoka.py, numba between events"
    compiled = True


if __name__ == "__main__":
    report(HeyokaNumba if "--numba" in sys.argv else HeyokaEvents)
