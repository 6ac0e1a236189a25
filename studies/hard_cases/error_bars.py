"""How often 95 % intervals hold the truth: exponents of chaotic systems, in spectra and in diagrams, and known noise.

    python studies/hard_cases/error_bars.py [--repetitions 1000]

A spectrum is one long run that is cut into REPETITIONS records of 256 blocks each; a diagram has as many starts at one
value of its parameter. The interval is the value plus and minus 1.96 of its standard error. The truth is a closed form,
or else the mean over the whole long run. Writes a table to ``studies/hard_cases/out/error_bars.md``; the exit code is 0
if every row holds the truth in 90 to 98 % of its records, or in more with bars less than 2.5 times the actual error:
blocks of motion that only goes up and down cancel, and few frequencies do not tell how well.
"""

import argparse
import math
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import sympy

import chaosdrill as cd
from chaosdrill.analysis.judgement.statistics import standard_error

OUT = Path(__file__).resolve().parent / "out"
BLOCKS = 256
TRANSIENT = 500
TOLERANCE = 1e-10
INTERVAL = 1.959964
BOUNDS = (0.90, 0.98)
WIDEST = 2.5
HEAD = ["motion", "record", "held", "%", "if blocks were independent, %", "bar over actual error"]


@dataclass(frozen=True)
class Motion:
    """A chaotic motion whose exponent is measured.

    Attributes
    ----------
    name : str
    system : HybridSystem
        With a period, of any length where there is no forcing.
    box : dict
        Ranges from which a diagram's starts are drawn.
    spectra, diagrams : tuple of int
        Lengths of records, in periods.
    truth : tuple of float
        Exponents in closed form, NaN where only a long run tells.
    """

    name: str
    system: "cd.HybridSystem"
    box: dict[str, tuple[float, float]]
    spectra: tuple[int, ...]
    diagrams: tuple[int, ...]
    truth: tuple[float, ...] = (math.nan,)


@dataclass(frozen=True)
class Row:
    """What was counted of one kind of record; ``naive`` is NaN where the blocks are not known."""

    motion: str
    record: str
    held: np.ndarray
    naive: float
    bar: float

    def cells(self) -> list[str]:
        """Return the row of the table."""
        naive = "" if math.isnan(self.naive) else f"{100 * self.naive:.0f}"
        count = f"{self.held.sum()} of {self.held.size}"
        return [self.motion, self.record, count, f"{100 * self.held.mean():.1f}", naive, f"{self.bar:.2f}"]

    @property
    def holds(self) -> bool:
        """Whether the coverage is as promised."""
        return BOUNDS[0] <= self.held.mean() and (self.held.mean() <= BOUNDS[1] or self.bar < WIDEST)


def lorenz() -> "cd.HybridSystem":
    """Lorenz's system, whose time is counted in units."""
    x, y, z, rho = sympy.symbols("x y z rho", real=True)
    return cd.HybridSystem(
        name="lorenz",
        states=(x, y, z),
        parameters={"rho": 28.0},
        modes={"flow": {x: 10 * (y - x), y: rho * x - y - x * z, z: x * y - sympy.Rational(8, 3) * z}},
        period=sympy.Integer(1),
        initial={x: 1.0, y: 1.0, z: 20.0},
    )


def drill() -> "cd.HybridSystem":
    """The percussive drill in the chaos of the paper."""
    effects = {"friction": "stribeck", "contact": "hunt-crossley"}
    load = {"eta": 0.448, "xi": 0.06, "a": 0.25, "b": 0.7, "r": 1.0, "eps": 1.0, "phi": math.pi / 2}
    return cd.drill(**effects, **load, mu=0.6, g=3.0, lam=0.6)


def dropped_ball() -> "cd.HybridSystem":
    """A ball dropped from x, hitting the floor at the speed w, and dropped again from abs(1 - sqrt(2) w).

    Heights follow x -> abs(1 - 2 sqrt(x)), whose fixed point at 1 is neutral: long laminar phases, whose length has no
    variance. All heights are equally likely, so that the exponent is 1/2 a drop, which takes 2 sqrt(2)/3 on average.
    """
    x, w, gravity = sympy.symbols("x w gravity", real=True)
    again = sympy.Abs(1 - sympy.sqrt(2 / gravity) * w)
    return cd.HybridSystem(
        name="dropped-ball",
        states=(x, w),
        parameters={"gravity": 1.0},
        modes={"fall": {x: -w, w: gravity}},
        transitions=[cd.Transition("drop", "fall", "fall", guard=x, direction=-1, reset={x: again, w: 0})],
        period=sympy.Integer(1),
        initial={x: 0.3, w: 0.0},
    )


def stick_slip() -> "cd.HybridSystem":
    """A driven oscillator on a belt just beyond grazing-sliding, where a cycle turns into chaos at once.

    Source: di Bernardo, Kowalczyk and Nordmark 2003, doi:10.1142/S021812740300834X.
    """
    u, w, t, nu = sympy.symbols("u w t nu", real=True)
    load = sympy.cos(nu * t) / 10
    friction = sympy.Rational(3, 2) * w + sympy.Rational(9, 20) * (1 - w) ** 3
    return cd.HybridSystem(
        name="stick-slip",
        states=(u, w),
        time=t,
        parameters={"nu": 1.7077},
        modes={"slip": {u: w, w: -u + friction + load}, "stick": {u: w, w: 0}},
        transitions=[
            cd.Transition("stick", "slip", "stick", guard=w - 1, direction=+1, reset={w: 1}),
            cd.Transition("release", "stick", "slip", guard=u - load - sympy.Rational(3, 2), direction=+1),
        ],
        period=2 * sympy.pi / nu,
        initial={"mode": "slip", u: 1.0, w: 0.5},
    )


def motions() -> list[Motion]:
    """What is measured."""
    ball = (1.5 / math.sqrt(8), 0.0)
    return [
        Motion(
            "Lorenz", lorenz(), {"x": (-10, 10), "y": (-10, 10), "z": (15, 35)}, (256, 2048), (128, 1024), (math.nan, 0)
        ),
        Motion("drill at eta 0.448", drill(), {"y": (0.6, 0.9), "u": (-0.3, 0.0)}, (256, 2048), (128, 1024)),
        Motion("dropped ball, intermittent", dropped_ball(), {"x": (0, 1)}, (2048, 16384), (2048, 16384), ball),
        Motion("belt beyond grazing-sliding", stick_slip(), {"u": (0.9, 1.1)}, (256, 2048), (128, 1024)),
    ]


def measure(motion: Motion, repetitions: int) -> list[Row]:
    """Return the rows of a motion: spectra first, whose longest run tells the truth to the diagrams."""
    rows, truth = [], np.array(motion.truth)
    for periods in sorted(motion.spectra, reverse=True):
        rates = block_rates(motion.system, periods, repetitions)[:, :, : len(truth)]
        truth = np.where(np.isnan(truth), rates.mean(axis=(0, 1)), truth)
        for number, value in enumerate(truth):
            name = motion.name + (f", λ{number + 1} = 0" if value == 0 else "")
            rows.append(judged(name, f"spectrum, {periods} periods", rates[:, :, number], value))
    for periods in sorted(motion.diagrams, reverse=True):
        rows.append(diagram_row(motion, periods, repetitions, truth[0]))
    return rows


def block_rates(system: "cd.HybridSystem", periods: int, repetitions: int) -> np.ndarray:
    """Return the exponents over each block of one long run, shape (blocks, repetitions, exponents)."""
    run = cd.lyapunov_spectrum(
        system, periods=periods * repetitions, transient=TRANSIENT, blocks=BLOCKS * repetitions, tolerance=TOLERANCE
    )
    history, time = run["lyapunov_history"].values, run["block_time"].values
    history = history[:, np.isfinite(history[-1])]
    # columns are in the order at the end of the run, so that each is one tangent throughout
    grown = np.concatenate([np.zeros((1, history.shape[1])), history * time[:, np.newaxis]])
    rates = np.diff(grown, axis=0) / np.diff(time, prepend=0)[:, np.newaxis]
    return rates.reshape(repetitions, BLOCKS, -1).transpose(1, 0, 2)


def judged(name: str, record: str, rates: np.ndarray, truth: float) -> Row:
    """Return the row of records whose blocks are known, shape (blocks, repetitions)."""
    off, bars = rates.mean(axis=0) - truth, standard_error(rates)
    naive = rates.std(axis=0, ddof=1) / np.sqrt(len(rates))
    missed = (np.abs(off) <= INTERVAL * naive).mean()
    return Row(name, record, np.abs(off) <= INTERVAL * bars, missed, bar_ratio(bars, off))


def diagram_row(motion: Motion, periods: int, repetitions: int, truth: float) -> Row:
    """Return the row of a diagram with this number of starts at one value of its parameter."""
    name, value = next(iter(motion.system.parameters.items()))
    found = cd.bifurcation_diagram(
        motion.system,
        {name: np.array([value])},
        transient=TRANSIENT,
        periods=periods,
        random={"count": repetitions, "seed": 1, **motion.box},
        tolerance=TOLERANCE,
    )
    chaotic = np.isin(found["outcome"].values[0], (cd.Outcome.CHAOTIC, cd.Outcome.QUASIPERIODIC))
    off = found["lyapunov_exponent"].values[0, chaotic, 0] - truth
    bars = found["lyapunov_error"].values[0, chaotic, 0]
    held = np.abs(off) <= INTERVAL * bars
    return Row(motion.name, f"diagram, {periods} periods", held, math.nan, bar_ratio(bars, off))


def bar_ratio(bars: np.ndarray, off: np.ndarray) -> float:
    """Median error bar over the root mean square of the actual errors."""
    return float(np.median(bars) / np.sqrt(np.mean(off**2)))


def noise(blocks: int, correlation: float, repetitions: int) -> np.ndarray:
    """Return Gaussian noise with a correlation time in blocks, shape (blocks, repetitions); 0 is white."""
    generator = np.random.default_rng(blocks)
    factor = math.exp(-1 / correlation) if correlation else 0.0
    values = generator.normal(size=(blocks, repetitions))
    values[0] /= math.sqrt(1 - factor**2)
    for k in range(1, blocks):
        values[k] += factor * values[k - 1]
    return values


def main() -> int:
    """Measure, write the table, and return 1 if a coverage is not as promised."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repetitions", type=int, default=1000, help="records of each kind (default: 1000)")
    given = parser.parse_args()
    rows = []
    for correlation in (0, 0.2, 1, 5):
        for blocks in (32, 64, 256):
            name = f"noise, correlation over {correlation:g} blocks" if correlation else "white noise"
            rows.append(judged(name, f"{blocks} blocks", noise(blocks, correlation, 10 * given.repetitions), 0.0))
    for motion in motions():
        rows += measure(motion, given.repetitions)
        print(f"{motion.name}: {sum(row.holds for row in rows)} of {len(rows)} rows so far hold", file=sys.stderr)
    lines = ["| " + " | ".join(cells) + " |" for cells in [HEAD, ["---"] * len(HEAD), *(row.cells() for row in rows)]]
    OUT.mkdir(exist_ok=True)
    (OUT / "error_bars.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))
    return 0 if all(row.holds for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
