"""Numbers that tune the engine stand in one file with their reasons, and code is kept by all numbers that it takes."""

import ast
from importlib import import_module

from chaosdrill.codegen import cache
from chaosdrill.engine import tuning
from chaosdrill.package import modules, source

LIMITS = {("scales", "SMALLEST"), ("lane_code", "_FRACTION"), ("lane_code", "_BIAS")}
"""What doubles can hold."""

MODULES = [name for name in modules("engine") if name != "tuning"]


def tree(name: str) -> ast.Module:
    return ast.parse(source(f"chaosdrill.engine.{name}"))


def numbers(node: ast.AST) -> list[float]:
    """The numbers of an expression that is made of nothing else."""
    parts = list(ast.walk(node))
    plain = (ast.Constant, ast.BinOp, ast.UnaryOp, ast.operator, ast.unaryop, ast.Tuple, ast.Load)
    found = [part.value for part in parts if isinstance(part, ast.Constant)]
    whole = all(isinstance(part, plain) for part in parts) and all(type(one) in (int, float) for one in found)
    return found if whole else []


def tunes(node: ast.AST) -> bool:
    """Whether an expression gives a number that may be another one: small whole ones, and tuples of them, are codes."""
    return any(type(one) is float or (one > 20 and not isinstance(node, ast.Tuple)) for one in numbers(node))


def test_a_number_that_tunes_stands_in_the_records():
    told = {
        (name, target.id)
        for name in MODULES
        for node in tree(name).body
        if isinstance(node, ast.Assign) and tunes(node.value)
        for target in ast.walk(node)
        if isinstance(target, ast.Name) and not name.endswith("_tables")
    }
    assert told == LIMITS


def test_every_number_has_its_reason():
    for record in (node for node in tree("tuning").body if isinstance(node, ast.ClassDef)):
        fields = [i for i, node in enumerate(record.body) if isinstance(node, ast.AnnAssign)]
        for i in fields:
            reason = record.body[i + 1]
            assert isinstance(reason, ast.Expr), ast.unparse(record.body[i])
            assert len(ast.literal_eval(reason.value)) > 10
        assert fields


def test_every_number_is_used():
    text = "\n".join(source(f"chaosdrill.engine.{name}").decode() for name in MODULES)
    text += source("chaosdrill.engine.layout").decode()
    for name, record in vars(tuning).items():
        if name.isupper() and hasattr(record, "_fields"):
            assert [field for field in record._fields if f"{name}.{field}" not in text] == []


def test_code_is_kept_by_every_file_that_gives_it_numbers(monkeypatch):
    kept = set()
    monkeypatch.setattr(cache, "source", lambda name: kept.add(name) or b"")
    cache.code_key.__wrapped__()
    needed = set()
    for name in MODULES:
        compiles = b"engine.jit import" in source(f"chaosdrill.engine.{name}")
        for node in tree(name).body if compiles else ():
            if isinstance(node, ast.ImportFrom) and str(node.module).startswith("chaosdrill."):
                home = vars(import_module(node.module))
                given = {type(home[one.name]) for one in node.names if one.name in home}
                needed |= {node.module} if given & {int, float, tuple} else set()
    assert "chaosdrill.codegen.layout" in needed
    assert needed <= kept
