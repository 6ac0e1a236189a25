"""How often two standard errors contain the truth, in records of measures of chaos whose value is known.

    python studies/chaos/covering.py [--records 200] [--only NAME ...]

Each record is short and begins at a random state, or has a random seed. A closed form is the truth; where there is
none, the mean over all records is, which then tells whether the errors are those by chance, and not whether the method
is biased. Writes a table to ``studies/chaos/out/covering.md``; the exit code is 0 if every error covers in 88 % of the
records at least.
"""

import argparse
import math
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

import chaosdrill as cd
from chaosdrill.analysis.grids.boundaries import mixing, uncertainty
from chaosdrill.analysis.measures.scaling import scaling_region, sums_of

OUT = Path(__file__).resolve().parent / "out"
LEAST, MOST = 0.88, 0.995
SHARE, LEFT, RIGHT = 0.3, 0.2, 0.4
"""Of a baker's map: where it is cut, and how much it narrows on either side."""
WIDTHS = np.array([0.45, 0.35])
"""Branches of an open tent map."""
HEAD = ("measure", "record", "truth", "records", "held, %", "error over scatter")

Told = dict[str, tuple[float, float, float]]
"""Name -> value, error, truth (NaN: not known)."""


def baker(left: float = LEFT) -> cd.Map:
    """A skew baker's map, whose exponents and dimensions are known."""
    images = {"x": "piecewise(l*x, y < s, 1/2 + r*x)", "y": "piecewise(y/s, y < s, (y - s)/(1 - s))"}
    return cd.Map("x y", {"s": SHARE, "l": left, "r": RIGHT}, images, initial={"x": 0.2, "y": 0.37})


def exponents(left: float = LEFT) -> tuple[float, float]:
    """Of the baker's map."""
    shares = np.array([SHARE, 1 - SHARE])
    return float(-shares @ np.log(shares)), float(shares @ np.log([left, RIGHT]))


def dimension(order: int, left: float = LEFT) -> float:
    """Of the baker's map (Hentschel and Procaccia 1983, doi:10.1016/0167-2789(83)90235-X)."""
    above, below = exponents(left)
    if order == 1:
        return 1 - above / below

    def partition(d: float) -> float:
        parts = (SHARE, left), (1 - SHARE, RIGHT)
        return sum(share**order * width ** ((1 - order) * d) for share, width in parts) - 1

    return 1 + float(brentq(partition, 0, 3))


def of_spectra(records: int, rng: np.random.Generator) -> Iterator[Told]:
    """Exponents and the Kaplan-Yorke dimension."""
    system, truth = baker(), exponents()
    for _ in range(records):
        begun = system.with_initial(x=rng.random(), y=rng.random())
        found = cd.lyapunov_spectrum(begun, transient=50, periods=512)
        yield {
            **{f"exponent {k + 1}": (*_of(found, "lyapunov_exponent", "lyapunov_error", k), truth[k]) for k in (0, 1)},
            "Kaplan-Yorke dimension": (*_of(found, "kaplan_yorke_dimension", "kaplan_yorke_error"), dimension(1)),
        }


def of_vectors(records: int, rng: np.random.Generator) -> Iterator[Told]:
    """Mean local growth, and the density of angles of Henon's map."""
    system, truth = baker(), exponents()
    henon = cd.Map("x y", {"a": 1.4, "b": 0.3}, {"x": "1 - a*x**2 + y", "y": "b*x"}, initial={"x": 0.1, "y": 0.05})
    for _ in range(records):
        begun = system.with_initial(x=rng.random(), y=rng.random())
        found = cd.covariant_vectors(begun, transient=20, periods=512, forward=60, backward=60)
        told = {
            f"mean local growth {k + 1}": (*_of(found, "lyapunov_exponent", "lyapunov_error", k), truth[k])
            for k in (0, 1)
        }
        begun = henon.with_initial(x=rng.uniform(-0.1, 0.1), y=rng.uniform(-0.05, 0.05))
        found = cd.covariant_vectors(begun, transient=60, periods=2000, forward=60, backward=60, bins=8)
        for bin_ in (0, 1, 3, 5):
            value, error = (float(found[name][0, bin_]) for name in ("angle_histogram", "angle_histogram_error"))
            told[f"density of angles, bin {bin_ + 1} of 8"] = value, error, math.nan
        yield told


def of_dimensions(records: int, rng: np.random.Generator) -> Iterator[Told]:
    """Generalised dimensions of attractors."""
    turn = math.pi * (math.sqrt(5) - 1)
    turned = {"x": "c*x - s*y", "y": "s*x + c*y"}
    circle = cd.Map("x y", {"c": math.cos(turn), "s": math.sin(turn)}, turned)
    henon = cd.Map("x y", {"a": 1.4, "b": 0.3}, {"x": "1 - a*x**2 + y", "y": "b*x"})
    lozi = cd.Map("x y", {"a": 1.7, "b": 0.5}, {"x": "1 - a*Abs(x) + y", "y": "b*x"})
    long = lozi.with_initial(x=0.1, y=0.05)
    lozi_dimension = float(cd.lyapunov_spectrum(long, transient=500, periods=200_000)["kaplan_yorke_dimension"])
    # Henon: order 1 by its exponents, order 2 by Grassberger and Procaccia 1983, doi:10.1103/PhysRevLett.50.346
    sets: dict[str, tuple[cd.Map, float, dict[int, float]]] = {
        "baker's map": (baker(), 1, {q: dimension(q) for q in (1, 2, 3)}),
        "a wider baker's map": (baker(0.25), 1, {q: dimension(q, 0.25) for q in (1, 2, 3)}),
        "Henon's map": (henon, 0.05, {1: 1.258, 2: 1.22}),
        "Lozi's map": (lozi, 0.05, {1: lozi_dimension}),
        "a closed curve": (circle, 1, dict.fromkeys((1, 2, 3), 1.0)),
    }
    for _ in range(records):
        told: Told = {}
        for name, (system, size, truth) in sets.items():
            begun = system.with_initial(x=size * rng.random(), y=size * rng.random())
            found = cd.dimensions(begun, transient=500, periods=2000, orders=list(truth))
            for place, q in enumerate(truth):
                told[f"order {q}, {name}"] = *_of(found, "dimension", "dimension_error", place), truth[q]
        yield told


def of_independent(records: int, rng: np.random.Generator) -> Iterator[Told]:
    """Generalised dimensions of points that are drawn independently."""
    for _ in range(records):
        across = np.zeros(2000)
        for one in rng.random((40, 2000)) < SHARE:
            across = np.where(one, LEFT * across, 0.5 + RIGHT * across)
        sets = {
            "a Cantor set": (across[:, np.newaxis], {q: dimension(q) - 1 for q in (1, 2, 3)}),
            "normal values": (rng.normal(size=(2000, 1)), dict.fromkeys((1, 2, 3), 1.0)),
            "normal pairs": (rng.normal(size=(2000, 2)), dict.fromkeys((1, 2, 3), 2.0)),
            "a square": (rng.random((2000, 2)), dict.fromkeys((1, 2, 3), 2.0)),
            "a square, 10,000 points": (rng.random((10_000, 2)), {1: 2.0}),
        }
        yield {
            f"order {q}, {name}": (*(region[:2] if region else (math.nan, math.nan)), truth[q])
            for name, (points, truth) in sets.items()
            for q, sums in zip(truth, sums_of(points / points.std(axis=0), 0, np.array(list(truth))), strict=True)
            for region in [scaling_region(sums)]
        }


def of_lives(records: int, rng: np.random.Generator) -> Iterator[Told]:
    """Escape rate of an open skew tent, exponent and dimension of its saddle."""
    images = {"x": "piecewise(x/a, x < 1/2, (1 - x)/b)"}
    tent = cd.Map("x", dict(zip("ab", WIDTHS.tolist(), strict=True)), images, initial={"x": 0.3}, bounds={"x": (0, 1)})
    shares = WIDTHS / WIDTHS.sum()
    for _ in range(records):
        starts = {"count": 1500, "seed": int(rng.integers(2**31)), "x": (0, 1)}
        found = cd.transient_chaos(tent, periods=60, random=starts)
        yield {
            "escape rate": (*_of(found, "escape_rate", "escape_rate_error"), -math.log(WIDTHS.sum())),
            "exponent of the saddle": (
                *_of(found, "lyapunov_exponent", "lyapunov_error", 0),
                float(-shares @ np.log(WIDTHS)),
            ),
            "dimension of the saddle": (
                *_of(found, "saddle_dimension", "saddle_dimension_error"),
                float((shares @ np.log(shares)) / (shares @ np.log(WIDTHS))),
            ),
        }


def of_walkers(records: int, rng: np.random.Generator) -> Iterator[Told]:
    """Of a tent that most leave in each iterate, whose saddle is found by stagger-and-step."""
    images = {"x": "piecewise(x/a, x < 1/2, (1 - x)/b)"}
    tent = cd.Map("x", {"a": 0.25, "b": 0.2}, images, initial={"x": 0.3}, bounds={"x": (0, 1)})
    shares = np.array([5, 4]) / 9
    above = float(-shares @ np.log([0.25, 0.2]))
    for _ in range(records):
        starts = {"count": 300, "seed": int(rng.integers(2**31)), "x": (0, 1)}
        found = cd.transient_chaos(tent, periods=12, transient=1, random=starts)
        yield {
            "rate of the saddle": (*_of(found, "saddle_rate", "saddle_rate_error"), -math.log(0.45)),
            "exponent by stagger-and-step": (*_of(found, "lyapunov_exponent", "lyapunov_error", 0), above),
            "dimension by stagger-and-step": (
                *_of(found, "saddle_dimension", "saddle_dimension_error"),
                float(-shares @ np.log(shares)) / above,
            ),
        }


def of_flights(records: int, rng: np.random.Generator) -> Iterator[Told]:
    """Escape rate of a flow whose flights take 1 or 2, and a third of which end: z = exp(rate) solves z + z^2 = 3."""
    legs = (("1", "3*x", "x < 1/3"), ("2", "9", "x >= 1/3 and x < 2/3"), ("2", "3*x - 2", "x >= 2/3"))
    flow = cd.HybridSystem(
        states="x s",
        modes={"wait": {"x": "0", "s": "1"}},
        transitions=[
            cd.Transition(f"flight-{k}", "wait", "wait", f"s - {end}", 1, {"x": image, "s": "0"}, condition=condition)
            for k, (end, image, condition) in enumerate(legs)
        ],
        initial={"x": 0.1, "s": 0.0},
        bounds={"x": (-1, 2)},
    )
    for _ in range(records):
        starts = {"count": 500, "seed": int(rng.integers(2**31)), "x": (0, 1)}
        found = cd.transient_chaos(flow, duration=40.0, random=starts, saddle="sprinkler")
        rate = math.log((math.sqrt(13) - 1) / 2)
        yield {"escape rate of a flow": (*_of(found, "escape_rate", "escape_rate_error"), rate)}


def of_windows(records: int, rng: np.random.Generator) -> Iterator[Told]:
    """Cumulants over windows, the correlation time of independent growth."""
    system, above = baker(), exponents()[0]
    spread = SHARE * (math.log(SHARE) + above) ** 2 + (1 - SHARE) * (math.log(1 - SHARE) + above) ** 2
    third = -(SHARE * (math.log(SHARE) + above) ** 3 + (1 - SHARE) * (math.log(1 - SHARE) + above) ** 3)
    fourth = spread**2 * (1 / (SHARE * (1 - SHARE)) - 6)
    for _ in range(records):
        begun = system.with_initial(x=rng.random(), y=rng.random())
        found = cd.finite_time_exponents(begun, transient=20, periods=1000, windows=[5], exponents=1)
        values, errors = (found[name].values.reshape(-1) for name in ("cumulant", "cumulant_error"))
        truth = (above, spread / 5, third / 25, fourth / 125)
        yield {
            **{f"cumulant {k + 1} over 5": (values[k], errors[k], truth[k]) for k in range(4)},
            "correlation time": (*_of(found, "correlation_time", "correlation_time_error", 0), math.nan),
        }


def of_evidence(records: int, rng: np.random.Generator) -> Iterator[Told]:
    """Averages of a tent, growth of the 0-1 test."""
    system = cd.Map("x", {"a": 0.3}, {"x": "piecewise(x/a, x < a, (1 - x)/(1 - a))"}, initial={"x": 0.2})
    for _ in range(records):
        begun = system.with_initial(x=rng.random())
        found = cd.regularity(begun, transient=20, periods=500)
        growth, longer = (cd.zero_one_test(begun, transient=20, periods=length) for length in (500, 1000))
        yield {
            "weighted average": (*_of(found, "average", "average_error", 0), 0.5),
            "digits of the average": (*_of(found, "digits", "digits_error", 0), math.nan),
            "growth K of the 0-1 test": (*_of(growth, "k", "k_error", 0), math.nan),
            "growth K, 1000 iterates": (*_of(longer, "k", "k_error", 0), math.nan),
        }


def of_noise(records: int, rng: np.random.Generator) -> Iterator[Told]:
    """A ball of random restitution on a floor that adds a speed of 1: exponents given the noise, mean height."""
    ball = cd.HybridSystem(
        states="x v",
        parameters={"e": 0.8},
        modes={"flight": {"x": "v", "v": -1}},
        transitions=[cd.Transition("impact", "flight", "flight", "x", -1, reset={"v": "1 - e*v"})],
        quadratures={"height": "x"},
        initial={"x": 1.0},
    ).with_noise({"e": cd.Uniform(0.7, 0.9)}, at="impact", seed=1)
    ends = np.array([0.7, 0.9])
    one, two, three = (float(np.diff(ends ** (k + 1))[0] / (k + 1) / 0.2) for k in (1, 2, 3))
    speed = 1 / (1 - one)
    square = (1 + 2 * one * speed) / (1 - two)
    cube = (1 + 3 * one * speed + 3 * two * square) / (1 - three)
    logarithm = float(np.diff(ends * np.log(ends) - ends)[0] / 0.2)
    for _ in range(records):
        drawn = ball.with_parameters(noise_seed=int(rng.integers(2**31)))
        found = cd.lyapunov_spectrum(drawn, at="impact", transient=100, periods=512)
        yield {
            "exponent given the noise": (*_of(found, "lyapunov_exponent", "lyapunov_error", 1), logarithm / 2 / speed),
            "mean rate given the noise": (*_of(found, "height_rate", "height_rate_error"), cube / 3 / speed),
        }


def of_shares(records: int, rng: np.random.Generator) -> Iterator[Told]:
    """Shares of random starts in basins, and of a value of a sweep: two attractors, 0.3 of the starts lead to one."""
    system = cd.Map("x", {"c": 0.3}, {"x": "piecewise(x/2 - 1/4, x < c, x/2 + 3/4)"}, initial={"x": 0.2})
    for _ in range(records):
        starts = {"count": 60, "seed": int(rng.integers(2**31)), "x": (0, 1)}
        lengths = {"transient": 30, "periods": 8, "max_period": 2, "exponents": 0}
        drawn = np.random.default_rng(starts["seed"]).random(60)
        found = cd.basin_measures(system, initial={"x": drawn}, **lengths)
        swept = cd.attractors(system, {"c": [0.3, 0.31]}, random=starts, **lengths)
        told: Told = {}
        for name, one in (("share of a basin", found), ("share over a parameter", swept.isel(c=0))):
            here = int(np.argmin(one["attractor_state"].values[:, 0]))
            told[name] = (*_of(one, "fraction", "fraction_error", here), 0.3)
        yield told


def of_boundaries(records: int, rng: np.random.Generator) -> Iterator[Told]:
    """Uncertainty exponent of lines and of rough graphs, entropies of a line, a disc and a graph on moved grids."""
    along = np.linspace(-1, 1, 200)
    for _ in range(records):
        angle, off = rng.uniform(0, 2 * np.pi), rng.uniform(-0.3, 0.3)
        smooth = uncertainty(1 + (np.cos(angle) * along[:, np.newaxis] + np.sin(angle) * along > off))
        told = {"uncertainty exponent of a line": (smooth.exponent, smooth.exponent_error, 1.0)}
        moved = along + rng.uniform(-0.025, 0.025, 2)[:, np.newaxis]
        x, y = moved[0][:, np.newaxis], moved[1]
        graph = _rough(0.5, np.pi * moved[0])[:, np.newaxis]
        basins = {"line": np.cos(0.5) * x + np.sin(0.5) * y > 0.1, "disc": x**2 + y**2 < 0.4, "graph": 4 * y > graph}
        for name, inside in basins.items():
            for of in ("basin", "boundary"):
                told[f"{of} entropy of a {name}"] = *mixing(1 + inside, 5)[f"{of}_entropy"], math.nan
        count, turn = int(rng.integers(300, 600)), rng.uniform(0, 2 * np.pi)
        across = np.linspace(0, 2 * np.pi, count) + turn
        for rough in (0.3, 0.5, 0.7):
            one = uncertainty(1 + (np.linspace(-5, 5, count) > _rough(rough, across)[:, np.newaxis]))
            told[f"uncertainty exponent {rough:g} of a graph"] = one.exponent, one.exponent_error, rough
        yield told


def _rough(exponent: float, across: np.ndarray) -> np.ndarray:
    """Weierstrass' function."""
    return np.asarray(sum(2.0 ** (-exponent * k) * np.cos(2.0**k * across) for k in range(50)))


def of_series(records: int, rng: np.random.Generator) -> Iterator[Told]:
    """Exponent and dimension of a series of a skew tent."""
    exact = -0.3 * math.log(0.3) - 0.7 * math.log(0.7)
    for _ in range(records):
        values = [rng.random()]
        for _ in range(1000):
            x = values[-1]
            values.append(x / 0.3 if x < 0.3 else (1 - x) / 0.7)
        found = cd.series_measures(values, embedding=2)
        yield {
            "largest exponent of a series": (*_of(found, "largest_exponent", "largest_error"), exact),
            "growth K of a series": (*_of(found, "k", "k_error"), math.nan),
            "dimension of a series": (*_of(found, "dimension", "dimension_error"), 1.0),
        }


MEASURES: dict[str, tuple[str, Callable[[int, np.random.Generator], Iterator[Told]]]] = {
    "spectra": ("baker's map, 512 iterates", of_spectra),
    "vectors": ("baker's map, 512 iterates; Hénon map, 2000", of_vectors),
    "dimensions": ("dimension of 2000 iterates", of_dimensions),
    "independent": ("dimension of 2000 points, or as said", of_independent),
    "lives": ("open tent map, 1500 starts", of_lives),
    "walkers": ("open tent map, 300 starts", of_walkers),
    "flights": ("flow of flights, 500 starts", of_flights),
    "windows": ("baker's map, 1000 iterates", of_windows),
    "evidence": ("tent map, 500 iterates, or as said", of_evidence),
    "noise": ("ball, 512 impacts", of_noise),
    "shares": ("two attractors, 60 starts", of_shares),
    "boundaries": ("grids of 200 to 600 cells", of_boundaries),
    "series": ("tent map, 1000 values", of_series),
}


def _of(found: "object", value: str, error: str, index: int | None = None) -> tuple[float, float]:
    values, errors = (np.ravel(found[name].values) for name in (value, error))  # type: ignore[index]
    return float(values[index or 0]), float(errors[index or 0])


def rows(name: str, records: int) -> Iterator[tuple[list[str], bool]]:
    """Rows of the table of a group of measures, and whether each covers."""
    record, measure = MEASURES[name]
    found = list(measure(records, np.random.default_rng(20261127)))
    for quantity in found[0]:
        values, errors, truths = np.array([one[quantity] for one in found]).T
        known = np.isfinite(values) & np.isfinite(errors)
        values, errors, truth = values[known], errors[known], truths[0]
        exact = math.isfinite(truth)
        if not known.any():
            yield [quantity, record, f"{truth:.4g}", "0", "refused", ""], True
            continue
        truth = truth if exact else values.mean()
        held = np.abs(values - truth) <= 2 * errors
        scatter = np.sqrt(np.mean((values - truth) ** 2))
        cells = [quantity, record, f"{truth:.4g}{'' if exact else ', mean'}", str(len(values))]
        yield [*cells, f"{100 * held.mean():.1f}", f"{np.median(errors) / scatter:.2f}"], bool(held.mean() >= LEAST)


def main() -> int:
    """Count, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--records", type=int, default=200)
    parser.add_argument("--only", nargs="+", choices=MEASURES, default=list(MEASURES))
    given = parser.parse_args()
    lines = [HEAD, ("---",) * len(HEAD)]
    good = True
    for name in given.only:
        for cells, covers in rows(name, given.records):
            lines.append(tuple(cells))
            good &= covers
            print(" | ".join(cells), flush=True)
    OUT.mkdir(exist_ok=True)
    (OUT / "covering.md").write_text("".join(f"| {' | '.join(cells)} |\n" for cells in lines), encoding="utf-8")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
