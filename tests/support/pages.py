"""A page as a tree of elements, read by Python's own parser."""

from html.parser import HTMLParser

VOID = {"br", "img", "input", "link", "meta"}


class Element:
    """One element with its attributes, its text and what is in it."""

    def __init__(self, tag, attributes=(), parent=None):
        self.tag, self.attributes, self.parent = tag, dict(attributes), parent
        self.children, self.words = [], []

    def all(self, *tags):
        """Elements below this one, in the order of the page."""
        for child in self.children:
            if not tags or child.tag in tags:
                yield child
            yield from child.all(*tags)

    @property
    def text(self):
        """All text in it."""
        return "".join(part if isinstance(part, str) else part.text for part in self.words)


class _Reader(HTMLParser):
    def __init__(self):
        super().__init__()
        self.root = self.here = Element("root")

    def handle_starttag(self, tag, attributes):
        child = Element(tag, attributes, self.here)
        self.here.children.append(child)
        self.here.words.append(child)
        if tag not in VOID:
            self.here = child

    def handle_endtag(self, tag):
        assert self.here.tag == tag, f"</{tag}> ends <{self.here.tag}>"
        self.here = self.here.parent

    def handle_data(self, data):
        self.here.words.append(data)


def read(path):
    """The page's tree; elements must be closed in the order in which they were opened."""
    return parsed(path.read_text(encoding="utf-8"))


def parsed(text):
    """The tree of a page or a part of one."""
    reader = _Reader()
    reader.feed(text)
    reader.close()
    assert reader.here is reader.root
    return reader.root
