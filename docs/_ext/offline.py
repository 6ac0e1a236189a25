"""Pages load nothing from the network, so that a built copy can be read anywhere."""

import re
from pathlib import Path

ADDRESS = r"[\"']?((?:https?:)?//[^\"'\s>)]+)"
LOADS = re.compile(rf"<(?:script|img|iframe|source|video|embed)\b[^>]*\bsrc={ADDRESS}")
LINKS = re.compile(rf"<link\b(?=[^>]*\brel=[\"']?(?:stylesheet|\w*preload|preconnect|icon)\b)[^>]*\bhref={ADDRESS}")
STYLES = re.compile(rf"(?:\burl\(\s*|@import\s+){ADDRESS}")


def addresses(page: str) -> list[str]:
    """Return the addresses in the network from which a page or a style sheet loads something."""
    return [found for pattern in (LOADS, LINKS, STYLES) for found in pattern.findall(page)]


def check_pages(app, exception) -> None:
    """Stop a build in which a page loads something from the network."""
    from sphinx.errors import ExtensionError

    if exception is not None or app.builder.name not in ("html", "dirhtml"):
        return
    found = {
        f"{path.relative_to(app.outdir)}: {address}"
        for path in Path(app.outdir).rglob("*")
        if path.suffix in (".html", ".css")
        for address in addresses(path.read_text(encoding="utf-8"))
    }
    if found:
        raise ExtensionError("pages that load from the network:\n" + "\n".join(sorted(found)))


def setup(app) -> dict[str, bool]:
    """Check once all pages are written."""
    app.connect("build-finished", check_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
