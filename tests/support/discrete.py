"""Discrete maps, and the same as hybrid systems with a clock that is written by hand."""

from typing import Any

import sympy

import chaosdrill as cd

X, Y = sympy.symbols("x y", real=True)
A, B = sympy.symbols("a b", real=True)

HENON: dict[str, Any] = {
    "states": (X, Y),
    "parameters": {"a": 1.4, "b": 0.3},
    "images": {X: 1 - A * X**2 + Y, Y: B * X},
    "initial": {"x": 0.1, "y": 0.05},
}
LOGISTIC: dict[str, Any] = {
    "states": (X,),
    "parameters": {"a": 3.9},
    "images": {X: A * X * (1 - X)},
    "initial": {"x": 0.3},
}


def timed(states: Any, parameters: Any, images: Any, initial: Any) -> cd.HybridSystem:
    """A map as a system that is forced once a period, a third of it after the strobe."""
    t = sympy.Symbol("t", real=True)
    return cd.HybridSystem(
        name="timed",
        states=states,
        time=t,
        parameters=parameters,
        modes={"wait": dict.fromkeys(states, 0)},
        transitions=[
            cd.Transition(
                "step", "wait", "wait", guard=-1 / 2 - sympy.cos(2 * sympy.pi * t), direction=+1, reset=images
            )
        ],
        period=1,
        initial=initial,
    )


def clocked(name: str, states: Any, parameters: Any, images: Any, initial: Any) -> cd.HybridSystem:
    """A map as a system whose last state is a clock: it strikes once a period, half a period off the strobe."""
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


def mapped(images, parameters, initial):
    """A map of a table of images."""
    return cd.Map(tuple(images), parameters, images, name="map", initial=dict(zip(images, initial, strict=True)))
