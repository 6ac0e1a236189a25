"""A process that ends at any of its system calls, a write half done, is gone on with to the same result."""

import subprocess
import sys
from pathlib import Path

RUNS = """
import os, shutil, sys
from pathlib import Path
sys.path.insert(0, sys.argv[2])
import numpy as np, xarray as xr
from support.logistic_task import Logistic
from chaosdrill.files import remove_drafts, replacing
from chaosdrill.sweep import Parts, execute

CALLS = [(os, name) for name in ("open", "mkdir", "fsync", "replace", "unlink", "rmdir")] + [(Path, "write_bytes")]
TASK = Logistic(units=12, iterations=3)
folder = Path(sys.argv[1])
target, parts_folder = folder / "out.bin", folder / "out.nc.parts"

def run():
    with Parts(parts_folder, {"analysis": {"one": 1, "many": 2}}, resume=True) as parts:
        remove_drafts(target)
        one = parts.finished("one")
        if one is None:
            one = xr.Dataset({"x": ("t", np.array([0.1, -0.0, np.inf, -np.nan]))})
            parts.keep("one", one)
        many = execute(TASK, store=parts.store("many"))
        with replacing(target) as draft:
            draft.write_bytes(one["x"].values.tobytes() + b"".join(many[name].tobytes() for name in sorted(many)))
        parts.finish()
    return target.read_bytes()

def run_until(call):
    '''Run in a process that ends before its n-th call, or halfway through it if it writes; whether it came so far.'''
    pid = os.fork()
    if pid:
        return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 9
    made = [0]

    def counted(name, plain):
        def made_one(*arguments, **keywords):
            made[0] += 1
            if made[0] == call:
                if name == "write_bytes":
                    path, data = arguments
                    plain(path, data[: len(data) // 2])
                os._exit(9)
            return plain(*arguments, **keywords)
        return made_one

    for place, name in CALLS:
        setattr(place, name, counted(name, getattr(place, name)))
    run()
    os._exit(0)

expected = run()
call = 1
while run_until(call):
    assert run() == expected, call
    assert os.listdir(folder) == ["out.bin"], (call, os.listdir(folder))
    target.unlink()
    call += 1
print(call)
"""


def test_killed_at_every_system_call(tmp_path):
    command = [sys.executable, "-c", RUNS, str(tmp_path), str(Path(__file__).parents[1])]
    done = subprocess.run(command, capture_output=True, text=True, timeout=200)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 60
