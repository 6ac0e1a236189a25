"""Results for scripts: one JSON document on standard output."""

import json
import math
import sys
from collections.abc import Mapping, Sequence
from typing import Any

from chaosdrill.cli.streams import say


def emit(document: Mapping[str, Any]) -> None:
    """Print a result as JSON, with letters of all alphabets as they are where the output's encoding has them."""
    plain = strict(document)
    text = json.dumps(plain, indent=2, allow_nan=False, ensure_ascii=False)
    try:
        text.encode(sys.stdout.encoding or "utf-8")
    # names of files need not be text
    except UnicodeEncodeError:
        text = json.dumps(plain, indent=2, allow_nan=False)
    say(text)


def emit_error(code: int, kind: str, message: str, problems: Sequence[Mapping[str, Any]] | None = None) -> None:
    """Print a fault as JSON, and of a wrong scene all its problems.

    ``kind`` is ``UsageError``, the name of a class of `chaosdrill.errors`, ``OSError``, ``MemoryError`` or
    ``KeyboardInterrupt``.
    """
    document: dict[str, Any] = {"error": {"exit_code": code, "kind": kind, "message": message.strip()}}
    if problems is not None:
        document = {"valid": False, **document, "problems": problems}
    emit(document)


def strict(value: Any) -> Any:
    """Plain values that every reader of JSON knows: NaN becomes null, infinities the texts ``"inf"`` and ``"-inf"``."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): strict(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [strict(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else str(value)
    return value
