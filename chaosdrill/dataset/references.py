"""Literature to cite for a result: for its analysis, method and system."""

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

from chaosdrill.declared import ANALYSES, METHODS
from chaosdrill.systems import REGISTRY
from chaosdrill.version import __version__

_PLACES = {"article": "journal", "book": "publisher", "inproceedings": "booktitle"}


@dataclass(frozen=True)
class Reference:
    """One entry of a list of references.

    Parameters
    ----------
    key : str
        Short name, also that of the BibTeX entry.
    authors : str
        Separated by " and ", initials first.
    year : int or None
        Of publication; None if it is not known.
    title : str
        Of the work.
    where : str
        Journal, book with its publisher, or publisher.
    volume : str
        Of a journal.
    pages : str
        First and last.
    doi : str
        Without the resolver's address; empty if it has none.
    entry : {"article", "book", "inproceedings", "software", "misc"}
        Kind of BibTeX entry.
    """

    key: str
    authors: str
    year: int | None
    title: str
    where: str
    volume: str = ""
    pages: str = ""
    doi: str = ""
    entry: str = "article"

    def text(self) -> str:
        """The reference as text.

        Returns
        -------
        str
            One line.
        """
        names = self.authors.split(" and ")
        authors = ", ".join(names[:-1]) + " and " + names[-1] if len(names) > 1 else names[0]
        place = ", ".join(part for part in (f"{self.where} {self.volume}".rstrip(), self.pages) if part)
        parts = [f"{authors} ({self.year})" if self.year else authors, self.title, place]
        line = ". ".join(part for part in parts if part)
        return f"{line}. doi:{self.doi}" if self.doi else f"{line}."

    def bibtex(self) -> str:
        """The reference as a BibTeX entry.

        Returns
        -------
        str
            An entry, of several lines.
        """
        place = _PLACES.get(self.entry, "howpublished")
        authors = " and ".join(_in_bibtex(name) for name in self.authors.split(" and "))
        fields = {"author": authors, "title": f"{{{self.title}}}", place: self.where, "year": self.year}
        fields |= {"volume": self.volume, "pages": self.pages.replace("-", "--"), "doi": self.doi}
        body = ",\n".join(f"  {name} = {{{value}}}" for name, value in fields.items() if value).replace("&", r"\&")
        return f"@{'misc' if self.entry == 'software' else self.entry}{{{self.key},\n{body}\n}}"


def _in_bibtex(name: str) -> str:
    """The name with braces where BibTeX would take part of what follows the initials for a further given name."""
    words = name.split()
    initials = [word for word in words if word.endswith(".")]
    family = " ".join(words[len(initials) :])
    return " ".join([*initials, f"{{{family}}}" if " " in family and family[0].isupper() else family])


def _read(text: str) -> Iterator[Reference]:
    """Entries laid out as `Reference.bibtex` does."""
    for entry, key, body in re.findall(r"^@(\w+){(\w+),\n(.*?)\n}$", text, re.DOTALL | re.MULTILINE):
        fields = {name: _plain(value) for name, value in re.findall(r"^  (\w+) = {(.*)},?$", body, re.MULTILINE)}
        yield Reference(
            key,
            authors=fields.get("author", ""),
            year=int(fields["year"]) if "year" in fields else None,
            title=fields["title"],
            where=fields.get(_PLACES.get(entry, "howpublished"), ""),
            volume=fields.get("volume", ""),
            pages=fields.get("pages", ""),
            doi=fields.get("doi", ""),
            entry=entry,
        )


def _plain(value: str) -> str:
    return re.sub("[{}]", "", value).replace(r"\&", "&").replace("--", "-")


_BIBTEX = files("chaosdrill.dataset").joinpath("references.bib").read_text(encoding="utf-8")

REFERENCES = {reference.key: reference for reference in _read(_BIBTEX)}

SPECTRA = ("benettin1980", "mueller1995", "flyvbjerg1989")
"""Of Lyapunov exponents and their errors."""


def package() -> Reference:
    """How this package is cited."""
    return Reference(
        "chaosdrill",
        "The chaosdrill developers",
        2026,
        "chaosdrill: event-accurate simulation and Lyapunov spectra of hybrid systems",
        f"version {__version__}",
        entry="software",
    )


def references(attributes: Mapping[str, Any], variables: Iterable[str] = ()) -> tuple[Reference, ...]:
    """References for one result, apart from this package.

    ``attributes``: attributes of the dataset: ``kind``, ``method``, ``system`` and ``settings`` (JSON) are looked at;
    what is absent or unknown adds nothing. ``variables``: names of its variables: some methods are used only where
    their results are there.

    Returns: in the order analysis, method, system.
    """
    present = set(variables)
    settings = mapping(attributes.get("settings"))
    kind, method, system = (str(attributes.get(name, "")) for name in ("kind", "method", "system"))
    keys = list(ANALYSES[kind].cites) if kind in ANALYSES else []
    if settings.get("start") == "search":
        keys.append("auerbach1987")
    if "feigenbaum_ratio" in present:
        keys.append("feigenbaum1978")
    if kind in ("periodic-orbit", "continuation") and settings.get("derivatives"):
        keys.append("khan2011")
    if kind in ("bifurcation-diagram", "parameter-chart") and "lyapunov_exponent" not in present:
        keys = [key for key in keys if key not in SPECTRA]
    several = settings.get("methods")
    for name in (method, *(several if isinstance(several, list) else ())):
        keys += METHODS[str(name)].cites if str(name) in METHODS else ()
    keys += REGISTRY[system].cites if system in REGISTRY else ()
    # of a drill only Hunt and Crossley's contact has an exponent and a stiffness
    if system.startswith("percussive-drill") and {"n", "k"} <= mapping(attributes.get("parameters")).keys():
        keys.append("hunt1975")
    return tuple(REFERENCES[key] for key in dict.fromkeys(keys))


def mapping(text: Any) -> dict[str, Any]:
    """The mapping that a JSON text holds; empty if it holds none."""
    try:
        value = json.loads(text)
    except (TypeError, ValueError, RecursionError):
        return {}
    return value if isinstance(value, dict) else {}
