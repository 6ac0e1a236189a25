"""Records whose nature is known by construction: states and growth of tangents, many at a time.

Every family is a function of a random generator, a number of records P and their length L. It returns states, of shape
(P, F + L, n), F of which were passed before the record, and the logarithms by which tangents grow in every step of the
record, of shape (P, L, m). A third item, bool of shape (P,), marks records that are too short for their word by
construction: a departure that is not over by half of the record, a laminar phase that is longer than the record.
"""

import numpy as np

GOLDEN = (np.sqrt(5) - 1) / 2
FEIGENBAUM = 3.5699456718709
WINDOW = 1 + np.sqrt(8)
OVER = 0.9
"""Part of its way to the attractor after which a departure is over."""


def seen(states):
    """The same behind a smooth change of coordinates that is none of theirs."""
    first, second = states[..., 0], states[..., -1]
    return np.stack([first + 0.3 * np.tanh(second) + 0.1 * first**2, second - 0.2 * np.sin(first)], axis=-1)


def iterate(step, state, length, forgotten=0):
    """States and growth of a map that gives the next state and the growth in the step."""
    states, growth = [], []
    for _ in range(forgotten + length):
        state, grown = step(state)
        states.append(state[0])
        growth.append(grown)
    return np.stack(states, axis=1), np.stack(growth[forgotten:], axis=1)


def of_line(slope_and_image):
    """A step of a map of one dimension, seen with the value before."""

    def step(state):
        x = state[1]
        image, slope = slope_and_image(x)
        return (np.stack([image, x], axis=-1), image), np.log(np.maximum(np.abs(slope), 1e-300))[:, np.newaxis]

    return step


def of_plane(image_and_jacobian):
    """A step of a map of the plane with its tangents, the first of which finds its direction."""

    def step(state):
        _, x, v = state
        image, jacobian = image_and_jacobian(x)
        v = np.einsum("pij,pj->pi", jacobian, v)
        size = np.linalg.norm(v, axis=1)
        area = np.log(np.maximum(np.abs(np.linalg.det(jacobian)), 1e-300))
        return (image, image, v / size[:, np.newaxis]), np.stack([np.log(size), area - np.log(size)], axis=-1)

    return step


def start_of_line(x):
    return np.stack([x, x], axis=-1), x


def start_of_plane(x):
    return x, x, np.tile([0.6, 0.8], (len(x), 1))


def cycles(rng, P, L):
    """Cycles of periods 1 to 300 that are approached at any rate."""
    states, growth = np.empty((P, L, 2)), np.empty((P, L, 2))
    k = np.arange(L)
    for p in range(P):
        period, rate = int(rng.integers(1, 301)), 10 ** rng.uniform(-2.5, 0)
        if rng.random() < 0.6:
            period = int(rng.integers(1, 17))
        points = rng.normal(size=(period, 2))
        off = 10 ** rng.uniform(-12, 0) * np.exp(-rate * k)[:, np.newaxis] * rng.normal(size=2)
        states[p] = points[k % period] + off
        growth[p] = [-rate, -rate * rng.uniform(1, 4)]
    return seen(states), growth


def tori(rng, P, L, frequencies=1):
    """Curves and surfaces that are filled, by any rotation numbers."""
    k, states, growth = np.arange(L), np.empty((P, L, 2)), np.empty((P, L, 2))
    for p in range(P):
        turns = rng.uniform(0.02, 0.98, frequencies)
        if frequencies == 1 and rng.random() < 0.3:
            turns = rng.integers(1, 7) / 7 + 10 ** rng.uniform(-4, -2) * GOLDEN * np.ones(1)
        angle = 2 * np.pi * (np.outer(k, turns) + rng.random(frequencies))
        bent = angle + rng.uniform(0, 0.4) * np.sin(angle)
        states[p] = np.stack([np.cos(bent).sum(1), np.sin(bent + 0.3).sum(1)], axis=1)
        stretch = np.log(1 + 0.4 * np.cos(angle[:, 0]))
        growth[p, :, 0] = np.diff(stretch, append=stretch[-1])
        growth[p, :, 1] = -(10 ** rng.uniform(-2, 0))
    return seen(states), growth


def surfaces(rng, P, L):
    """Tori of two frequencies at the strobe, of three in all."""
    return tori(rng, P, L, 2)


def solids(rng, P, L):
    """Tori of three frequencies at the strobe."""
    return tori(rng, P, L, 3)


def wrinkles(rng, P, L):
    """Curves of up to 100 harmonics that fall like a power, as those of tori that are about to break."""
    k, states, growth = np.arange(L), np.empty((P, L, 2)), np.empty((P, L, 2))
    for p in range(P):
        angle = 2 * np.pi * (rng.uniform(0.02, 0.98) * k + rng.random())
        order = np.arange(1, int(rng.integers(2, 101)))
        weight = rng.normal(size=(2, len(order))) / order ** rng.uniform(1.8, 3)
        phase = rng.uniform(0, 2 * np.pi, (2, len(order), 1))
        states[p] = np.stack(
            [w @ np.cos(order[:, np.newaxis] * angle + a) for w, a in zip(weight, phase, strict=True)]
        ).T
        stretch = np.log(1 + 0.4 * np.cos(angle))
        growth[p, :, 0] = np.diff(stretch, append=stretch[-1])
        growth[p, :, 1] = -(10 ** rng.uniform(-2, 0))
    return seen(states), growth


def jumps(rng, P, L):
    """Curves that are cut, as those of a clock or of an integrate-and-fire cell at the strobe."""
    turn, begin = rng.uniform(0.02, 0.98, (P, 1)), rng.random((P, 1))
    phase = (turn * np.arange(L) + begin) % 1.0
    bent = np.exp(-rng.uniform(0.2, 3, (P, 1)) * phase) + rng.uniform(0, 0.5, (P, 1)) * np.cos(2 * np.pi * phase)
    rate = 10 ** rng.uniform(-2, 0, (P, 1))
    return seen(np.stack([phase, bent], axis=-1)), np.stack([0 * phase, 0 * phase - rate], axis=-1)


def departures(rng, P, L):
    """An unstable point that is left at any rate from any distance, up to the cycle beside it."""
    mu = 10 ** rng.uniform(-3.3, -1, P)
    x = 10 ** rng.uniform(-12, -3, P)
    side = rng.choice([-1.0, 1.0], P)
    step = of_line(lambda x: (side * ((1 + mu) * x - x**3), side * (1 + mu - 3 * x**2)))
    states, growth = iterate(step, start_of_line(x), L)
    return states, growth, np.abs(states[:, L // 2, 0]) < OVER * np.sqrt(mu)


def spirals(rng, P, L):
    """An unstable focus that is left, up to the circle beside it."""
    mu, turn = 10 ** rng.uniform(-3.3, -1.3, P), rng.uniform(0.1, 3, P)
    c, s = np.cos(turn), np.sin(turn)

    def image(x):
        a, b = x.T
        q = (1 + mu) * (1 - a**2 - b**2)
        matrix = np.array([[c, -s], [s, c]]).transpose(2, 0, 1)
        slope = np.stack([-2 * (1 + mu) * a, -2 * (1 + mu) * b], axis=-1)
        turned = np.einsum("pij,pj->pi", matrix, x)
        return q[:, None] * turned, q[:, None, None] * matrix + turned[:, :, None] * slope[:, None, :]

    start = 10 ** rng.uniform(-12, -3, (P, 1)) * rng.normal(size=(P, 2))
    states, growth = iterate(of_plane(image), start_of_plane(start), L)
    return states, growth, np.linalg.norm(states[:, L // 2], axis=1) < OVER * np.sqrt(mu / (1 + mu))


def windings(rng, P, L):
    """Spirals into a fixed point at any slow rate, down to that of a power of time at a bifurcation.

    Too short are records in half of which they do not cover nine tenths of the way.
    """
    k, turn = np.arange(L), rng.uniform(0.05, 3, (P, 1))
    rate, begin = 10 ** rng.uniform(-8, -2, (P, 1)), 10 ** rng.uniform(1, 6, (P, 1))
    power = rng.random((P, 1)) < 0.5
    size = np.where(power, np.sqrt(begin / (begin + k)), np.exp(-rate * k))
    pace = np.where(power, -0.5 / (begin + k), -rate + 0 * k)
    states = np.stack([0.7 + size * np.cos(turn * k), size * np.sin(turn * k)], axis=-1)
    return seen(states), np.stack([pace, np.where(power, 3, 1) * pace], axis=-1), size[:, L // 2] > 1 - OVER


def narrow(rng, P, L):
    """Tents so flat that their chaos is in many narrow bands, and too short where tangents hardly grow."""
    growth = 10 ** rng.uniform(-3.5, -0.5, P)
    step = of_line(lambda x: (1 - np.exp(growth) * np.abs(x), np.exp(growth) + 0 * x))
    return *iterate(step, start_of_line(rng.uniform(0.1, 0.6, P)), L, int(rng.integers(50, 3000))), growth * L < 8


def turned(rng, P, L):
    """A rotation of the circle in any Moebius coordinate, and too short for its slow passages."""
    side = rng.uniform(0.05, 0.97, P)
    slow = 10 ** rng.uniform(-4, 0, P)
    angle = 2 * np.arcsin(side) + slow * (np.pi - 2 * np.arcsin(side))
    turn, z = np.exp(1j * angle), np.exp(2j * np.pi * rng.random(P))
    states, growth = [], []
    for _ in range(L):
        growth.append(np.log((1 - side**2) / np.abs(1 - side * z) ** 2)[:, np.newaxis])
        z = turn * (z - side) / (1 - side * z)
        z = z / np.abs(z)
        states.append(np.stack([z.real, z.imag], axis=-1))
    rotation = np.arccos(np.clip(np.cos(angle / 2) / np.sqrt(1 - side**2), -1, 1)) / np.pi
    return np.stack(states, axis=1), np.stack(growth, axis=1), rotation * L < 16


def laminar(rng, P, L):
    """Intermittency of type I: the logistic map below its window of period three."""
    below = 10 ** rng.uniform(-8, -4, P)
    r = WINDOW - below
    step = of_line(lambda x: (r * x * (1 - x), r * (1 - 2 * x)))
    states, growth = iterate(step, start_of_line(rng.uniform(0.2, 0.8, P)), L, int(rng.integers(100, 3000)))
    return states, growth, passage(below) > L


def passage(below):
    """Iterates that the logistic map needs through the channel, so far below its window of period three.

    Where the third iterate is x + c + a (x - x0)^2 it takes pi / sqrt(a c) steps, of three iterates each.
    """

    def third(x, r):
        for _ in range(3):
            x = r * x * (1 - x)
        return x

    x, h = 0.5, 1e-4
    for _ in range(200_000):
        x = WINDOW * x * (1 - x)
    at = third(x, WINDOW)
    curvature = (third(x + h, WINDOW) - 2 * at + third(x - h, WINDOW)) / (2 * h**2)
    by_r = (third(x, WINDOW + h) - third(x, WINDOW - h)) / (2 * h)
    return 3 * np.pi / np.sqrt(np.abs(curvature * by_r) * below)


def bursts(rng, P, L):
    """Intermittency of type II: an unstable focus, expansion everywhere, and a way back to any distance from it.

    Stays are as long as chance wills, up to some times 1 / (2 e).
    """
    e, c, turn = 10 ** rng.uniform(-4, -1, P), rng.uniform(1, 4, P), rng.uniform(0.1, 3, P)

    def step(state):
        _, radius, angle = state
        slope = np.log(1 + e + 3 * c * radius**2)
        radius, angle = ((1 + e) * radius + c * radius**3) % 1, angle + turn
        seen = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
        return (seen, radius, angle), np.stack([slope, 0 * slope], axis=-1)

    return *iterate(step, (None, rng.random(P), 2 * np.pi * rng.random(P)), L, 50), 1 / (2 * e) > L


def flips(rng, P, L):
    """Intermittency of type III: an unstable flip, expansion everywhere, and a way back to any distance from it."""
    e, c = 10 ** rng.uniform(-4, -1, P), rng.uniform(1, 4, P)
    step = of_line(lambda x: ((1 - (1 + e) * x - c * x**3) % 2 - 1, 1 + e + 3 * c * x**2))
    return *iterate(step, start_of_line(rng.uniform(-1, 1, P)), L, 50), 1 / (2 * e) > L


def neutral(rng, P, L):
    """The map of Liverani, Saussol and Vaienti: long stays at the neutral point 0."""
    a = rng.uniform(0.1, 0.95, P)

    def image(x):
        low = x < 0.5
        return (
            np.where(low, x * (1 + (2 * x) ** a), 2 * x - 1),
            np.where(low, 1 + (1 + a) * (2 * np.abs(x)) ** a, 2.0),
        )

    return iterate(of_line(image), start_of_line(rng.uniform(0.01, 1, P)), L, 50)


def machines(rng, P, L):
    """The adding machine at the end of the cascade of the logistic map."""
    step = of_line(lambda x: (FEIGENBAUM * x * (1 - x), FEIGENBAUM * (1 - 2 * x)))
    return iterate(step, start_of_line(rng.uniform(0.2, 0.8, P)), L, 20_000)


def strange(rng, P, L):
    """Strange nonchaotic attractors of Grebogi, Ott, Pelikan and Yorke."""
    sigma, angle = rng.uniform(1.2, 3, P), 2 * np.pi * rng.random(P)
    x, states, growth = rng.normal(size=P), [], []
    for k in range(L + 500):
        drive = 2 * sigma * np.cos(angle)
        grown = np.log(np.abs(drive) / np.cosh(x) ** 2)
        x, angle = drive * np.tanh(x), angle + 2 * np.pi * GOLDEN
        if k >= 500:
            states.append(np.stack([x, np.cos(angle), np.sin(angle)], axis=-1))
            growth.append(np.stack([0 * x, grown], axis=-1))
    return np.stack(states, axis=1), np.stack(growth, axis=1)


def exchanges(rng, P, L):
    """Exchanges of three to six intervals in reversed order, which mix weakly: neither tori nor cycles nor chaos."""
    states = np.empty((P, L, 2))
    for p in range(P):
        lengths = rng.dirichlet(np.ones(int(rng.integers(3, 7))))
        begins, places = np.cumsum(lengths) - lengths, 1 - np.cumsum(lengths)
        path, x = np.empty(L + 1), rng.random()
        for k in range(L + 1):
            path[k] = x
            one = np.searchsorted(begins, x, side="right") - 1
            x = min(max(x + places[one] - begins[one], 0.0), 1 - 1e-16)
        states[p] = np.stack([path[1:], path[:-1]], axis=-1)
        if rng.random() < 0.5:
            states[p] = np.stack([np.cos(2 * np.pi * path[:-1]), np.sin(2 * np.pi * path[:-1])], axis=-1)
    return seen(states), np.zeros((P, L, 2)) - [0, 0.1]


def pinched(rng, P, L):
    """Strange nonchaotic attractors of Keller's maps (1996): positive but where the drive pinches them."""
    sigma, angle, x = rng.uniform(1.6, 3, P), rng.random(P), rng.uniform(0.5, 2, P)
    states, growth = [], []
    for k in range(L + 500):
        drive = 2 * sigma * np.abs(np.cos(np.pi * angle))
        grown = np.log(np.maximum(drive / np.cosh(x) ** 2, 1e-300))
        x, angle = drive * np.tanh(x), (angle + np.sqrt(2) - 1) % 1
        if k >= 500:
            states.append(np.stack([x, np.cos(2 * np.pi * angle), np.sin(2 * np.pi * angle)], axis=-1))
            growth.append(np.stack([0 * x, grown], axis=-1))
    return np.stack(states, axis=1), np.stack(growth, axis=1)


def odometers(rng, P, L):
    """Adding machines of bases 2 to 5 on Cantor sets, the finest of whose parts are below all digits."""
    states = np.empty((P, L))
    for p in range(P):
        base, scale = int(rng.integers(2, 6)), rng.uniform(0.1, 0.45)
        count = np.arange(L)[:, np.newaxis] + int(rng.integers(0, 10**9))
        digits = count // base ** np.arange(26, dtype=np.int64) % base
        states[p] = digits @ ((1 - scale) / (base - 1) * scale ** np.arange(26))
    return seen(np.stack([states, np.tanh(states)], axis=-1)), np.zeros((P, L, 2)) - [0, 0.1]


def escapes(rng, P, L):
    """Tents with a hole, through which chaos falls to a fixed point after 5 to 90 % of the record, at any rate.

    Too short are records that end before the point is reached to round-off.
    """
    states, growth, short = np.empty((P, L, 2)), np.empty((P, L, 2)), np.zeros(P, dtype=bool)
    for p in range(P):
        rate, path, grown = 10 ** rng.uniform(-1.5, -0.05), np.empty(L + 1), np.empty(L)
        out = 0
        while not 0.05 * L < out < 0.9 * L:
            slope, x, out = 2 + 4 / (L * rng.uniform(0.2, 2)), rng.random(), L
            for k in range(L):
                path[k] = x
                grown[k] = np.log(slope if k < out else rate)
                x = slope * min(x, 1 - x) if k < out else 1.7 + (x - 1.7) * rate
                out = k + 1 if x > 1 and k < out else out
        path[L] = x
        states[p] = np.stack([path[1:], path[:-1]], axis=-1)
        growth[p] = np.stack([grown, grown - 1], axis=-1)
        short[p] = (L - out) * np.log(rate) > np.log(1e-9)
    return seen(states), growth, short


def tents(rng, P, L):
    """Skew tents, whose growth is one of two numbers."""
    a = rng.uniform(0.15, 0.85, P)

    def image(x):
        low = x < a
        return np.where(low, x / a, (1 - x) / (1 - a)), np.where(low, 1 / a, 1 / (1 - a))

    return iterate(of_line(image), start_of_line(rng.random(P)), L, 50)


def parabolas(rng, P, L):
    """The logistic map where the critical point falls on an unstable cycle: no window is near."""
    r = rng.choice([3.6785735104283222, 3.9277370017867516, 4.0 - 1e-12], P)
    step = of_line(lambda x: (r * x * (1 - x), r * (1 - 2 * x)))
    return iterate(step, start_of_line(rng.uniform(0.2, 0.8, P)), L, 100)


def cusps(rng, P, L):
    """x -> 1 - 2 sqrt|x|, the cusp of Lorenz's return map."""

    def image(x):
        root = np.sqrt(np.maximum(np.abs(x), 1e-300))
        return np.clip(1 - 2 * root, -1, 1), 1 / root

    return iterate(of_line(image), start_of_line(rng.uniform(-0.9, 0.9, P)), L, 50)


def sheets(rng, P, L):
    """Henon's and Lozi's maps, where chaos is proved or beyond doubt."""
    lozi = rng.random(P) < 0.5
    a, b = np.where(lozi, rng.uniform(1.65, 1.75, P), 1.4), np.where(lozi, 0.4, 0.3)

    def image(x):
        u, v = x.T
        bent, slope = np.where(lozi, np.abs(u), u**2), np.where(lozi, np.sign(u), 2 * u)
        zero = np.zeros(P)
        matrix = np.array([[-a * slope, zero + 1], [b, zero]]).transpose(2, 0, 1)
        return np.stack([1 - a * bent + v, b * u], axis=-1), matrix

    return iterate(of_plane(image), start_of_plane(0.1 * rng.random((P, 2))), L, 200)


def standard(rng, P, L, kick, where):
    k = kick * np.ones(P)

    def image(x):
        q, p = x.T
        p = p + k * np.sin(q)
        one = np.ones(P)
        matrix = np.array([[one + k * np.cos(q), one], [k * np.cos(q), one]]).transpose(2, 0, 1)
        return np.stack([q + p, p], axis=-1), matrix

    states, growth = iterate(of_plane(image), start_of_plane(where), L, 20)
    return np.stack([np.sin(states[..., 0]), np.cos(states[..., 0]), np.sin(states[..., 1])], axis=-1), growth


def islands(rng, P, L):
    """Around the elliptic point of the standard map."""
    where = np.stack([np.pi + rng.uniform(0.05, 0.8, P), rng.uniform(-0.1, 0.1, P)], axis=-1)
    return standard(rng, P, L, rng.uniform(0.2, 0.6, P), where)


def seas(rng, P, L):
    """The standard map with kicks beyond those of accelerator modes: of 40,000 starts none is regular.

    Between sqrt(16 + 4 pi^2) = 7.45 and 7.8 one of 3,000 is on an island.
    """
    return standard(rng, P, L, rng.uniform(7.9, 8.4, P), rng.uniform(0, 2 * np.pi, (P, 2)))


def drifts(rng, P, L):
    """A state that grows like a power of time, beside one that repeats or is chaotic, of no exponent."""
    k = np.arange(1, L + 1)
    power, begin = rng.uniform(1, 2, (P, 1)), 10 ** rng.uniform(-2, 1, (P, 1))
    grows = begin + (k / 10) ** power * (1 + 1e-3 * rng.normal(size=(P, L)) / k)
    beside = np.cos(rng.uniform(0.3, 3, (P, 1)) * k)
    return np.stack([grows, beside], axis=-1), np.stack([np.zeros((P, L)), np.zeros((P, L)) - 0.1], axis=-1)


def runaway(rng, P, L):
    """Exponential growth for ever."""
    rate = rng.uniform(4, 40, (P, 1)) / L
    k = np.arange(L)
    growth = np.stack([0 * k + rate, 0 * (k + rate) - 1], axis=-1)
    return np.stack([np.exp(rate * k), 2 * np.exp(rate * k)], axis=-1), growth


FAMILIES = {
    "cycles": (cycles, "periodic"),
    "tori": (tori, "quasiperiodic"),
    "surfaces": (surfaces, "quasiperiodic"),
    "solids": (solids, "quasiperiodic"),
    "wrinkles": (wrinkles, "quasiperiodic"),
    "jumps": (jumps, "quasiperiodic"),
    "islands": (islands, "quasiperiodic"),
    "departures": (departures, "periodic"),
    "spirals": (spirals, "quasiperiodic"),
    "windings": (windings, "periodic"),
    "turned": (turned, "quasiperiodic"),
    "narrow": (narrow, "chaotic"),
    "laminar": (laminar, "chaotic"),
    "neutral": (neutral, "chaotic"),
    "bursts": (bursts, "chaotic"),
    "flips": (flips, "chaotic"),
    "machines": (machines, ""),
    "strange": (strange, ""),
    "pinched": (pinched, ""),
    "odometers": (odometers, ""),
    "exchanges": (exchanges, ""),
    "escapes": (escapes, "periodic"),
    "tents": (tents, "chaotic"),
    "parabolas": (parabolas, "chaotic"),
    "cusps": (cusps, "chaotic"),
    "sheets": (sheets, "chaotic"),
    "seas": (seas, "chaotic"),
    "drifts": (drifts, "open"),
    "runaway": (runaway, ""),
}
"""Families, and the one word for each; none where only an open answer is right."""
