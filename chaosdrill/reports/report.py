"""From an archive to one page."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from chaosdrill.errors import ChaosdrillError, SettingsError
from chaosdrill.files import followed, name_text, remove_drafts
from chaosdrill.reports import accuracy, explorer, orbits, points, runs
from chaosdrill.reports.figures import figure
from chaosdrill.reports.html import Html, element, joined, table
from chaosdrill.reports.origin import altered_parts, citations_section, origin_section
from chaosdrill.reports.page import Section, page
from chaosdrill.reports.scenes import scene_section
from chaosdrill.typed import PATH, expecting

if TYPE_CHECKING:
    import xarray as xr

    from chaosdrill.plot import Picture

SUFFIXES = (".html", ".htm")
MOST_PICTURES = 100
WHOLE_CHARTS = 2
"""So many interactive charts may have their largest size; more share what these have."""

# in the order in which they stand on the page; each gives nothing where a dataset has nothing of it
_TABLES: tuple[Callable[["xr.Dataset"], Html], ...] = (
    runs.outcomes,
    runs.exponents,
    runs.multipliers,
    runs.event_counts,
    points.motions,
    points.without_results,
    points.stretches,
    points.attractors,
    orbits.orbits,
    orbits.branches,
    accuracy.work_precision,
    runs.single_numbers,
)


@dataclass(frozen=True)
class Report:
    """What `report` has written.

    Parameters
    ----------
    path : pathlib.Path
        The page.
    archive : pathlib.Path
        What it is about.
    bytes : int
        Size of the page.
    groups : tuple of str
        Analyses on it.
    pictures : int
        Pictures on it.
    charts : int
        Interactive charts on it.
    faults : tuple of str
        Parts that could not be shown, as an archive that was altered may have; empty if all is there.
    """

    path: Path
    archive: Path
    bytes: int
    groups: tuple[str, ...]
    pictures: int
    charts: int
    faults: tuple[str, ...]


@expecting(SettingsError, path=PATH, output=PATH)
def report(path: str | os.PathLike[str], output: str | os.PathLike[str] | None = None) -> Report:
    """Write all that an archive tells into one page that needs nothing else, no network and no other file.

    Parameters
    ----------
    path : path-like
        The archive.
    output : path-like, optional
        The page, with the ending ``.html``; default: beside the archive, under its name. An earlier one is replaced,
        and left as it was if the new one cannot be written.

    Returns
    -------
    Report
        Where the page is, and ``faults``: what could not be shown, empty if all is there.

    Raises
    ------
    ArchiveError
        If the archive cannot be opened or the page cannot be written.
    SettingsError
        If ``output`` does not end with ``.html``, or is ``-``.
    """
    from chaosdrill.archive import check_writable, writing
    from chaosdrill.archive import open as open_archive

    source = Path(path)
    if output is not None and os.fspath(output) == "-":
        raise SettingsError("output is '-', but a report is a file; name one, such as report.html")
    if output is not None and Path(output).suffix.lower() not in SUFFIXES:
        raise SettingsError(f"output: a report is a page, and {os.fspath(output)!r} does not end with .html")
    # what can be opened has a name, from which that of the page is made
    tree = open_archive(source)
    target = Path(output) if output is not None else source.with_suffix(".html")
    check_writable(target, ".html")
    written = _Writer(tree, source)
    content = written.page().encode("utf-8", errors="replace")
    remove_drafts(followed(target))
    with writing(target, "report") as draft:
        draft.write_bytes(content)
    return Report(
        target, source, len(content), tuple(written.groups), written.pictures, written.charts, tuple(written.faults)
    )


class _Writer:
    """Makes the sections and counts what is in them."""

    def __init__(self, tree: "xr.DataTree", path: Path) -> None:
        self.tree, self.path = tree, path
        self.groups = {n.path.strip("/") or "result": n.to_dataset() for n in tree.subtree if "kind" in n.attrs}
        self.pictures, self.charts, self.faults = 0, 0, list[str]()

    def page(self) -> str:
        title = str(self.tree.attrs.get("title", name_text(self.path.name)))
        sections = [
            Section("summary", "Summary", self._try("summary", self._summary)),
            Section("scene", "Scene and equations", self._try("scene", scene_section, self.tree)),
            *self._analyses(),
            Section("accuracy", "Accuracy and cost", self._try("accuracy", accuracy.accuracy_section, self.groups)),
            Section("citations", "What to cite", self._try("citations", citations_section, self.tree)),
            Section("origin", "Provenance", self._try("provenance", origin_section, self.tree, self.path)),
        ]
        made = str(self.tree.attrs.get("history", "")).split("\n")[-1]
        intro = element("p", f"{name_text(self.path.name)}. {made}")
        intro = joined([intro, self._try("digests", self._altered)])
        if self.faults:
            listed = element("ul", *(element("li", fault) for fault in self.faults))
            intro = joined(
                [intro, element("div", element("p", "Not everything could be shown:"), listed, class_="fault")]
            )
        return page(title, intro, sections)

    def _altered(self) -> Html:
        if not (changed := ", ".join(altered_parts(self.tree))):
            return Html("")
        told = f"Altered since the archive was written, so that this page may tell of what was not run: {changed}."
        return element("p", told, class_="fault")

    def _summary(self) -> Html:
        from chaosdrill.dataset.outcomes import count_outcomes

        rows = []
        for place, (name, dataset) in enumerate(self.groups.items()):
            counts = count_outcomes(dataset["outcome"].values) if "outcome" in dataset else {}
            ended = ", ".join(f"{outcome.replace('_', ' ')} {n}" for outcome, n in counts.items())
            link = element("a", name, href=f"#analysis-{place}")
            rows.append((link, str(dataset.attrs["kind"]), str(dataset.attrs.get("system", "")), ended))
        return table("What is in the archive", ("analysis", "kind", "system", "outcomes"), rows)

    def _analyses(self) -> list[Section]:
        from chaosdrill.plot import plan

        drawn: dict[str, list[Html]] = {name: [] for name in self.groups}
        planned: list[tuple[list[str], Picture]] = []
        self._try("pictures", lambda: planned.extend(plan(self.groups)))
        for names, picture in planned[MOST_PICTURES:]:
            drawn[names[0]].append(
                element("p", f"the picture {picture.name}, after {MOST_PICTURES} others.", class_="left-out")
            )
        for names, picture in planned[:MOST_PICTURES]:
            drawn[names[0]].append(self._try(f"{names[0]}: {picture.name}", self._figure, picture, names))
        sections = []
        for place, (name, dataset) in enumerate(self.groups.items()):
            parts = [
                self._try(name, explorer.summary, dataset),
                *drawn[name],
                self._try(f"{name}: interactive chart", self._explorer, dataset, name),
                *(self._try(f"{name}: {t.__name__.replace('_', ' ')}", t, dataset) for t in _TABLES),
            ]
            title = f"{name}: {str(dataset.attrs['kind']).replace('-', ' ')}"
            sections.append(Section(f"analysis-{place}", title, joined(parts, "\n")))
        return sections

    def _figure(self, picture: "Picture", names: list[str]) -> Html:
        made = figure(picture, names, self.groups)
        self.pictures += 1
        return made

    def _explorer(self, dataset: "xr.Dataset", name: str) -> Html:
        many = sum(one.attrs["kind"] in explorer.KINDS for one in self.groups.values())
        made = explorer.explorer(dataset, name, self.charts, min(1.0, WHOLE_CHARTS / max(many, 1)))
        self.charts += bool(made)
        return made

    def _try(self, what: str, make: Callable[..., Any], *arguments: Any) -> Any:
        """What ``make`` gives, or that it could not: what is wrong in one place hides nothing else."""
        try:
            return make(*arguments)
        except MemoryError:
            raise
        # an archive that somebody altered may break any expectation, each in its own way
        except Exception as fault:
            told = str(fault) if isinstance(fault, ChaosdrillError) else f"{type(fault).__name__}: {fault}"
            self.faults.append(f"{what}: {told}")
            return element("p", f"This part could not be shown ({self.faults[-1]}).", class_="fault")
