"""The systems of the hard cases, as their study has them, and tangent maps through the public face."""

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest
import sympy

import chaosdrill as cd


@pytest.fixture(scope="session")
def case():
    """The study's module of a hard case, by its number."""
    folder = Path(__file__).parents[2] / "studies" / "hard_cases"
    sys.path.insert(0, str(folder))
    yield lambda number: importlib.import_module(next(folder.glob(f"case_{number:02d}_*.py")).stem)
    sys.path.remove(str(folder))


@pytest.fixture(scope="session")
def tangent_map():
    """The derivative of the state after ``duration`` by the initial state, and that state."""

    def measure(system, duration, **numerics):
        run = cd.trajectory(system, duration=duration, samples=1, tangents=True, **numerics)
        assert run["outcome"] == cd.Outcome.OK
        return run["states"].values[-1], run["final_tangent"].values.T

    return measure


@pytest.fixture(scope="session")
def tangent_entries():
    """Eigenvalues of M D, with D the derivative of the flow over ``duration`` and M a matrix of one's choice.

    A cycle is made of any motion: after ``duration`` the state x is sent to start + M (x - end), waits for one time
    unit, and the motion begins again. The eigenvalues of M D are then multipliers of a cycle that M makes stable.
    """

    def measure(system, duration, end, matrix):
        states = system.states
        clock = sympy.Symbol("clock", real=True)
        start = [system.initial[s.name] for s in states]
        sent = [
            first + sum(m * (s - last) for m, s, last in zip(row, states, end, strict=True))
            for first, row in zip(start, matrix, strict=True)
        ]
        waiting = {**dict.fromkeys(states, 0), clock: 1}
        back = [
            cd.Transition(
                f"send-{mode}",
                mode,
                "wait",
                guard=clock - duration,
                direction=+1,
                reset=dict(zip(states, sent, strict=True)),
            )
            for mode in system.modes
        ]
        again = cd.Transition(
            "again", "wait", system.initial["mode"], guard=clock - duration - 1, direction=+1, reset={clock: 0}
        )
        cycle = cd.HybridSystem(
            name=f"{system.name} in a cycle",
            states=(*states, clock),
            parameters=system.parameters,
            modes={**{m: {**f, clock: 1} for m, f in system.modes.items()}, "wait": waiting},
            transitions=[*system.transitions, *back, again],
            period=sympy.Float(duration + 1.0),
            initial={"mode": "wait", **dict(zip(states, start, strict=True)), clock: duration + 0.5},
        )
        section = cd.poincare_section(cycle, periods=8, transient=60)
        assert int(section["period"]) == 1
        found = section["multiplier_real"].values + 1j * section["multiplier_imag"].values
        # the clock's own multiplier is 1
        return np.delete(found, np.argmin(np.abs(found - 1)))

    return measure
