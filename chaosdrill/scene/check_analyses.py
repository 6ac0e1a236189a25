"""What a scene asks for: its numerics, and analyses that exist and fit its system."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path as File
from typing import TYPE_CHECKING, Any

from chaosdrill.analysis.base import Analysis, NumericsSettings
from chaosdrill.analysis.registry import analyses, function
from chaosdrill.names import remedy
from chaosdrill.scene.lines import Path
from chaosdrill.scene.problems import Problem, problems_of

if TYPE_CHECKING:
    import xarray as xr

    from chaosdrill.scene.check_system import CheckedSystem

_GROUP = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")


@dataclass(frozen=True)
class Asked:
    """An analysis that a scene asks for, with the table that says so.

    A setting that the scene leaves out is not passed on, so that its default stands in one place.
    """

    entry: Analysis
    table: Mapping[str, Any]

    @property
    def kind(self) -> str:
        """Kind of the analysis."""
        return self.entry.kind

    @property
    def parallel(self) -> bool:
        """Whether it has many points, which several workers can share."""
        return self.entry.settings.parallel

    def keywords(self) -> dict[str, Any]:
        """Arguments of the analysis function that the scene gives."""
        return self.entry.settings.arguments(self.table)

    def get(self, name: str) -> Any:
        """A setting as the scene gives it, or its default; None where the analysis has no such setting."""
        return self.table.get(name, self.entry.settings.default(name))

    def run(
        self,
        system: Any,
        numerics: Mapping[str, Any],
        *,
        workers: int = 1,
        scheduler: str | None = None,
        store: File | None = None,
        progress: Callable[..., None] | None = None,
    ) -> "xr.Dataset":
        """Run the analysis, by as many workers at a time as it has points for; ``store`` keeps finished chunks."""
        keywords = self.keywords()
        if self.parallel:
            keywords |= {"workers": workers, "scheduler": scheduler, "store": store}
        if not self.entry.settings.own_numerics:
            keywords |= numerics
        result: xr.Dataset = function(self.entry.function)(system, **keywords, progress=progress)
        return result


def check_numerics(raw: Mapping[str, Any]) -> tuple[dict[str, Any], list[Problem]]:
    """The arguments that the table ``numerics`` gives, unless it has faults."""
    problems = problems_of(NumericsSettings.faults(raw, also=()), ("numerics",))
    return {} if problems else NumericsSettings.arguments(raw), problems


def check_analyses(raw: Mapping[str, Any], system: "CheckedSystem") -> tuple[dict[str, Asked], list[Problem]]:
    """Check every table ``analysis.NAME``."""
    found: dict[str, Asked] = {}
    problems: list[Problem] = []
    known = analyses()
    for name, table in raw.items():
        at: Path = ("analysis", name)
        if not _GROUP.fullmatch(name):
            problems.append(Problem(at, "the name must consist of at most 64 letters, digits, '_', '.' and '-'"))
        if not isinstance(table, Mapping):
            continue
        kind = table.get("kind")
        if not isinstance(kind, str) or kind not in known:
            fault = "missing" if kind is None else f"unknown kind {kind!r:.60}"
            problems.append(Problem((*at, "kind"), f"{fault}; {remedy(str(kind), known)}"))
            continue
        problems += problems_of(known[kind].settings.faults(table, system, also=("kind",)), at)
        found[name] = Asked(known[kind], {key: value for key, value in table.items() if key != "kind"})
    return found, problems
