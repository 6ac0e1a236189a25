"""Pages load nothing from the network, so that a built copy can be read anywhere."""

import re
from pathlib import Path

LOADS = re.compile(r"<(?:script|img|iframe|source)\b[^>]*\bsrc=\"((?:https?:)?//[^\"]*)")
STYLES = re.compile(r"<link\b(?=[^>]*\brel=\"(?:stylesheet|preload|icon)\")[^>]*\bhref=\"((?:https?:)?//[^\"]*)")


def addresses(page: str) -> list[str]:
    """Return the addresses in the network from which a page loads something."""
    return [found for pattern in (LOADS, STYLES) for found in pattern.findall(page)]


def check_pages(app, exception) -> None:
    """Stop a build in which a page loads something from the network."""
    from sphinx.errors import ExtensionError

    if exception is not None or app.builder.name not in ("html", "dirhtml"):
        return
    found = {
        f"{path.relative_to(app.outdir)}: {address}"
        for path in Path(app.outdir).rglob("*.html")
        for address in addresses(path.read_text(encoding="utf-8"))
    }
    if found:
        raise ExtensionError("pages that load from the network:\n" + "\n".join(sorted(found)))


def setup(app) -> dict[str, bool]:
    """Check once all pages are written."""
    app.connect("build-finished", check_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
