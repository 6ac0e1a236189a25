"""The page around its sections, in one file: style and script stand in it, and nothing else may run or be loaded."""

import re
from base64 import b64encode
from dataclasses import dataclass
from hashlib import sha256
from importlib.resources import files
from string import Template

from chaosdrill.errors import ArchiveError
from chaosdrill.reports.html import Html, element, joined, text

_SCRIPTS = ("read.js", "scale.js", "draw.js", "tell.js", "explore.js")

_LEADS_AWAY = re.compile(r"<\s*/?\s*(meta|base|link|iframe|frame|object|embed|form)\b", re.IGNORECASE)
"""Elements that only the frame may hold. No policy of a page keeps browsers from following ``meta`` with a refresh."""


@dataclass(frozen=True)
class Section:
    """A part of the page with an entry among its contents.

    Parameters
    ----------
    key : str
        Its id.
    title : str
        Its heading.
    body : Html
        What is in it.
    """

    key: str
    title: str
    body: Html


def page(title: str, intro: Html, sections: list[Section]) -> str:
    """The whole page.

    Parameters
    ----------
    title : str
        Of the archive.
    intro : Html
        What stands under the title.
    sections : list of Section

    Raises
    ------
    ArchiveError
        If anything but the frame would lead away from the page, or load something.
    """
    import chaosdrill

    style = asset("page.css")
    script = '"use strict";\n(() => {\n' + "\n".join(asset(name) for name in _SCRIPTS) + "})();\n"
    bodies = (
        element(
            "section", element("h2", s.title, id=f"{s.key}-title"), s.body, id=s.key, aria_labelledby=f"{s.key}-title"
        )
        for s in sections
    )
    body = joined(bodies, "\n")
    contents = joined((element("li", element("a", s.title, href=f"#{s.key}")) for s in sections), "\n")
    if found := _LEADS_AWAY.search(f"{intro}{contents}{body}"):
        raise ArchiveError(f"the report would hold an element {found[1]}, which no page may; it is not written")
    return Template(asset("frame.html")).substitute(
        title=text(title, 200),
        intro=intro,
        contents=contents,
        body=body,
        version=chaosdrill.__version__,
        style=style,
        style_hash=_hash(style),
        script=script,
        script_hash=_hash(script),
    )


def asset(name: str) -> str:
    """Text of a file that belongs to the page."""
    return files("chaosdrill.reports").joinpath("assets", name).read_text(encoding="utf-8")


def _hash(content: str) -> str:
    """What a Content-Security-Policy knows a style or a script by."""
    return f"sha256-{b64encode(sha256(content.encode()).digest()).decode()}"
