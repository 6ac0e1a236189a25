"""The description of the package for an index, where relative links and pictures of README.md lead nowhere.

All else is in pyproject.toml. If that names the address of the source, links become absolute; until then a picture is
its caption, and a link its text.
"""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent

_LINK = re.compile(r"(!?)\[([^\]\[]*)\]\(([^()\s]+)\)")


def description(text, source):
    """The text of README.md for an index.

    Parameters
    ----------
    text : str
    source : str
        Address under which the files of this release are, or empty.
    """

    def put(found):
        picture, words, target = found.groups()
        if re.match(r"[a-z]+:|#", target):
            return found[0]
        if source:
            return f"{picture}[{words}]({source.rstrip('/')}/{target})"
        return f"*{words}.*" if picture else words

    # code stays as it is
    parts = re.split(r"(^```.*?^```$)", text, flags=re.MULTILINE | re.DOTALL)
    return "".join(part if part.startswith("```") else _LINK.sub(put, part) for part in parts)


if __name__ == "__main__":
    from setuptools import setup

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    source = project.get("urls", {}).get("Source", "")
    setup(
        long_description=description((ROOT / "README.md").read_text(encoding="utf-8"), source),
        long_description_content_type="text/markdown",
    )
