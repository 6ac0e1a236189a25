"""Compiled code is kept by content, where nobody else can write, and whole; threads share it."""

import errno
import itertools
import os
import pickle
import subprocess
import sys
import tempfile
import threading
from pathlib import Path
from pwd import struct_passwd
from types import SimpleNamespace

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.codegen import cache, kept, kernels_of, machine
from chaosdrill.codegen.kernels import write
from chaosdrill.engine import ahead

X, K = sympy.symbols("x k", real=True)


# Compiled code is kept by content, in a folder that the user can name, or in a temporary one.


def decay(rate=K, name="decay", k=1.0):
    return cd.HybridSystem(name=name, states=(X,), parameters={"k": k}, modes={"on": {X: -rate * X}})


def text_of(system):
    return [code.text for code in write(system).single]


def keep(system):
    """Compile the code of a system's field and guards, and give the file in which it is kept."""
    code = write(system).single[-1]
    compiled = kept.object_code(code.text)
    (path,) = [p for p in cache.cache_folder().rglob("*.code") if kept.read(p) == compiled]
    return path


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A cache of the test's own, forgotten afterwards."""
    monkeypatch.setenv("CHAOSDRILL_CACHE_DIR", str(tmp_path / "cache"))
    cache.cache_folder.cache_clear()
    yield tmp_path / "cache"
    cache.cache_folder.cache_clear()


def test_the_named_folder_is_used(folder):
    assert keep(decay()).parent == folder / "kernels"


def test_the_path_changes_with_the_content(folder):
    first = keep(decay())
    assert keep(decay(rate=2 * K)) != first
    assert keep(decay()) == first


def test_numbers_are_no_part_of_the_content(folder):
    assert keep(decay(k=1.0)) == keep(decay(k=2.5))


def test_the_path_changes_with_the_processor(folder, monkeypatch):
    first = keep(decay())
    monkeypatch.setattr(kept, "processor", lambda: ("another", ""))
    code = write(decay()).single[-1]
    kept.object_code(code.text)
    assert {first} < set(first.parent.iterdir())


def test_nothing_is_left_beside_the_file(folder):
    path = keep(decay())
    assert list(path.parent.iterdir()) == [path]


def test_code_that_is_there_is_not_compiled_again(folder, monkeypatch):
    path = keep(decay())

    def never(*given, **more):
        raise AssertionError("compiled")

    monkeypatch.setattr(machine, "compile_object", never)
    assert keep(decay()) == path


def test_the_user_cache_is_the_default(tmp_path, monkeypatch):
    monkeypatch.delenv("CHAOSDRILL_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    cache.cache_folder.cache_clear()
    try:
        assert cache.cache_folder() == tmp_path / "chaosdrill"
    finally:
        cache.cache_folder.cache_clear()


@pytest.mark.parametrize("home", ["", None, "not/absolute"])
def test_without_a_home_in_the_environment_it_is_that_of_the_user(tmp_path, monkeypatch, home):
    monkeypatch.delenv("CHAOSDRILL_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", "not/absolute")
    monkeypatch.delenv("HOME") if home is None else monkeypatch.setenv("HOME", home)
    monkeypatch.setattr(cache, "getpwuid", lambda number: struct_passwd(("me", "", number, 0, "", str(tmp_path), "")))
    assert cache.lasting_folder() == tmp_path / ".cache" / "chaosdrill"

    def unknown(number):
        raise KeyError(number)

    monkeypatch.setattr(cache, "getpwuid", unknown)
    assert cache.lasting_folder() is None


@pytest.mark.parametrize("broken", ["a file", "below a file"])
def test_a_folder_that_cannot_be_made_falls_back(tmp_path, monkeypatch, broken):
    blocker = tmp_path / "blocker"
    blocker.write_text("not a folder")
    target = blocker if broken == "a file" else blocker / "cache"
    monkeypatch.setenv("CHAOSDRILL_CACHE_DIR", str(target))
    cache.cache_folder.cache_clear()
    try:
        fallen = cache.cache_folder()
        assert fallen.name.startswith("chaosdrill-")
        assert keep(decay()).is_relative_to(fallen)
        assert blocker.read_text() == "not a folder"
    finally:
        cache.cache_folder.cache_clear()


SCRIPT = """
import sympy, chaosdrill as cd
from chaosdrill.codegen import kernels_of
x, k = sympy.symbols("x k", real=True)
system = cd.HybridSystem(name="decay", states=(x,), parameters={"k": 1.0}, modes={"on": {x: -k * x}})
assert kernels_of(system).functions
from chaosdrill.codegen.cache import cache_folder
print(cache_folder(), len(list(cache_folder().glob("kernels/*.code"))), sep="\\n")
"""


@pytest.mark.parametrize("home", ["cache", "blocker/cache"])
def test_a_fresh_process_compiles_with_and_without_a_cache(tmp_path, home):
    (tmp_path / "blocker").write_text("")
    environment = {**os.environ, "CHAOSDRILL_CACHE_DIR": str(tmp_path / home), "TMPDIR": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True, check=True)
    folder, count = done.stdout.split()
    used, lasts = Path(folder), home == "cache"
    assert used == tmp_path / "cache" if lasts else used.parent == tmp_path
    assert int(count) == 2
    assert used.exists() == lasts


def test_the_name_of_a_system_is_no_code(folder, tmp_path):
    harm = tmp_path / "harm"
    system = decay(name=f'"""; open({str(harm)!r}, "w").close() #')
    assert kernels_of(system).functions
    assert not harm.exists()
    assert text_of(system) == text_of(decay(name="decay"))


def test_what_compiles_ahead_imports_nothing_from_the_working_directory(folder, tmp_path, monkeypatch):
    harm = tmp_path / "harm"
    (tmp_path / "llvmlite.py").write_text(f"open({str(harm)!r}, 'w').close()")
    started = []
    with monkeypatch.context() as patched:
        patched.setattr(subprocess, "Popen", lambda command, **how: started.append((command, how["env"])))
        patched.setattr(os, "cpu_count", lambda: 2)
        patched.setattr(ahead, "lasting_folder", lambda: tmp_path)
        patched.setattr(ahead, "_started", {})
        patched.setattr(ahead, "engine_path", lambda part, function: tmp_path / "none")
        ahead.compile_ahead("chaosdrill.engine.no_such_part")
    ((command, environment),) = started
    interpreter = command[: command.index("-c")]
    subprocess.run([*interpreter, "-c", "import llvmlite"], cwd=tmp_path, env=environment, check=True)
    assert not harm.exists()


@pytest.fixture
def turns():
    end = ahead._turns.__wrapped__()
    yield end
    os.close(end)


def test_what_is_called_seldom_is_compiled_as_long_as_a_part_is(monkeypatch, turns):
    done = []
    process = SimpleNamespace(poll=lambda: 0 if len(done) >= 2 else None)
    monkeypatch.setattr(ahead, "_started", {ahead.ONE_RUN: process})
    monkeypatch.setattr(ahead, "_turns", lambda: turns)
    monkeypatch.setattr(ahead.Unit, "compile", lambda one: done.append(one))
    ahead.await_part(ahead.ONE_RUN)
    assert len(done) == 2


def test_processes_share_what_is_called_seldom(monkeypatch, turns):
    done = []
    monkeypatch.setattr(ahead.Unit, "compile", lambda one: done.append(one.symbol))
    ahead._take_turns(turns, lambda: len(done) < 3)
    ahead._take_turns(turns, lambda: True)
    assert done[0].endswith("settled")
    assert len(done) == len(set(done)) > 3


DAMAGES = {
    "emptied": lambda held: b"",
    "cut": lambda held: held[: len(held) // 2],
    "zeroed": lambda held: bytes(len(held)),
    "one bit": lambda held: held[:-9] + bytes([held[-9] ^ 1]) + held[-8:],
    "text": lambda held: b"no code",
}

ENDS = """
import os, sys, warnings, sympy, chaosdrill as cd
from chaosdrill.codegen import kernels_of
os.cpu_count = lambda: 1  # the engine is not wanted, so that no process begins to compile it
warnings.simplefilter("always")
x, k = sympy.symbols("x k", real=True)
for rate in (1, 2, 3, 4, 5):
    modes = {"on": {x: -rate * k * x}}
    system = cd.HybridSystem(name="decay", states=(x,), parameters={"k": 1.0}, modes=modes, initial={x: 1.0})
    kernels_of(system)
    print(len(kernels_of(system).functions))
"""


def test_damaged_code_is_noticed_and_compiled_anew(tmp_path):
    environment = {**os.environ, "CHAOSDRILL_CACHE_DIR": str(tmp_path)}

    def run():
        return subprocess.run([sys.executable, "-c", ENDS], env=environment, capture_output=True, text=True, check=True)

    first = run()
    files = sorted(tmp_path.glob("kernels/*.code"))
    assert len(files) >= 5
    assert "damaged" not in first.stderr
    for path, damage in zip(files, itertools.cycle(DAMAGES.values())):
        path.write_bytes(damage(path.read_bytes()))
    again = run()
    assert again.stdout == first.stdout
    assert all(again.stderr.count(f"{path} is damaged") == 1 for path in files)
    assert sorted(tmp_path.glob("kernels/*.code")) == files
    assert "damaged" not in run().stderr


def test_a_full_disk_costs_the_keeping_alone(folder, monkeypatch):
    whole = tempfile.mkstemp

    def full(*given, dir=None, **more):
        if dir is not None and Path(dir).is_relative_to(folder):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return whole(*given, dir=dir, **more)

    monkeypatch.setattr(tempfile, "mkstemp", full)
    system = decay(rate=K / 3)
    run = cd.trajectory(system.with_initial(x=1.0), duration=3.0)
    assert float(run["states"].values[-1, 0]) == pytest.approx(2.718281828459045**-1, rel=1e-11)
    assert not list(folder.rglob("*.code"))


@pytest.mark.parametrize("place", ["", "kernels", "engine", ".."])
@pytest.mark.parametrize("mode", [0o777, 0o770, 0o722])
def test_a_folder_that_others_can_write_is_not_used(folder, place, mode, monkeypatch):
    for name in ("kernels", "engine"):
        (folder / name).mkdir(parents=True)
    if place == "..":
        # a group of the user's own, in which nobody else is, is no others
        monkeypatch.setattr(cache, "_is_own_group", lambda number: False)
    (folder / place).chmod(mode)
    with pytest.warns(UserWarning, match="others can write into"):
        path = keep(decay())
    assert not path.is_relative_to(folder)
    assert list((folder / "kernels").iterdir()) == []


def test_a_folder_around_it_in_which_only_owners_move_things_is_as_good(folder):
    """As /tmp, and one of a group of the user's own."""
    folder.mkdir(parents=True)
    folder.parent.chmod(0o1777)
    assert keep(decay()).is_relative_to(folder)


def test_a_folder_around_it_of_another_user_is_not_used(folder, monkeypatch):
    folder.mkdir(parents=True)
    monkeypatch.setattr(cache, "is_trusted", lambda owner: False)
    with pytest.warns(UserWarning, match="in which it lies, belongs to another user"):
        assert not cache.cache_folder().is_relative_to(folder)


@pytest.mark.parametrize("way", ["link", "mode", "group", "owner"])
def test_code_that_another_user_may_have_written_is_not_used(folder, tmp_path, monkeypatch, way):
    path = keep(decay())
    content = kept.read(path)
    if way == "link":
        path.rename(tmp_path / "other.code")
        path.symlink_to(tmp_path / "other.code")
        assert kept.read(path) is None
        return
    if way == "mode":
        path.chmod(0o666)
    elif way == "group":
        path.chmod(0o660)
        monkeypatch.setattr(cache, "_is_own_group", lambda number: False)
    elif os.getuid() == 0:
        os.chown(path, 65534, 65534)
    else:
        monkeypatch.setattr(cache, "is_trusted", lambda owner: False)
    with pytest.warns(UserWarning, match="belongs to another user, or others can write it; it is compiled anew"):
        assert kept.read(path) is None
    if way in ("mode", "group"):
        path.chmod(0o600)
        assert kept.read(path) == content


def test_a_folder_that_only_the_user_can_enter_is_used_whatever_is_open_in_it(folder):
    (folder / "kernels").mkdir(parents=True)
    folder.chmod(0o700)
    (folder / "kernels").chmod(0o777)
    assert keep(decay()).parent == folder / "kernels"


WRITTEN = """
import hashlib, chaosdrill as cd
from chaosdrill.codegen.kernels import write
written = write(cd.drill().placed)
text = "".join(code.text for code in (*written.single, written.lanes()))
told = hashlib.sha256(text.encode()).hexdigest()
"""


def test_the_code_is_the_same_in_every_process():
    """Nothing in it follows the order of a set, which another process has otherwise, or the integers of gmpy2."""
    here = {}
    exec(WRITTEN, here)
    environment = {**os.environ, "PYTHONHASHSEED": "2" if os.environ.get("PYTHONHASHSEED") == "1" else "1"}
    environment |= {"SYMPY_GROUND_TYPES": "python", "MPMATH_NOGMPY": "1"}
    done = subprocess.run(
        [sys.executable, "-c", WRITTEN + "print(told)"], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout == here["told"] + "\n"


def test_code_that_nobody_uses_goes(tmp_path, monkeypatch):
    monkeypatch.setattr(cache, "_swept", set())
    used, old, new = (tmp_path / f"{name}{kept.SUFFIX}" for name in ("used", "old", "new"))
    for path in (used, old):
        kept.keep(path, path.stem.encode())
        os.utime(path, (0, 0))
    (tmp_path / "mine.txt").touch()
    os.utime(tmp_path / "mine.txt", (0, 0))
    assert kept.read(used) == b"used"
    monkeypatch.setattr(cache, "_swept", set())
    # what another process has removed since is no fault
    found = Path.glob
    monkeypatch.setattr(Path, "glob", lambda folder, pattern: [tmp_path / "gone.code", *found(folder, pattern)])
    kept.keep(new, b"new")
    assert (kept.read(used), kept.read(old)) == (b"used", None)
    assert (tmp_path / "mine.txt").exists()
    assert kept.read(new) == b"new"


def test_the_engine_lies_beside_the_package_or_in_the_folder_of_the_user(folder, monkeypatch):
    part, beside = "chaosdrill.engine.flow", Path(cache.__file__).parent.parent / "engine" / "__pycache__"
    assert kept.engine_path(part, "flow").parent == beside
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    assert kept.engine_path(part, "flow").parent == folder / "engine"


def test_the_path_of_the_engine_changes_with_its_code_and_the_processor(monkeypatch):
    part = "chaosdrill.engine.flow"
    paths = {kept.engine_path(part, "flow")}
    monkeypatch.setattr(kept, "code_key", lambda: "another")
    paths.add(kept.engine_path(part, "flow"))
    monkeypatch.setattr(kept, "processor", lambda: ("another", ""))
    paths.add(kept.engine_path(part, "flow"))
    assert len(paths) == 3


def test_code_of_the_engine_that_is_kept_is_not_compiled_again(folder, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    assert kept.engine_code("chaosdrill.engine.flow", "one", lambda: b"code") == b"code"
    assert kept.engine_code("chaosdrill.engine.flow", "one", lambda: b"other") == b"code"


# Several threads that ask for the kernels of one system at once get them, whole.


def test_kernels_that_several_threads_ask_for_at_once():
    system = cd.build("impact-oscillator")
    # copies that were sent one by one share nothing but the files of compiled code
    copies = [pickle.loads(pickle.dumps(system)) for _ in range(4)]
    barrier, found = threading.Barrier(len(copies)), []

    def ask(copy):
        barrier.wait()
        kernels, rates = kernels_of(copy), np.empty(2)
        kernels.functions.field(0, 0.3, kernels.constants(copy.parameters), np.array([0.1, 0.7]), rates)
        found.append((tuple(rates), len(kernels.lanes)))

    threads = [threading.Thread(target=ask, args=(copy,)) for copy in copies]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == len(copies)
    assert len(set(found)) == 1
