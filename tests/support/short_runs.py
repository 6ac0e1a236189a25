"""Short runs that lead through all of the engine, as numbers; run by itself, this prints them as JSON."""

import json
import sys

import numpy as np

import chaosdrill as cd
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run

TWO = {"transient": 1, "blocks": 2}


def drill(method):
    """Slips, sticks and impacts, with their tangents."""
    found = cd.lyapunov_spectrum(cd.drill(eta=0.8), periods=3, method=method, tolerance=1e-9, **TWO)
    return [*found["lyapunov_exponent"].values[:2], *found["closest_grazing"].values.ravel()]


def vector():
    """The same for points side by side, two of which hold the contact."""
    eta = [0.8, 0.75, 0.7]
    found = cd.bifurcation_diagram(cd.drill(), {"eta": eta}, transient=2, periods=3, max_extension=0, exponents=2)
    return [*found["lyapunov_exponent"].values.ravel(), *found["section"].values[..., -3:, :].ravel()]


def ball(method):
    """Infinitely many impacts are replaced by a contact, which a moving floor ends."""
    found = cd.lyapunov_spectrum(cd.build("bouncing-ball"), periods=3, method=method, tolerance=1e-9, **TWO)
    return [*found["lyapunov_exponent"].values[:1], *found["events_per_period"].values.ravel()]


def orbit():
    """Segments of an orbit, its multipliers and its samples."""
    found = cd.periodic_orbit(cd.drill(eta=0.8), transient=20)
    return [*found["multiplier_real"].values.ravel(), *found["orbit_state"].values.ravel()]


def instants(method):
    """States at given times, one of them that of an event."""
    kicked = cd.HybridSystem(
        states="x v",
        parameters={"push": 0.3},
        modes={"on": {"x": "v", "v": "-x"}},
        transitions=[
            cd.Transition("kick", "on", "on", "sin(2*pi*t)", +1, reset={"v": "v + push"}),
            cd.Transition("mark", "on", "on", "x - 0.4", 0, reset={}),
        ],
        period=1,
        quadratures={"work": "v**2"},
        initial={"mode": "on", "x": 0.1, "v": 0.5},
    )
    found = cd.trajectory(kicked, periods=3, times=[0.3, 1.0, 1.25, 2.7], method=method, tolerance=1e-9)
    return [*found["states"].values.ravel(), *found["work"].values, *found["event_time"].values]


def outcomes(method):
    """Runs that end early."""
    ends = cd.HybridSystem(
        states="x y",
        modes={
            "grow": {"x": "x", "y": "0"},
            "shrink": {"x": "-1/x", "y": "0"},
            "logarithm": {"x": "log(x - 3)", "y": "0"},
            "pole": {"x": "1", "y": "1/(x - 1)"},
            "ping": {"x": "1", "y": "0"},
            "fall": {"x": "y", "y": "-1"},
        },
        transitions=[
            cd.Transition("there", "ping", "ping", "x - 1", +1, reset={"x": "1"}),
            cd.Transition("bounce", "fall", "fall", "x", -1, reset={"y": "-y/2"}),
        ],
        period=5,
        bounds={"x": (-50, 50), "y": (-10, 10)},
    )
    found = []
    for mode, x, y in (("grow", 1, 0), ("shrink", 1, 0), ("logarithm", 1, 0), ("pole", 0, 0), ("ping", 1.5, 0)):
        run = Run(ends.with_initial(mode=mode, x=x, y=y), 5.0, Numerics(method, 1e-9), tangents=np.eye(2))
        found.append(int(run.advance(1)[0]))
    run = Run(ends.with_initial(mode="fall", x=0, y=1), 5.0, Numerics(method, 1e-9, max_events=20), tangents=np.eye(2))
    return [*found, int(run.advance(1)[0])]


def section():
    """A flow without forcing, counted by an event, with an exponent that its structure makes zero."""
    found = cd.lyapunov_spectrum(cd.build("belt-stick-slip"), at="stick", periods=2, **TWO)
    return [*found["lyapunov_exponent"].values[:1], found["slips_per_time"].item()]


def alone(method):
    """Points of a sweep by a method that steps them one by one, and follows the state."""
    eta = [0.8, 0.75]
    given = {"transient": 1, "periods": 2, "max_extension": 0, "exponents": 1, "follow": "forward", "tolerance": 1e-9}
    found = cd.bifurcation_diagram(cd.drill(), {"eta": eta}, method=method, **given)
    return [*found["lyapunov_exponent"].values.ravel(), *found["section"].values.ravel()]


def counted(method):
    """Points of a sweep whose lengths count events."""
    given = {"at": "hit", "transient": 1, "periods": 3, "max_extension": 0, "exponents": 1}
    found = cd.bifurcation_diagram(cd.drill(), {"eta": [0.8]}, method=method, tolerance=1e-9, **given)
    return [*found["lyapunov_exponent"].values.ravel(), *found["section"].values.ravel()]


def steep():
    """A guard whose series ends before that of the states, for one run and side by side."""
    switch = cd.HybridSystem(
        states="x v",
        parameters={"steep": 40.0},
        modes={"on": {"x": "v", "v": "-x"}},
        transitions=[cd.Transition("kick", "on", "on", "tanh(steep*(x - 0.2)) + 0.1*x", +1, reset={"v": "v*0.9"})],
        period="2*pi",
        initial={"mode": "on", "x": 0.0, "v": 1.0},
    )
    one = cd.lyapunov_spectrum(switch, periods=2, **TWO)
    many = cd.bifurcation_diagram(switch, {"steep": [20.0, 40.0]}, transient=1, periods=2, max_extension=0, exponents=1)
    return [*one["lyapunov_exponent"].values, *many["section"].values.ravel()]


def held():
    """A mode that holds a surface of two states, to which rank is lost and tangents keep."""
    sliding = cd.HybridSystem(
        states="x v y",
        modes={
            "on": {"x": "v", "y": "sin(2*t) - y", "v": "-v/0.6 - 0.2*(x + 0.6*v)"},
            "off": {"x": "v", "y": "sin(2*t) - y", "v": "-3"},
        },
        transitions=[
            cd.Transition("kicked", "on", "off", "cos(2*t) + 0.2*x", -1, reset={"v": "v + 4"}),
            cd.Transition("lands", "off", "on", "x + 0.6*v", -1),
        ],
        period="pi",
        initial={"mode": "on", "x": 0.6, "v": -1.0, "y": 0.1},
    )
    found = cd.lyapunov_spectrum(sliding, periods=3, **TWO)
    return [*found["lyapunov_exponent"].values[:2], *found["events_per_period"].values.ravel()]


def touching():
    """A guard with roots of third and of second order, of which only the first are events."""
    mark = cd.Transition("mark", "m", "m", "(x - 0.5)**3*(x - 0.8)**2*(1.2 - x)**3*cos(x)", 0)
    clock = cd.HybridSystem(states="x", modes={"m": {"x": "1"}}, transitions=[mark], initial={"x": 0.0})
    return cd.trajectory(clock, duration=1.5, samples=1)["event_time"].values.tolist()


def unmoved():
    """Guards that stay zero since one of their states does: no term of them leads out, up to the last."""
    marks = [cd.Transition(f"mark{i}", "m", "m", guard, 0) for i, guard in enumerate(("y*x", "y*(1 + x)"))]
    held = cd.HybridSystem(states="x y", modes={"m": {"x": "1", "y": "0"}}, transitions=marks)
    found = cd.trajectory(held, duration=1.0, samples=1, tolerance=1e-9)
    return [float(found.sizes["event"]), *found["states"].values[-1]]


def unproved():
    """A period that no expression shows to be one."""
    system = cd.HybridSystem(
        states="x", parameters={"w": 1.0}, modes={"m": {"x": "cos(w*t) - x"}}, period="2*pi", initial={"x": 1.0}
    )
    return cd.trajectory(system, periods=1, samples=1)["states"].values[-1].tolist()


def facing():
    """Two modes that push onto one surface, which no expression shows to be one."""
    relay = cd.HybridSystem(
        states="x",
        parameters={"k": 2.0},
        modes={"above": {"x": "-1"}, "below": {"x": "1"}},
        transitions=[
            cd.Transition("down", "above", "below", "x", -1),
            cd.Transition("up", "below", "above", "k*x", 1),
        ],
        initial={"mode": "above", "x": 1.0},
    )
    found = cd.trajectory(relay, duration=2.0, samples=1)
    return [float("cd.filippov" in found.attrs["message"]), *found["event_time"].values[:2]]


def rebounds():
    """Through two modes, less and less elastic ones, until a contact replaces those that are left."""
    onto = {"guard": "x", "direction": -1}
    transitions = []
    for here, there, law in (("m", "n", "0.5 + 0.2*v"), ("n", "m", "0.8 + 0.3*v")):
        transitions += [
            cd.Transition(f"hit-{here}", here, there, **onto, reset={"v": f"-({law})*v"}),
            cd.Transition(f"rest-{here}", here, "held", **onto, reset={"x": "0", "v": "0"}, completes=f"hit-{here}"),
        ]
    modes = {"m": {"x": "v", "v": "-1"}, "n": {"x": "v", "v": "-2"}, "held": {"x": "0", "v": "0"}}
    ball = cd.HybridSystem(states="x v", modes=modes, transitions=transitions, initial={"x": 0.5})
    found = cd.trajectory(ball, duration=5.0, samples=1, tolerance=1e-6)
    return [float(found.sizes["event"]), *found["event_time"].values[-2:]]


def gate(method):
    """From zero, where the rate is what rounding leaves of larger terms."""
    system = cd.HybridSystem(
        states="x", modes={"m": {"x": "1.3 - 1.3*cos(t*0) + exp(-((t - 1)/0.1)**2)"}}, initial={"x": 0.0}
    )
    found = cd.trajectory(system, duration=1.5, samples=1, method=method, tolerance=1e-9)
    return found["states"].values[-1].tolist()


def emptied():
    """A tank whose rate ends with its level, which is a guard."""
    empty = cd.Transition("empty", "m", "dry", "h", -1, reset={"h": "0"})
    tank = cd.HybridSystem(
        states="h", modes={"m": {"h": "-sqrt(h)"}, "dry": {"h": "0"}}, transitions=[empty], initial={"h": 1.0}
    )
    return cd.trajectory(tank, duration=3.0, samples=1)["event_time"].values.tolist()


def at_rest():
    """States that are zero, whose sizes the system tells by where its motion changes."""
    moves = cd.Transition("hit", "m", "m", "x", -1, reset={"v": "-0.8*v"})
    system = cd.HybridSystem(
        states="x v y", modes={"m": {"x": "v", "v": "-x - x**3", "y": "-y - y**3"}}, transitions=[moves]
    )
    found = cd.lyapunov_spectrum(system, duration=5.0, transient=1.0)
    return found["lyapunov_exponent"].values.tolist()


def iterates():
    """A map, alone and in a sweep, on the attractor, through an escape, and with its events kept."""
    henon = cd.Map("x y", {"a": 1.4, "b": 0.3}, {"x": "1 - a*x**2 + y", "y": "b*x"}, initial={"x": 0.1})
    alone = cd.lyapunov_spectrum(henon, periods=20, **TWO)
    swept = cd.bifurcation_diagram(henon, {"a": [1.0, 1.4, 3.0]}, transient=5, periods=8, max_extension=0)
    kept = cd.trajectory(henon, periods=5)
    found = [*alone["lyapunov_exponent"].values, *kept["states"].values.ravel(), *swept["outcome"].values.ravel()]
    return [*found, *swept["section"].values[:2, -2:].ravel()]


def eventless(name, parameters, **given):
    """An orbit without events: in segments of a period, or from a plane to itself."""
    found = cd.periodic_orbit(cd.build(name, parameters), **given)
    return [*found["multiplier_real"].values.ravel(), found["period_time"].item()]


def close(method):
    """Roots of order one to three that are close, of a clock and of time alone, for guards of either direction."""
    guards = ["(c - 1)*(c - 1003/1000)*(c - 1007/1000)", "(c - 1)**2*(c - 1004/1000)", "(c - 1)**3", "sin(t - 1)**3"]
    guards += ["(c - 1)**3 - 3*(c - 1)**2/1000 + (c - 1)/400000", "(t - 1)**2*(t - 1.5)"]
    found = []
    for guard in guards:
        kicks = [cd.Transition(name, "m", "m", guard, way, {"n": "n + 1"}) for name, way in (("up", 1), ("down", -1))]
        system = cd.HybridSystem(states="c n", time="t", modes={"m": {"c": "1", "n": "0"}}, transitions=kicks)
        found += cd.trajectory(system, duration=2.0, samples=1, method=method)["event_time"].values.tolist()
    return found


METHODS = ("taylor", "dop853", "rk4", "radau")
RUNS = {
    **{
        f"{run.__name__} {method}": (run, method)
        for run in (drill, ball, gate, instants, outcomes)
        for method in METHODS
    },
    **{
        run.__name__: (run,)
        for run in (vector, orbit, section, steep, held, at_rest, emptied, facing, rebounds, touching, unproved)
    },
    "iterates": (iterates,),
    "unmoved": (unmoved,),
    **{f"counted {method}": (counted, method) for method in ("taylor", "dop853")},
    **{f"close {method}": (close, method) for method in ("taylor", "dop853")},
    "alone dop853": (alone, "dop853"),
    "eventless forced": (lambda: eventless("duffing", {"amplitude": 0.1}, transient=3),),
    "eventless free": (lambda: eventless("roessler", {"c": 2.5}, at="y > 0", transient=3),),
}


def main():
    found = {name: [float(x) for x in run(*given)] for name, (run, *given) in RUNS.items()}
    json.dump(found, sys.stdout)


if __name__ == "__main__":
    main()
