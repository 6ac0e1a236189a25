"""Numbers as people read them."""

from typing import Any

MISSING = "–"


def number(value: Any, digits: int = 6) -> str:
    """A number with so many significant digits; NaN is a dash, and whole numbers keep all of theirs."""
    if isinstance(value, int) or getattr(getattr(value, "dtype", None), "kind", None) in ("i", "u"):
        return str(int(value)).replace("-", "−")
    value = float(value)
    if value != value:
        return MISSING
    if value in (float("inf"), float("-inf")):
        return "∞" if value > 0 else "−∞"
    return f"{value:.{digits}g}".replace("-", "−")


def uncertain(value: Any, error: Any) -> str:
    """A number with its standard error, where it has one."""
    from chaosdrill.plot.style import uncertain as written

    value, error = float(value), float(error)
    return MISSING if value != value else written(value, error)


def seconds(value: Any) -> str:
    """A time in the unit that suits it."""
    value = float(value)
    if not value < float("inf"):
        return MISSING
    if value < 1e-3:
        return f"{1e6 * value:.3g} µs"
    if value < 1:
        return f"{1000 * value:.3g} ms"
    if value < 120:
        return f"{value:.3g} s"
    minutes, left = divmod(round(value), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min {left} s"


def count(items: int, one: str, many: str | None = None) -> str:
    """``1 point``, ``2 points``."""
    return f"{items} {one if items == 1 else many or one + 's'}"
