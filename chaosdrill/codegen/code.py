"""Functions that are compiled together: as LLVM code, and as their machine code is kept."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from chaosdrill.codegen.addresses import address
from chaosdrill.codegen.kept import kept_code, key_of, object_code
from chaosdrill.codegen.machine import NativeFunction, load
from chaosdrill.codegen.record import KeptCode


@dataclass(frozen=True)
class Code:
    """LLVM code of functions that are compiled together."""

    names: tuple[str, ...]
    text: str
    imports: tuple[str, ...]
    """Special functions that it calls."""

    def functions(self, signatures: Mapping[str, Any]) -> dict[str, NativeFunction]:
        """Its functions by name, compiled unless cached on disk."""
        return functions(object_code(self.text), self.names, self.imports, signatures)

    def kept(self) -> KeptCode:
        """Where its machine code is kept."""
        return KeptCode(self.names, self.imports, key_of(self.text))


def kept_functions(one: KeptCode, signatures: Mapping[str, Any]) -> dict[str, NativeFunction] | None:
    """Functions whose machine code is kept, by name; None if it is there no more."""
    code = kept_code(one.key)
    return None if code is None else functions(code, one.names, one.imports, signatures)


def functions(
    code: bytes, names: Sequence[str], imports: Sequence[str], signatures: Mapping[str, Any]
) -> dict[str, NativeFunction]:
    """The functions of machine code by name; ``imports`` are special functions that it calls."""
    library = load(code, {name: address(name) for name in imports})
    return {name: NativeFunction(name, signatures[name], library) for name in names}
