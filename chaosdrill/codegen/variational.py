"""Taylor coefficients of two solutions of the variational equation of one mode, as Python source."""

from chaosdrill.codegen.constants import Constants, with_constants
from chaosdrill.codegen.recurrence import PASS
from chaosdrill.codegen.taylor import ModeSource


def tangent(mode: ModeSource, constants: Constants) -> list[str]:
    """Body of ``tangent``: the rows from ``row`` hold the n series of one vector, then those of the other.

    All modes fill the rows up to ``order`` + 1, for one polynomial must not end in what another mode has left.

    The Jacobian's series is known, so that a pass sums all older coefficients of four orders at once; what is left
    between one order and the next is a product with the Jacobian at the start, whose entries wait in registers.
    """
    n = mode.n
    pairs = sorted({(mode.rows[index], j) for (_, j), (index, _) in mode.products.items()})
    lines = [f"h{r} = ws[{r}]" for r in sorted({row for row, _ in pairs})]
    for i in range(n):
        lines += [f"a{i} = first[{i}]", f"b{i} = second[{i}]"]
        lines += [f"wa{i} = ws[row + {i}]", f"wb{i} = ws[row + {n + i}]", f"wa{i}[0] = a{i}", f"wb{i}[0] = b{i}"]
    lines += [f"h{r}_{k} = h{r}[{k}]" for r in sorted({row for row, _ in pairs}) for k in range(PASS)]
    start: dict[tuple[int, int], list[str]] = {}
    for place, entry in mode.linear.items():
        start.setdefault(place, []).append(constants.text(entry))
    for place, (index, weight) in mode.products.items():
        start.setdefault(place, []).append(f"{mode.source.times(weight)}h{mode.rows[index]}_0")
    lines += [f"j{i}_{j} = {' + '.join(terms)}" for (i, j), terms in start.items()]
    loop: list[str] = []
    for row, j in pairs:
        name = f"{row}_{j}"
        loop += [f"{sums}{name}_{lane} = 0.0" for sums in "pqrs" for lane in range(PASS)]
        loop += ["for i in range(0, base, 2):", f"    d = wa{j}[i]", f"    e = wb{j}[i]"]
        loop += [f"    f = wa{j}[i + 1]", f"    g = wb{j}[i + 1]", f"    u = h{row}[uint64(base - i - 1)]"]
        for lane in range(PASS):
            # two chains a sum: the even and the odd terms
            loop += [
                f"    r{name}_{lane} += u * f",
                f"    s{name}_{lane} += u * g",
                f"    u = h{row}[uint64(base - i + {lane})]",
            ]
            loop += [f"    p{name}_{lane} += u * d", f"    q{name}_{lane} += u * e"]
        loop += [f"{a}{name}_{lane} += {b}{name}_{lane}" for a, b in ("pr", "qs") for lane in range(PASS)]
    lanes = PASS if pairs else 1
    for lane in range(lanes):
        loop += [f"k = base + {lane}", "ik = RECIPROCAL[uint64(k + 1)]"]
        loop += [f"i{i}_{j} = ik * j{i}_{j}" for i, j in start]
        for letter, sums in (("a", "p"), ("b", "q")):
            for i in range(n):
                loop.append(f"n{letter}{i} = {_next(mode, sorted(start), i, letter, sums, lane)}")
        for letter in "ab":
            for i in range(n):
                # coefficients of this pass, by their place in it
                loop += [f"{letter}{i}_{lane} = {letter}{i}"] if any(j == i for _, j in pairs) else []
                loop += [f"{letter}{i} = n{letter}{i}", f"w{letter}{i}[k + 1] = {letter}{i}"]
    return with_constants([*lines, f"for base in range(0, order + 1, {lanes}):", *(f"    {line}" for line in loop)])


def _next(mode: ModeSource, entries: list[tuple[int, int]], i: int, letter: str, sums: str, lane: int) -> str:
    """Coefficient k + 1 of entry i: what is old first, the product with the Jacobian at the start last."""
    old: list[str] = []
    for (a, j), (index, weight) in mode.products.items():
        if a == i:
            row = mode.rows[index]
            inner = [f"{sums}{row}_{j}_{lane}", *(f"h{row}_{lane - m} * {letter}{j}_{m}" for m in range(lane))]
            old.append(f"{mode.source.times(weight)}({' + '.join(inner)})")
    newest = [f"i{a}_{j} * {letter}{j}" for a, j in entries if a == i]
    terms = [f"ik * ({' + '.join(old)})"] * bool(old) + newest
    return " + ".join(terms) if terms else "0.0"
