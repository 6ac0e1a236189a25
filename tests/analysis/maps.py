"""Maps that are known in closed form, as hybrid systems."""

import sympy

import chaosdrill as cd


def map_system(name, states, parameters, images, initial):
    """A map as a hybrid system: the states wait until a clock strikes, once a period, half a period off the strobe."""
    clock = sympy.Symbol("clock", real=True)
    return cd.HybridSystem(
        name=name,
        states=(*states, clock),
        parameters=parameters,
        modes={"wait": {**dict.fromkeys(states, 0), clock: 1}},
        transitions=[cd.Transition("step", "wait", "wait", guard=clock - 1, direction=+1, reset={**images, clock: 0})],
        period=sympy.Integer(1),
        initial={**initial, clock: 0.5},
    )
