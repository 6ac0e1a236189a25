"""What studies of scenes share: the command line, what they say on the way, and their page with its tables."""

import subprocess
import sys
import sysconfig
from pathlib import Path

_COMMAND = Path(sysconfig.get_path("scripts")) / "chaosdrill"


def page(template: Path, parts: dict[str, str]) -> str:
    """Return the page of the documentation: the text with its tables."""
    text = template.read_text(encoding="utf-8")
    for name, part in parts.items():
        text = text.replace(f"{{{{{name}}}}}\n", part)
    return text


def chaosdrill(*arguments: object) -> int:
    """Run the command line and return its exit code."""
    return subprocess.call([str(_COMMAND), *map(str, arguments)])


def say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
