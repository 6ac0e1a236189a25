"""How busy other work keeps the machine meanwhile."""

import os
import time
from pathlib import Path

_STAT = Path("/proc/stat")


class Others:
    """Processor seconds that others use from ``start`` on; NaN where the system does not tell."""

    def __init__(self) -> None:
        self.clock, self.own, self.all = time.perf_counter(), _own(), _all()

    def share(self) -> float:
        """Cores that others have kept busy since then, on average."""
        clock = time.perf_counter() - self.clock
        return max(0.0, _all() - self.all - (_own() - self.own)) / clock


def _own() -> float:
    t = os.times()
    return t.user + t.system + t.children_user + t.children_system


def _all() -> float:
    if not _STAT.is_file():
        return float("nan")
    user, nice, system, _, _, irq, softirq, steal = map(int, _STAT.read_text().splitlines()[0].split()[1:9])
    return (user + nice + system + irq + softirq + steal) / os.sysconf("SC_CLK_TCK")
