"""Write an archive as one page."""

import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from chaosdrill.annotations import Dataset, DataTree
from chaosdrill.archive import check_writable, writing
from chaosdrill.archive.digest import unsealed
from chaosdrill.archive.read import altered_parts, read_archive
from chaosdrill.dataset.dates import undated
from chaosdrill.dataset.outcomes import count_outcomes
from chaosdrill.errors import ArchiveError, ChaosdrillError, SettingsError
from chaosdrill.files import name_text
from chaosdrill.reports import charts, tables
from chaosdrill.reports.html import NOTHING, joined, part, render, shown, table
from chaosdrill.reports.origin import citations_section, origin_section, scene_section
from chaosdrill.reports.tuning import TUNING
from chaosdrill.typed import PATH, expecting
from chaosdrill.version import __version__

if TYPE_CHECKING:
    from chaosdrill.plots import Picture

SUFFIXES = (".html", ".htm")

_LEADS_AWAY = re.compile(r"<\s*/?\s*(meta|base|link|iframe|frame|object|embed|form)\b", re.IGNORECASE)
"""Elements that only the frame may contain. No policy of a page prevents browsers from following a ``meta`` refresh."""

_SCRIPTS = ("read.js", "scale.js", "draw.js", "tell.js", "explore.js")

# in the order in which they stand on the page; each gives nothing where a dataset has nothing of it
_TABLES: tuple[Callable[[Dataset], Markup], ...] = (
    tables.outcomes,
    tables.exponents,
    tables.multipliers,
    tables.event_counts,
    tables.motions,
    tables.without_results,
    tables.intervals,
    tables.attractors,
    tables.orbits,
    tables.derivatives,
    tables.branches,
    tables.equilibria,
    tables.work_precision,
    tables.single_numbers,
)


@dataclass(frozen=True)
class _Section:
    """A part of the page with an entry in the table of contents: its id, its heading and its content."""

    key: str
    title: str
    body: Markup


@dataclass(frozen=True)
class Report:
    """What `report` has written.

    Parameters
    ----------
    path : pathlib.Path
        The page.
    archive : pathlib.Path
        The archive shown.
    bytes : int
        Size of the page.
    groups : tuple of str
        Analyses shown.
    pictures : int
        Number of pictures.
    charts : int
        Number of interactive charts.
    faults : tuple of str
        Parts that could not be shown, as in an altered archive; empty if all are shown.
    unsealed : str
        A warning about groups without digests, whose alterations cannot be detected; empty if all have digests.
    altered : tuple of str
        What was altered after the archive was written, by its digests; empty if nothing was.
    """

    path: Path
    archive: Path
    bytes: int
    groups: tuple[str, ...]
    pictures: int
    charts: int
    faults: tuple[str, ...]
    unsealed: str
    altered: tuple[str, ...]


@expecting(SettingsError, path=PATH, output=PATH)
def report(path: str | os.PathLike[str], output: str | os.PathLike[str] | None = None) -> Report:
    """Write the contents of an archive to one page that needs no network and no other file.

    Parameters
    ----------
    path : path-like
        The archive.
    output : path-like, optional
        The page, with the suffix ``.html``; default: next to the archive, under its name. An earlier page is replaced,
        or left unchanged if the new one cannot be written.

    Returns
    -------
    Report
        The path of the page, and ``faults``: the parts that could not be shown, if any.

    Raises
    ------
    ArchiveError
        If the archive cannot be opened or the page cannot be written.
    SettingsError
        If ``output`` does not end with ``.html``, or is ``-``.
    """
    source = Path(path)
    if output is not None and os.fspath(output) == "-":
        raise SettingsError("output is '-', but a report is a file; name one, such as report.html")
    if output is not None and Path(output).suffix.lower() not in SUFFIXES:
        raise SettingsError(f"output: a report is a page, and {os.fspath(output)!r} does not end with .html")
    # what can be opened has a name, from which that of the page is made
    tree = read_archive(source)
    target = Path(output) if output is not None else source.with_suffix(".html")
    check_writable(target, ".html", named=output is not None)
    written = _Writer(tree, source)
    content = written.page().encode("utf-8", errors="replace")
    with writing(target, "report", named=output is not None) as draft:
        draft.write_bytes(content)
    return Report(
        target,
        source,
        len(content),
        tuple(written.groups),
        written.pictures,
        written.charts,
        tuple(written.faults),
        unsealed(tree),
        tuple(written.altered),
    )


class _Writer:
    """Makes the sections and counts their contents."""

    def __init__(self, tree: DataTree, path: Path) -> None:
        self.tree, self.path = tree, path
        results = (node for node in tree.subtree if "kind" in node.attrs)
        self.groups = {node.path.strip("/") or "result": undated(node.to_dataset()) for node in results}
        self.pictures, self.charts, self.faults, self.altered = 0, 0, list[str](), list[str]()

    def page(self) -> str:
        title = str(self.tree.attrs.get("title", name_text(self.path.name)))
        sections = [
            *self._analyses(),
            _Section("summary", "Summary", self._try("summary", self._summary)),
            _Section("scene", "Scene and equations", self._try("scene", scene_section, self.tree)),
            _Section("accuracy", "Accuracy and cost", self._try("accuracy", tables.accuracy_section, self.groups)),
            _Section("citations", "What to cite", self._try("citations", citations_section, self.tree)),
            _Section("origin", "Provenance", self._try("provenance", origin_section, self.tree, self.path)),
        ]
        made = str(self.tree.attrs.get("history", "")).split("\n")[-1]
        digests = self._try("digests", self._altered)
        return _framed(
            title=shown(title, TUNING.title),
            intro=f"{name_text(self.path.name)}. {made}",
            digests=digests,
            faults=self.faults,
            sections=sections,
        )

    def _altered(self) -> Markup:
        self.altered = altered_parts(self.tree)
        if not (changed := ", ".join(self.altered)):
            return part("paragraph", bare, "fault") if (bare := unsealed(self.tree)) else NOTHING
        told = f"Altered since the archive was written, so this page may show numbers that no run gave: {changed}."
        return part("paragraph", told, "fault")

    def _summary(self) -> Markup:
        rows = []
        for place, (name, dataset) in enumerate(self.groups.items()):
            counts = count_outcomes(dataset["outcome"].values) if "outcome" in dataset else {}
            ended = ", ".join(f"{outcome.replace('_', ' ')} {n}" for outcome, n in counts.items())
            link = part("link", name, f"analysis-{place}")
            rows.append((link, str(dataset.attrs["kind"]), str(dataset.attrs.get("system", "")), ended))
        return table("Contents of the archive", ("analysis", "kind", "system", "outcomes"), rows)

    def _analyses(self) -> list[_Section]:
        from chaosdrill.plots import plan

        drawn: dict[str, list[Markup]] = {name: [] for name in self.groups}
        planned: list[tuple[list[str], Picture]] = []
        self._try("pictures", lambda: planned.extend(plan(self.groups)))
        for names, picture in planned[TUNING.pictures :]:
            told = f"the picture {picture.name}, after {TUNING.pictures} others."
            drawn[names[0]].append(part("paragraph", told, "left-out"))
        for names, picture in planned[: TUNING.pictures]:
            drawn[names[0]].append(self._try(f"{names[0]}: {picture.name}", self._figure, picture, names))
        sections = []
        for place, (name, dataset) in enumerate(self.groups.items()):
            parts = [
                *drawn[name],
                self._try(name, charts.summary, dataset),
                self._try(f"{name}: interactive chart", self._explorer, dataset, name),
                *(self._try(f"{name}: {t.__name__.replace('_', ' ')}", t, dataset) for t in _TABLES),
            ]
            kind = charts.in_words(str(dataset.attrs["kind"]))
            said = set(name.lower().split()) <= set(str(dataset.attrs["kind"]).split("-"))
            title = f"{kind[:1].upper()}{kind[1:]}" if said else f"{name}: {kind}"
            sections.append(_Section(f"analysis-{place}", title, joined(parts)))
        return sections

    def _figure(self, picture: "Picture", names: list[str]) -> Markup:
        made = charts.figure(picture, names, self.groups)
        self.pictures += 1
        return made

    def _explorer(self, dataset: Dataset, name: str) -> Markup:
        many = sum(one.attrs["kind"] in charts.KINDS for one in self.groups.values())
        made = charts.explorer(dataset, name, self.charts, min(1.0, TUNING.whole_charts / max(many, 1)))
        self.charts += bool(made)
        return made

    def _try(self, what: str, make: Callable[..., Any], *arguments: Any) -> Any:
        """The part that ``make`` returns, or a note that it failed, so that one fault hides nothing else."""
        try:
            return make(*arguments)
        except MemoryError:
            raise
        # an archive that somebody altered may break any expectation, each in its own way
        except Exception as fault:
            told = str(fault) if isinstance(fault, ChaosdrillError) else f"{type(fault).__name__}: {fault}"
            self.faults.append(f"{what}: {told}")
            return part("paragraph", f"This part could not be shown ({self.faults[-1]}).", "fault")


def _framed(title: str, **content: Any) -> str:
    """The whole page: style and script are embedded, and nothing else may run or be loaded.

    Raises `ArchiveError` if anything except the frame would lead away from the page, or load something.
    """
    body = render("body.html", title=title, **content)
    if found := _LEADS_AWAY.search(body):
        raise ArchiveError(f"the report would hold an element {found[1]}, which no page may hold; it was not written")
    scripts = "\n".join(_asset(name) for name in _SCRIPTS)
    return render(
        "page.html",
        title=title,
        body=body,
        version=__version__,
        style=Markup(_asset("page.css")),
        script=Markup(f'"use strict";\n(() => {{\n{scripts}}})();\n'),
    )


def _asset(name: str) -> str:
    return files("chaosdrill.reports").joinpath("assets", name).read_text(encoding="utf-8")
