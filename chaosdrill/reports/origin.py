"""Where the archive came from: every attribute of it, versions, and its hash."""

from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from chaosdrill.files import name_text
from chaosdrill.reports.html import Html, element, joined, table
from chaosdrill.reports.scenes import read_json

if TYPE_CHECKING:
    import xarray as xr

_APART = ("scene", "versions")


def origin_section(tree: "xr.DataTree", path: Path) -> Html:
    """The file, the versions, and the attributes of the root and of every group."""
    file = [("name", name_text(path.name)), ("size in bytes", str(path.stat().st_size)), ("SHA-256", file_hash(path))]
    file.append(("values", _integrity(tree)))
    versions = [(str(name), str(version)) for name, version in read_json(tree.attrs.get("versions")).items()]
    parts = [table("The archive's file", ("what", "value"), file), table("Versions", ("library", "version"), versions)]
    for node in tree.subtree:
        rows = [(str(name), _words(value)) for name, value in node.attrs.items() if name not in _APART]
        caption = "Attributes of the archive" if node.path == "/" else f"Attributes of {node.path.strip('/')}"
        parts.append(table(caption, ("attribute", "value"), rows))
    return joined([element("p", "The numbers of this page are those of this file.", class_="note"), *parts], "\n")


def citations_section(tree: "xr.DataTree") -> Html:
    """What is to be cited for what is in the archive."""
    from chaosdrill.archive.cite import references_in

    entries = (element("li", reference.text()) for reference in references_in(tree))
    return joined(
        [
            element("p", "This package, and the sources of the analyses, methods and systems in the archive."),
            element("ul", *entries),
            element("p", "chaosdrill cite --bibtex prints them for BibTeX.", class_="note"),
        ]
    )


def altered_parts(tree: "xr.DataTree") -> list[str]:
    """Attributes of the archive, and variables and attributes of its groups, that are not as they were written."""
    return [f"{group} {name}".strip() for group, names in _altered(tree).items() for name in names or ()]


def _altered(tree: "xr.DataTree") -> "dict[str, list[str] | None]":
    from chaosdrill.archive.digest import altered

    return {node.path.strip("/"): altered(node.to_dataset(inherit=False)) for node in tree.subtree}


def _integrity(tree: "xr.DataTree") -> str:
    """Whether all groups are as they were written, by the digests that they hold."""
    if changed := altered_parts(tree):
        return f"altered since they were written: {', '.join(changed)}"
    unknown = [g for g, names in _altered(tree).items() if names is None and "kind" in tree[g or "/"].attrs]
    if unknown:
        return f"without digests, so that nobody can tell whether they were altered: {', '.join(unknown)}"
    return "as they were written, by the digests of all variables"


def file_hash(path: Path) -> str:
    """SHA-256 of a file."""
    digest = sha256()
    with path.open("rb") as stream:
        while block := stream.read(2**20):
            digest.update(block)
    return digest.hexdigest()


def _words(value: Any) -> str:
    return str(value.tolist() if hasattr(value, "tolist") else value)
