"""The pictures of an archive, inside of the page."""

from base64 import b64encode
from io import BytesIO
from typing import TYPE_CHECKING

from chaosdrill.reports.html import Html, element

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import xarray as xr

    from chaosdrill.plot import Picture

MOST_SVG = 500_000
"""Bytes above which a picture is stored as PNG, which does not grow with the number of its points."""


def figure(picture: "Picture", names: "Sequence[str]", groups: "Mapping[str, xr.Dataset]") -> Html:
    """Draw a picture of one group, or of several that belong together.

    Parameters
    ----------
    picture : Picture
    names : sequence of str
        Groups that it shows.
    groups : mapping
        All of the archive, one of which may lie behind.
    """
    from chaosdrill.plot import behind
    from chaosdrill.plot.style import readable, style

    with style():
        import matplotlib as mpl

        # a picture inside of a page has no fonts of its own
        mpl.rcParams["svg.fonttype"] = "path"
        # ids inside of the picture are the same whenever it is drawn
        mpl.rcParams["svg.hashsalt"] = "chaosdrill"
        drawn = picture.draw(*(groups[name] for name in names), over=behind(picture, groups[names[0]], dict(groups)))
        stored, kind = BytesIO(), "svg+xml"
        drawn.savefig(stored, format="svg", metadata={"Date": None})
        if stored.tell() > MOST_SVG:
            stored, kind = BytesIO(), "png"
            drawn.savefig(stored, format="png")
        width, height = drawn.get_size_inches()
        # a function that draws more or less, depending on what there is, says so itself
        summary = str(drawn.get_label()) or picture.summary
        drawn.clear()
    title = readable(picture.name).capitalize()
    of = ", ".join(names)
    return element(
        "figure",
        element(
            "img",
            src=Html(f"data:image/{kind};base64,{b64encode(stored.getvalue()).decode()}"),
            alt=f"{title} of {of}: {summary}. The numbers are in the tables of this page.",
            width=str(round(96 * width)),
            height=str(round(96 * height)),
        ),
        element("figcaption", f"{title} of {of}: {summary}."),
    )
