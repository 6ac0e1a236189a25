"""Records beside borders between words, or of kinds that a rule may take for others; as in `records`.

Here, too, short are records too short for their word by construction. Where cells, tongues or cycles are so many that
their points in the record are few, all are short, and only a wrong word counts.
"""

import numpy as np
from records import (
    GOLDEN,
    exchanges,
    iterate,
    narrow,
    of_line,
    of_plane,
    pinched,
    seen,
    standard,
    start_of_line,
    start_of_plane,
    strange,
    tents,
    tori,
)

TURN = 2 * np.pi
FEW = 256
"""Points of a curve by which it is known."""
GROWN = 8.0
"""Logarithm by which tangents grow or shrink in records that are long enough."""


def growths(P, L, *rates):
    """Growth of tangents by given rates, numbers or arrays of a shape that goes with (P, L)."""
    return np.stack([np.broadcast_to(rate, (P, L)) for rate in rates], axis=-1).astype(float)


def column(values):
    return values[:, np.newaxis]


def circle(angle):
    """An angle in parts of a turn, as a point of the plane."""
    return np.stack([np.cos(TURN * angle), np.sin(TURN * angle)], axis=-1)


def skew_tent(x, a):
    """Image and growth."""
    low = x < a
    return np.where(low, x / a, (1 - x) / (1 - a)), -np.log(np.where(low, a, 1 - a)), low


def blow_outs(rng, P, L):
    """A tent that drives a state across it, near the blow-out of the invariant line: on-off intermittency beyond it."""
    a, swing, rate = rng.uniform(0.2, 0.8, P), rng.uniform(0.3, 1.5, P), 10 ** rng.uniform(-3, -0.5, P)
    rate *= rng.choice([-1, 1], P)

    def step(state):
        _, x, y = state
        x, grown, low = skew_tent(x, a)
        pace = rate + swing * np.where(low, 1 - a, -a)
        across = pace + np.log(np.maximum((1 - y**2) / (1 + y**2) ** 2, 1e-300))
        y = np.exp(pace) * y / (1 + y**2)
        return (np.stack([x, y], axis=-1), x, y), np.stack([grown, across], axis=-1)

    return iterate(step, (None, rng.random(P), 10 ** rng.uniform(-8, -1, P)), L, 50)


def riddled(rng, P, L):
    """A tent on a line that attracts on average, beside which some motions fall to another line."""
    a, swing, rate = rng.uniform(0.2, 0.8, P), rng.uniform(0.5, 1.5, P), 10 ** rng.uniform(-2, -0.5, P)

    def step(state):
        _, x, y = state
        x, grown, low = skew_tent(x, a)
        pace = np.where(y > 1, np.log(0.5), swing * np.where(low, 1 - a, -a) - rate)
        y = np.where(y > 1, 2 + (y - 2) / 2, np.exp(pace) * y)
        return (np.stack([x, y], axis=-1), x, y), np.stack([grown, pace], axis=-1)

    return iterate(step, (None, rng.random(P), 10 ** rng.uniform(-3, -0.3, P)), L, 5)


def driven(rng, P, L):
    """Tents whose slope a rotation changes, and which always stretch."""
    turn = rng.uniform(0.02, 0.98, P)

    def step(state):
        _, x, angle = state
        slope = 1.5 + 0.45 * np.cos(TURN * angle)
        x, angle = slope * np.minimum(x, 1 - x), angle + turn
        return (np.column_stack([x, circle(angle)]), x, angle), np.stack([np.log(slope), 0 * x], axis=-1)

    return iterate(step, (None, rng.uniform(0.1, 0.9, P), rng.random(P)), L, 50)


def skews(rng, P, L):
    """A state that contracts, in the one or the other sense, under a rotation."""
    rate = 1 - 10 ** rng.uniform(-2, -0.1, P)
    factor, turn = rate * rng.choice([-1, 1], P), rng.uniform(0.02, 0.98, P)

    def step(state):
        _, x, angle = state
        x = factor * x + np.cos(TURN * angle) + 0.3 * np.sin(2 * TURN * angle)
        angle = angle + turn
        return (np.column_stack([x, circle(angle)]), x, angle), np.stack([0 * x, np.log(rate)], axis=-1)

    return iterate(step, (None, rng.normal(size=P), rng.random(P)), L, 2000)


def doublings(rng, P, L):
    """Tori of two and four curves: the logistic map on its cycles of these periods, forced weakly by a rotation."""
    r = rng.choice([3.2, 3.3, 3.5], P)
    force = 10 ** rng.uniform(-3, -2, P) * np.where(r > 3.4, 0.3, 1)
    turn = rng.choice([GOLDEN, np.sqrt(2) - 1, np.sqrt(3) - 1], P)

    def step(state):
        _, x, angle = state
        slope = r * (1 + force * np.cos(TURN * angle))
        grown = np.log(np.abs(slope * (1 - 2 * x)))
        x, angle = slope * x * (1 - x), angle + turn
        return (np.column_stack([x, circle(angle)]), x, angle), np.stack([0 * x, grown], axis=-1)

    states, growth = iterate(step, (None, rng.uniform(0.3, 0.7, P), rng.random(P)), L, 3000)
    return states, growth, np.where(r > 3.4, 4, 2) * FEW > L


def tongues(rng, P, L):
    """The circle map in its tongue without turns, at any distance from the edge."""
    k, inside = rng.uniform(0.1, 0.99, P) / TURN, 10 ** rng.uniform(-12, -0.5, P)

    def step(state):
        _, angle = state
        grown = np.log(np.abs(1 - TURN * k * np.cos(TURN * angle)))
        angle = angle + k * (1 - inside) - k * np.sin(TURN * angle)
        return (circle(angle), angle), column(grown)

    rate = TURN * k * np.sqrt(1 - (1 - inside) ** 2)
    return *iterate(step, (None, rng.random(P)), L, 100), rate * L < 8 * GROWN


def wheels(rng, P, L, sign):
    """x -> (1 +- b) x + c mod 1: slopes so near 1 that points follow a rotation for a while."""
    b, c, x = sign * 10 ** rng.uniform(-4, -0.3, P), rng.random(P), rng.random(P)
    grown = column(np.log1p(b))

    def step(state):
        x = ((1 + b) * state[1] + c) % 1
        return (np.stack([x, np.cos(TURN * x)], axis=-1), x), grown

    states, growth = iterate(step, (None, x), L, 200)
    return seen(states), np.concatenate([growth, growth - 0.3], axis=2), np.abs(grown[:, 0]) * L < GROWN


def expanding(rng, P, L):
    """These with slopes above 1, on which all is chaos."""
    return wheels(rng, P, L, 1)


def contracting(rng, P, L):
    """These with slopes below 1, on cycles of any length."""
    return wheels(rng, P, L, -1)


def closing(rng, P, L):
    """Neutral cycles in the order of an angle, of up to so many points that they close just before the end."""
    states, k, short, order = np.empty((P, L, 2)), np.arange(L), np.zeros(P, dtype=bool), np.arange(1, 30)
    for p in range(P):
        period = int(rng.integers(3, int(0.85 * L)))
        turns = rng.choice(np.flatnonzero(np.gcd(np.arange(period), period) == 1))
        weight = rng.normal(size=(2, 29)) / order**2 if rng.random() < 0.5 else np.eye(29)[[0, 0]]
        phase = rng.uniform(0, TURN, (2, 29, 1))
        angle = order[:, np.newaxis] * TURN * (k * turns % period) / period
        states[p] = np.stack([w @ np.cos(angle + a) for w, a in zip(weight, phase, strict=True)]).T
        short[p] = period > L / 4
    return seen(states), growths(P, L, 0, -0.1), short


def overflows(rng, P, L):
    """A digital filter that overflows (Chua and Lin 1988): the plane rotates in pieces, on as many cells as may be."""
    a = 2 * np.cos(rng.uniform(0.2, np.pi - 0.2, P))

    def step(state):
        x, y = state[1:]
        image = (a * y - x + 1) % 2 - 1
        return (np.stack([y, image], axis=-1), y, image), np.zeros((P, 2))

    return *iterate(step, (None, *rng.uniform(-1, 1, (2, P))), L), np.ones(P, dtype=bool)


def delays(rng, P, L):
    """A tent that maps the value of 2 to 11 steps before."""
    lag, a = int(rng.integers(2, 12)), rng.uniform(0.2, 0.8, P)

    def step(state):
        _, last, *line = state
        x, grown, _ = skew_tent(line[0], a)
        return (np.stack([x, last], axis=-1), x, *line[1:], x), np.stack([grown, 0 * grown], axis=-1) / lag

    return iterate(step, (None, rng.random(P), *rng.random((lag, P))), L, 5 * lag)


def late_cycles(rng, P, L):
    """Cycles of the logistic map that maps the value of 2 to 39 steps before."""
    lag, r = int(rng.integers(2, 40)), rng.choice([3.2, 3.5, 3.83], P)

    def step(state):
        _, last, *line = state
        grown = np.log(np.abs(r * (1 - 2 * line[0])))
        x = r * line[0] * (1 - line[0])
        return (np.stack([x, last], axis=-1), x, *line[1:], x), np.stack([grown, grown], axis=-1) / lag

    states, growth = iterate(step, (None, rng.random(P), *rng.uniform(0.3, 0.7, (lag, P))), L, 1000 * lag)
    return states, growth, np.full(P, 16 * lag > L)


def counters(rng, P, L):
    """Whole numbers: sums of a step, and products in a step that has no slope, both after a division's remainder."""
    states, growth, short = np.empty((P, L, 2)), np.zeros((P, L, 2)) - [0, 0.2], np.zeros(P, dtype=bool)
    for p in range(P):
        most = int(rng.integers(2, L // 2)) if rng.random() < 0.5 else int(2 ** rng.integers(4, 30))
        by = int(rng.integers(1, most))
        if most < L // 2:
            path = by * np.arange(L + 1) % most
            short[p] = most // np.gcd(by, most) > L / 4
        else:
            path, growth[p] = np.zeros(L + 1), np.log(1e-300)
            for k in range(L):
                path[k + 1] = (4 * by + 1) * int(path[k]) % most
                path[k + 1] = (path[k + 1] + 1) % most
        states[p] = np.stack([path[1:], path[:-1]], axis=-1)
    return states, growth, short


def sticky(rng, P, L):
    """The sea of the standard map from beside its saddle, beside islands that hold motions up."""
    return standard(rng, P, L, rng.uniform(1.2, 3, P), 10 ** rng.uniform(-6, -2, (P, 2)))


def rounds(rng, P, L, size, most):
    """Closed curves that are visited in turn, of a size beside the way between them."""
    k, states, short = np.arange(L), np.empty((P, L, 2)), np.zeros(P, dtype=bool)
    for p in range(P):
        curves = int(rng.integers(1, most))
        shape = 10 ** rng.uniform(*size) * rng.normal(size=(curves, 2, 2))
        around = circle(rng.uniform(0.02, 0.98) * k / curves)
        states[p] = 3 * rng.normal(size=(curves, 2))[k % curves] + np.einsum("kij,kj->ki", shape[k % curves], around)
        short[p] = curves * FEW > L
    return seen(states), growths(P, L, 0, -0.1), short


def curves(rng, P, L):
    """Curves of up to the size of the way between them."""
    return rounds(rng, P, L, (-3, 0), 33)


def small_curves(rng, P, L):
    """Curves as small as a ten-millionth of it, behind a smooth change of coordinates: hardly more than a cycle."""
    return rounds(rng, P, L, (-7, -3), 17)


def small_chaos(rng, P, L):
    """Chaos as small beside the cycle that it follows."""
    (states, growth), k = tents(rng, P, L), np.arange(L)
    states = states[:, -L:] * 10 ** rng.uniform(-8, -3, (P, 1, 1))
    for p in range(P):
        points = rng.normal(size=(int(rng.integers(1, 17)), 2))
        states[p] += points[k % len(points)]
    return seen(states), growth


def narrow_beside(rng, P, L):
    """Chaos on narrow bands beside a rotation."""
    states, growth, short = narrow(rng, P, L)
    angle = rng.random((P, 1)) + rng.random((P, 1)) * np.arange(L)
    beside = np.stack([states[:, -L:, 0], np.cos(TURN * angle)], axis=-1)
    return beside, np.concatenate([growth, 0 * growth], axis=2), short


def chirps(rng, P, L):
    """An angle whose rate grows evenly, or jumps about as that of (x, y) -> (x + a, y + x): ordered, and no torus."""
    k, known = np.arange(L), rng.random((P, 1)) < 0.5
    pace = np.where(known, 10 ** rng.uniform(-7, -0.3, (P, 1)), 10 ** rng.uniform(-1, 3, (P, 1)) / L**2)
    angle = pace * k * (k - 1) / 2 + rng.random((P, 1)) * k
    beside = np.where(known[..., np.newaxis], circle(pace * k), 1.0)
    shear = np.where(known, np.diff(np.log(np.hypot(1, np.arange(L + 1)))), 0)
    return np.concatenate([circle(angle), beside], axis=2), growths(P, L, shear, -shear)


def accelerators(rng, P, L):
    """The islands of the standard map whose momentum grows by a turn in every step."""
    kick, small = rng.uniform(6.4, 6.6, P), 1e-3 * rng.normal(size=(2, P))

    def step(state):
        _, q, p = state
        p = p + kick * np.sin(q)
        return (np.stack([np.cos(q + p), np.sin(q + p), p], axis=-1), q + p, p), np.zeros((P, 2))

    return iterate(step, (None, np.pi - np.arcsin(TURN / kick) + small[0], small[1]), L)


def walks(rng, P, L):
    """A tent, and an angle or a sum that it pushes."""
    states, growth = tents(rng, P, L)
    x = states[:, -L:, 0]
    walk = np.cumsum(x - 0.5 + rng.choice([0, 1], (P, 1)) * 10 ** rng.uniform(-2, 0, (P, 1)), axis=1)
    walk = np.where(rng.random((P, 1)) < 0.5, walk, np.cos(10 ** rng.uniform(-2, 0.3, (P, 1)) * walk))
    return np.stack([x, walk], axis=-1), np.concatenate([growth, 0 * growth], axis=2)


def rings(rng, P, L):
    """Three competitors, in steps: ever longer stays at one after the other, with the tangents of the map.

    In so many steps of such a size no number becomes too small for a double.
    """
    a, b, e = rng.uniform(0.2, 0.9, P), rng.uniform(0.05, 0.6, P), np.minimum(10 ** rng.uniform(1.2, 2.6, P) / L, 0.5)
    first = np.stack([np.ones(P), 1 + a + b, 1 - a], axis=-1)
    matrix = np.stack([np.roll(first, k, axis=1) for k in range(3)], axis=1)
    frame = np.tile(np.linalg.qr(rng.normal(size=(3, 3)))[0], (P, 1, 1))

    def step(state):
        x, frame = state
        factor = np.exp(column(e) * (1 - np.einsum("pij,pj->pi", matrix, x)))
        slopes = -(column(e) * x * factor)[:, :, np.newaxis] * matrix
        slopes[:, range(3), range(3)] += factor
        frame, lengths = np.linalg.qr(slopes @ frame)
        return (x * factor, frame), np.log(np.maximum(np.abs(np.diagonal(lengths, axis1=1, axis2=2)), 1e-300))

    return iterate(step, (rng.dirichlet(np.ones(3), P), frame), L, 50)


def settling(rng, P, L):
    """A torus that is approached at any rate, straight or about it; too short where a thousandth of the way is left."""
    (states, growth), k = tori(rng, P, L), np.arange(L)[:, np.newaxis]
    rate, off = 10 ** rng.uniform(-4, -0.5, (P, 1, 1)), 10 ** rng.uniform(-8, 0, (P, 1, 1))
    about = rng.choice([0, 1], (P, 1, 1)) * rng.uniform(0.1, 3, (P, 1, 1))
    growth[..., 1] = -rate[..., 0]
    short = (off * np.exp(-rate * L / 2))[:, 0, 0] > 1e-3
    return states + off * np.exp(-rate * k) * np.cos(about * k + np.array([0, 1.0])), growth, short | (L < 2 * FEW)


def noisy(rng, P, L):
    """Cycles with rounding of any size."""
    k, states, rate = np.arange(L), np.empty((P, L, 2)), 10 ** rng.uniform(-2.5, 0, (P, 1))
    for p in range(P):
        points = rng.normal(size=(int(rng.integers(1, 200)), 2))
        states[p] = points[k % len(points)] + 10 ** rng.uniform(-12, -7) * rng.normal(size=(L, 2))
    return seen(states), growths(P, L, -rate, -2 * rate), rate[:, 0] * L < GROWN


def channels(rng, P, L):
    """Beside the narrowest place of a channel that a cycle leaves behind at a fold, far longer than the record."""
    states, growth = np.empty((P, L, 2)), np.zeros((P, L, 2)) - [0, 0.3]
    for p in range(P):
        points, bend, way = rng.normal(size=(int(rng.integers(1, 9)), 2)), 10 ** rng.uniform(0, 1.5), rng.normal(size=2)
        part = len(points) / (8 * L)
        slow, x = (np.pi * part) ** 2 / bend * 10 ** rng.uniform(-1.5, 0), part / bend * 10 ** rng.uniform(-4, 0)
        x *= rng.choice([-1, 1])
        for k in range(L):
            states[p, k] = points[k % len(points)] + x * way
            if k % len(points) == 0:
                growth[p, k, 0] = np.log1p(2 * bend * x)
                x += slow + bend * x**2
    return seen(states), growth, np.ones(P, dtype=bool)


def nodes(rng, P, L):
    """Cycles approached like k exp(-r k), so that motions part first."""
    k, states = np.arange(L)[:, np.newaxis], np.empty((P, L, 2))
    rate, off = 10 ** rng.uniform(-2.5, -0.5, (P, 1)), 10 ** rng.uniform(-8, -2, P)
    for p in range(P):
        points = rng.normal(size=(int(rng.integers(1, 9)), 2))
        way = off[p] * k * rate[p] * np.exp(-rate[p] * k) * rng.normal(size=2)
        states[p] = points[k[:, 0] % len(points)] + way
    grown = np.log1p(1 / (1 + k[:, 0])) - rate
    return seen(states), growths(P, L, grown, -rate), rate[:, 0] * L < 4 * GROWN


def peaks(rng, P, L):
    """Curves with one peak of any width."""
    width, turn = 10 ** rng.uniform(-2.5, 0, (P, 1)), rng.uniform(0.02, 0.98, (P, 1))
    angle = turn * np.arange(L) + rng.random((P, 1))
    stretch = np.log1p(0.4 * np.cos(TURN * angle))
    states = np.stack([1 / (width + np.sin(np.pi * angle) ** 2), np.sin(TURN * angle)], axis=-1)
    return states, growths(P, L, np.diff(stretch, axis=1, append=stretch[:, -1:]), -0.1)


def in_turn(rng, P, L):
    """What is neither torus nor cycle nor chaos, seen in two to four places in turn."""
    places = int(rng.integers(2, 5))
    family = (exchanges, strange, pinched)[int(rng.integers(3))]
    states, growth = family(rng, P, -(-L // places))
    n = states.shape[2]
    each = [states * 10 ** rng.uniform(-2, 0) + rng.normal(size=n) for _ in range(places)]
    seen_in_turn = np.stack(each, axis=2).reshape(P, -1, n)
    return seen_in_turn[:, :L], np.repeat(growth, places, axis=1)[:, :L] / places


def second_steps(rng, P, L):
    """x' = a x (1 - x_) before its Neimark-Sacker bifurcation, and a flip and folds at theirs, as slow as may be."""
    mu = 10 ** rng.uniform(-4, -1.3, P)
    a = 2 - mu

    def image(x):
        u, v = x.T
        matrix = np.array([[a * (1 - v), -a * u], [np.ones(P), np.zeros(P)]]).transpose(2, 0, 1)
        return np.stack([a * u * (1 - v), u], axis=-1), matrix

    near = column(1 - 1 / a) + 10 ** rng.uniform(-6, -1, (P, 1)) * rng.normal(size=(P, 2))
    states, growth = iterate(of_plane(image), start_of_plane(near), L)
    kind, x = rng.integers(0, 3, P), 10 ** rng.uniform(-4, -0.4, P)
    sign, power = np.where(kind == 1, -1, 1), np.where(kind == 2, 2, 3)
    step = of_line(lambda x: (sign * (x - x**power), sign * (1 - power * x ** (power - 1))))
    at, grown = iterate(step, start_of_line(x), L)
    chosen = rng.random(P) < 0.5
    states[chosen], growth[chosen] = 1 + at[chosen], np.repeat(grown[chosen], 2, axis=2)
    return states, growth, chosen | (mu * L < 8 * GROWN)


FAMILIES = {
    "blow-outs": (blow_outs, "chaotic"),
    "riddled": (riddled, "chaotic"),
    "driven": (driven, "chaotic"),
    "skews": (skews, "quasiperiodic"),
    "doublings": (doublings, "quasiperiodic"),
    "tongues": (tongues, "periodic"),
    "expanding": (expanding, "chaotic"),
    "contracting": (contracting, "periodic"),
    "closing": (closing, "periodic"),
    "overflows": (overflows, "quasiperiodic"),
    "delays": (delays, "chaotic"),
    "late cycles": (late_cycles, "periodic"),
    "counters": (counters, "periodic"),
    "sticky": (sticky, "chaotic"),
    "curves": (curves, "quasiperiodic"),
    "small curves": (small_curves, "quasiperiodic"),
    "small chaos": (small_chaos, "chaotic"),
    "narrow beside": (narrow_beside, "chaotic"),
    "chirps": (chirps, ""),
    "accelerators": (accelerators, "open"),
    "walks": (walks, "chaotic"),
    "rings": (rings, ""),
    "settling": (settling, "quasiperiodic"),
    "noisy": (noisy, "periodic"),
    "channels": (channels, ""),
    "nodes": (nodes, "periodic"),
    "peaks": (peaks, "quasiperiodic"),
    "in turn": (in_turn, ""),
    "slow ends": (second_steps, "periodic"),
}
"""As in `records`."""
