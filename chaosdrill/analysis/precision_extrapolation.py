"""Smooth arcs in extended precision: the modified midpoint rule, extrapolated.

Gragg's rule has an error expansion in even powers of the step, so that each further column of the extrapolation adds
two orders (Gragg 1965, doi:10.1137/0702030; Bulirsch and Stoer 1966, doi:10.1007/BF02165234). It needs nothing but the
right-hand side, and shares no formula with the methods that are measured against it.
"""

from collections.abc import Callable, Sequence
from typing import Any

Point = list[Any]
Rate = Callable[[Any, Point], Point]

SAFETY = 0.8


def extrapolated_step(rate: Rate, t: Any, x: Point, h: Any, columns: int) -> tuple[Point, float]:
    """One step of length ``h``.

    Parameters
    ----------
    rate : callable
        Time derivative (time, state) -> state; mpmath numbers throughout.
    t, x : mpf, list of mpf
        Where the step begins.
    h : mpf
        Its length.
    columns : int
        Columns of the extrapolation table; the step has the order 2 columns.

    Returns
    -------
    state : list of mpf
    error : float
        Difference to the table with one column less, relative to max(1, abs(x)).
    """
    first = rate(t, x)
    rows: list[list[Point]] = []
    for j in range(1, columns + 1):
        parts = 2 * j
        s = h / parts
        before, now = x, [a + s * b for a, b in zip(x, first, strict=True)]
        for i in range(1, parts):
            slope = rate(t + i * s, now)
            before, now = now, [a + 2 * s * b for a, b in zip(before, slope, strict=True)]
        row = [now]
        for k in range(1, j):
            # (n_j / n_(j-k))^2 - 1 for the numbers 2, 4, 6, ... of parts
            weight = (j * j - (j - k) ** 2, (j - k) ** 2)
            finer, coarser = row[-1], rows[-1][k - 1]
            row.append([a + (a - b) * weight[1] / weight[0] for a, b in zip(finer, coarser, strict=True)])
        rows.append(row)
    best, other = rows[-1][-1], rows[-1][-2]
    scale = max(1.0, *(float(abs(a)) for a in best))
    return best, float(max(abs(a - b) for a, b in zip(best, other, strict=True))) / scale


def arc(
    rate: Rate, t: Any, x: Point, end: Any, columns: int, tolerance: float, first: Any, most: int
) -> tuple[list[Point], list[Any], Any]:
    """Integrate to ``end``, choosing the steps.

    Parameters
    ----------
    rate, t, x, columns
        As for `extrapolated_step`.
    end : mpf
        Time to reach.
    tolerance : float
        Local error of a step.
    first : mpf
        Length to try first.
    most : int
        Largest number of steps, those included that were too long.

    Returns
    -------
    states : list of states
        At the start and at the end of every step.
    mesh : list of mpf
        Lengths of the steps; `along` repeats them.
    length : mpf
        The length to try first on the next arc.

    Raises
    ------
    ArithmeticError
        More steps than ``most``, or a state without a value.
    """
    states: list[Point] = [x]
    mesh: list[Any] = []
    length, tries = first, 0
    while t < end:
        tries += 1
        h = min(length, end - t)
        # two steps of equal length, not a long one and a sliver
        if h < end - t < 2 * h:
            h = (end - t) / 2
        moved, error = extrapolated_step(rate, t, states[-1], h, columns)
        if error != error or tries > most:
            raise ArithmeticError(f"the reference needs more than {most} steps, or has no value")
        factor = min(4.0, SAFETY * (tolerance / max(error, 1e-300)) ** (1 / (2 * columns - 1)))
        if error > tolerance:
            length = h * min(0.5, max(factor, 0.05))
            continue
        t += h
        states.append(moved)
        mesh.append(h)
        length = h * max(1.0, factor)
    return states, mesh, length


def along(rate: Rate, t: Any, x: Point, mesh: Sequence[Any], columns: int) -> Point:
    """Integrate along given steps, so that the result is a smooth function of the start."""
    for h in mesh:
        x, _ = extrapolated_step(rate, t, x, h, columns)
        t += h
    return x
