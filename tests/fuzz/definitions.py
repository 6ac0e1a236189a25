"""Spoilt definitions of systems, as archives hold them: read, written again, and made code of; some of them run."""

import json
from zlib import crc32

import judge
import llvmlite.binding as llvm
import trees
from values import OWNED

from chaosdrill import systems
from chaosdrill.analysis import trajectory
from chaosdrill.codegen.kernels import write
from chaosdrill.errors import ChaosdrillError
from chaosdrill.model.definition import build_defined, write_definition

name, ending = "definition", ".json"
SOUND = ("built",)
RUN_ONE_IN = 200
PATIENCE_S = 6.0


def seeds(folder):
    """The systems of the shelf."""
    built = [systems.build(name) for name in systems.REGISTRY]
    given = [{"definition": write_definition(s), "parameters": s.parameters, "initial": s.initial} for s in built]
    return [trees.written(each, indent=1) for each in given]


def prepare(folder):
    """Have the engine compiled, which no input may start."""
    trajectory(systems.build("lorenz"), duration=0.1)


def attempt(data, folder, guard):
    """Build a system, write its definition and its code."""
    given = json.loads(data)
    parts = (
        [given.get(key) for key in ("definition", "parameters", "initial")] if isinstance(given, dict) else [given] * 3
    )
    with guard.watching():
        try:
            system = build_defined(*(part if isinstance(part, dict) else {} for part in parts))
        except ChaosdrillError as fault:
            return "refused", [] if str(fault).strip() else ["refused without a word"]
        try:
            definition = write_definition(system)
        except ChaosdrillError:
            return "not written", []
        again = write_definition(build_defined(definition, system.parameters, system.initial))
        try:
            codes = [code.text for code in write(system).single]
        except ChaosdrillError:
            return "no code", []
        for code in codes:
            llvm.parse_assembly(code).verify()
    wrong = [] if again == definition else [f"written as {definition}, and then as {again}"]
    if any(OWNED in code for code in codes):
        wrong.append("a word of the definition is in the code")
    if crc32(data) % RUN_ONE_IN == 0:
        wrong += judge.apart(lambda: _run(system, guard), folder, PATIENCE_S, _judged)[1]
    return "built", wrong


def _run(system, guard):
    length = {"duration": 1.0} if system.period is None else {"periods": 1}
    try:
        with guard.watching():
            trajectory(system, **length, samples=2, max_events=50)
    except ChaosdrillError:
        return 2
    return 0


def _judged(code, out, err):
    return [] if code in (0, 2, 130) else [f"exit code {code}: {err[-3000:]}"]


def mutate(data, chance, other):
    """A definition with some of its texts, numbers and keys exchanged."""
    try:
        return trees.written(trees.mutated(json.loads(data), chance, json.loads(other)), indent=1)
    except (RecursionError, ValueError):
        return data
