"""A directive that shows the first picture of each of some pages, small, as a link to the page, with title and caption.

    ```{thumbnails}
    cascade
    basins
    ```

The pages lie beside the one with the directive. Pictures are those that the build has made of their code, with their
own alternative text and caption; a page without one, as in a build that runs no code, is a title only. Captions have no
formulas, whose scripts only pages with formulas load.
"""

from docutils import nodes
from sphinx.transforms.post_transforms import SphinxPostTransform
from sphinx.util.docutils import SphinxDirective


class Thumbnails(nodes.General, nodes.Element):
    """Stands for the pictures until all pages are read."""


class ThumbnailsDirective(SphinxDirective):
    """Names of pages, one a line."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        """Return what `ShowThumbnails` replaces."""
        folder = self.env.docname.rpartition("/")[0]
        return [Thumbnails(pages=[f"{folder}/{line.strip()}".lstrip("/") for line in self.content if line.strip()])]


class ShowThumbnails(SphinxPostTransform):
    """Puts pictures and titles in the place of their names."""

    default_priority = 5

    def run(self, **_) -> None:
        """Replace every node of the page."""
        for place in list(self.document.findall(Thumbnails)):
            shown = nodes.container(classes=["thumbnails"])
            for page in place["pages"]:
                shown += self.thumbnail(page)
            place.replace_self(shown)

    def thumbnail(self, page: str) -> nodes.container:
        """One picture with its title and caption."""
        address = self.app.builder.get_relative_uri(self.env.docname, page)
        link = nodes.reference("", "", internal=True, refuri=address)
        picture = next(self.env.get_doctree(page).findall(nodes.image), None)
        if picture is not None:
            small = picture.deepcopy()
            small.attributes.update(width="100%", classes=["thumbnail"])
            link += small
        link += nodes.inline("", self.env.titles[page].astext())
        shown = nodes.container("", nodes.paragraph("", "", link))
        figure = picture
        while figure is not None and not isinstance(figure, nodes.figure):
            figure = figure.parent
        if figure is not None:
            shown += [nodes.paragraph("", part.astext(), classes=["caption"]) for part in figure.findall(nodes.caption)]
        return shown


def setup(app) -> dict[str, bool]:
    """Add the directive and its transform."""
    app.add_node(Thumbnails)
    app.add_directive("thumbnails", ThumbnailsDirective)
    app.add_post_transform(ShowThumbnails)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
