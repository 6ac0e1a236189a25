"""The drill by scipy: ``solve_ivp`` with DOP853 and terminal events, Python at every event, saltation around it.

python studies/accuracy/scipy_events.py ETA PERIODS TOLERANCE [--lyap]
"""

import math

import numpy as np
import sympy
from equations import as_it_is, event_function, orthonormalise, write_out
from programs import report
from scipy.integrate import solve_ivp

import chaosdrill as cd


class ScipyEvents:
    """The drill from rest, strobe by strobe; ``tolerance`` is both relative and absolute."""

    name = "scipy DOP853, terminal events"

    def __init__(self, eta: float, tolerance: float, tangents: int) -> None:
        system = cd.drill(eta=eta)
        self.tangents, self.period = tangents, 2 * math.pi / eta
        self.tolerance = tolerance
        self.mode, self.events = "stick", 0
        self.logs = np.zeros(tangents)
        self.rates, self.guards, self.takes, self.targets, self.vectors = {}, {}, {}, {}, {}
        for name, mode in write_out(system, tangents).items():
            arguments = [system.time, mode.symbols]
            self.rates[name] = sympy.lambdify(arguments, mode.rates, modules="math", cse=True)
            self.guards[name] = []
            for event in mode.events:
                guard = sympy.lambdify(arguments, event.guard, modules="math")
                guard.terminal, guard.direction = True, event.direction
                self.guards[name].append(guard)
            self.takes[name] = [event_function(system, event, mode, as_it_is) for event in mode.events]
            self.targets[name] = [[target for target, _, _ in event.outcomes] for event in mode.events]
            self.vectors[name] = np.zeros(len(mode.symbols))
        self._start(tangents)

    def _start(self, tangents: int) -> None:
        states = len(self.vectors["stick"]) // (tangents + 1)
        for v in range(tangents):
            self.vectors["stick"][states * (v + 1) + v] = 1.0

    def advance(self, periods: int) -> None:
        """Continue for a number of forcing periods."""
        for _ in range(periods):
            self._one_period()
            vector = self.vectors[self.mode]
            orthonormalise(vector, len(vector) // (self.tangents + 1), self.tangents, self.logs)

    def _one_period(self) -> None:
        time = 0.0
        while True:
            mode = self.mode
            leg = solve_ivp(
                self.rates[mode],
                (time, self.period),
                self.vectors[mode],
                method="DOP853",
                rtol=max(self.tolerance, 2.3e-14),
                atol=self.tolerance,
                events=self.guards[mode],
            )
            time = leg.t[-1]
            self.vectors[mode] = leg.y[:, -1].copy()
            if leg.status != 1:
                return
            index = next(i for i, found in enumerate(leg.t_events) if len(found))
            after = [self.vectors[target].copy() for target in self.targets[mode][index]]
            outcome = self.takes[mode][index](time, self.vectors[mode], *after)
            self.mode = self.targets[mode][index][outcome]
            self.vectors[self.mode] = after[outcome]
            self.events += 1

    def strobe(self) -> list[float]:
        """State at the last strobe: stretch, speed of the bit, speed of the rock."""
        vector = self.vectors[self.mode]
        return [float(v) for v in (*vector[: 2 + (self.mode == "slip")], 0.0)][:3]


if __name__ == "__main__":
    report(ScipyEvents)
