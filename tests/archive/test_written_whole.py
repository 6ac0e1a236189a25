"""An archive is written whole or not at all; what is damaged or no result is refused with the reason."""

import os
import random
import shutil
import subprocess
import sys
from hashlib import sha256
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import chaosdrill as cd
from chaosdrill.archive import check_writable, save, writing
from chaosdrill.archive import open as open_archive
from chaosdrill.archive.digest import LENGTH, digests
from chaosdrill.dataset.provenance import FORMAT
from chaosdrill.errors import ArchiveError
from chaosdrill.files import draft_of, remove_drafts
from chaosdrill.plots import plot_archive
from chaosdrill.workflow import compare, info

# A write that fails leaves the earlier archive whole and nothing beside it.


PLACES = [str(folder) for folder in Path(__file__).parents[:2]]
"""Where scripts find what tests share."""


@pytest.fixture
def earlier(tree, tmp_path):
    """An archive that is there already, and its bytes."""
    path = save(tree, tmp_path / "result.nc")
    return path, path.read_bytes()


def unharmed(earlier):
    path, content = earlier
    return path.read_bytes() == content and os.listdir(path.parent) == [path.name]


# the limit on the size of a file fails a write just as a full disk does, after part of it has been written
FULL_DISK = """
import resource, signal, sys
sys.path[:0] = sys.argv[2:]
from conftest import diagram
from chaosdrill.archive import save
from chaosdrill.errors import ArchiveError
from chaosdrill.files import draft_of, remove_drafts
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (40_000, 40_000))
try:
    save(diagram(20_000), sys.argv[1])
except ArchiveError as fault:
    print(fault)
"""


def test_full_disk(earlier):
    # without -B a module that is loaded first would be kept, cut at the bound
    command = [sys.executable, "-B", "-c", FULL_DISK, str(earlier[0]), *PLACES]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    assert "cannot write the archive" in done.stdout
    assert "disk full" in done.stdout
    assert unharmed(earlier)


@pytest.mark.parametrize("fault", [KeyboardInterrupt, MemoryError])
def test_interrupt_while_writing(earlier, tree, monkeypatch, fault):
    def half(self, path, **_):
        Path(path).write_bytes(b"half an archive")
        raise fault

    monkeypatch.setattr(xr.DataTree, "to_netcdf", half)
    with pytest.raises(fault):
        save(tree, earlier[0])
    assert unharmed(earlier)


def test_fault_while_moving_into_place(earlier, tree, monkeypatch):
    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(ArchiveError, match="Permission denied; an earlier file is unchanged"):
        save(tree, earlier[0])
    assert unharmed(earlier)


def test_read_only_folder(earlier, tree):
    folder = earlier[0].parent
    folder.chmod(0o500)
    try:
        if os.access(folder, os.W_OK):
            pytest.skip("this user may write anywhere")
        with pytest.raises(ArchiveError, match="Permission denied"):
            save(tree, earlier[0])
    finally:
        folder.chmod(0o700)
    assert unharmed(earlier)


def test_folder_that_takes_no_files():
    with pytest.raises(ArchiveError, match="cannot write into /proc"):
        check_writable("/proc/result.nc")


def test_target_is_a_folder(tmp_path):
    with pytest.raises(ArchiveError, match="is a folder"):
        check_writable(tmp_path)


def test_folder_that_does_not_exist(tmp_path):
    with pytest.raises(ArchiveError, match="does not exist"):
        check_writable(tmp_path / "none" / "result.nc")


def test_a_new_archive_has_the_usual_permissions(tree, tmp_path):
    (tmp_path / "plain").touch()
    assert save(tree, tmp_path / "result.nc").stat().st_mode == (tmp_path / "plain").stat().st_mode


THREADS = """
import sys
from concurrent.futures import ThreadPoolExecutor
sys.path[:0] = sys.argv[2:]
from conftest import diagram
import chaosdrill as cd

def work(number):
    path = f"{sys.argv[1]}/{number}.nc"
    cd.save(diagram(200), path)
    first = cd.open(path)
    for _ in range(3):
        cd.save(first, path)
        assert cd.open(path).identical(first)
    return number

with ThreadPoolExecutor(6) as pool:
    print(sorted(pool.map(work, range(6))))
"""


def test_threads_may_save_and_open_at_once(tmp_path):
    command = [sys.executable, "-c", THREADS, str(tmp_path), *PLACES]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.strip()) == (0, "[0, 1, 2, 3, 4, 5]"), done.stderr[-2000:]


def test_a_link_is_followed_and_its_target_replaced(tree, tmp_path):
    (tmp_path / "far").mkdir()
    real, link = tmp_path / "far" / "real.nc", tmp_path / "link.nc"
    save(tree, real)
    before = real.stat().st_ino
    link.symlink_to(real)
    save(tree, link)
    assert link.is_symlink()
    assert real.stat().st_ino != before
    assert os.listdir(tmp_path / "far") == ["real.nc"]


@pytest.mark.parametrize("mode", [0o1777, 0o777, 0o755], ids=oct)
@pytest.mark.parametrize("other", [True, False])
def test_a_link_of_another_user_in_a_folder_of_all_is_not_followed(tree, tmp_path, monkeypatch, mode, other):
    real, link, own = tmp_path / "mine" / "real.nc", tmp_path / "all" / "link.nc", tmp_path / "own-link.nc"
    real.parent.mkdir()
    real.write_text("mine")
    own.symlink_to("all/link.nc")
    link.parent.mkdir()
    link.parent.chmod(mode)
    link.symlink_to(real)
    folder = link.with_name("folder")
    folder.symlink_to(real.parent)

    def lstat(path, status=os.lstat):
        found = status(path)
        return os.stat_result((*found[:4], found.st_uid + (other and path in (link, folder)), *found[5:]))

    monkeypatch.setattr(os, "lstat", lstat)
    if other and mode != 0o755:
        for named, write in product((link, own, folder / "real.nc"), (check_writable, lambda path: save(tree, path))):
            with pytest.raises(ArchiveError, match="another user has made the link"):
                write(named)
        assert real.read_text() == "mine"
    else:
        save(tree, own)
        assert real.stat().st_size > len("mine")


def test_what_is_no_ordinary_file_is_not_replaced(tree, tmp_path):
    target = tmp_path / "pipe"
    os.mkfifo(target)
    with pytest.raises(ArchiveError, match="not an ordinary file"):
        save(tree, target)
    assert target.is_fifo()


def dead_draft_of(target):
    """The name of a draft of a process that has ended."""
    script = (
        "import sys; from pathlib import Path; from chaosdrill import files; print(files.draft_of(Path(sys.argv[1])))"
    )
    command = [sys.executable, "-c", script, str(target)]
    return Path(subprocess.run(command, capture_output=True, text=True, check=True).stdout.removesuffix("\n"))


def test_drafts_of_another_target_are_left_alone(tmp_path):
    long = "a" * 90
    one, other = tmp_path / f"{long}1.nc", tmp_path / f"{long}2.nc"
    mine, theirs = dead_draft_of(one), dead_draft_of(other)
    mine.touch()
    theirs.touch()
    remove_drafts(one)
    assert os.listdir(tmp_path) == [theirs.name]


def test_what_a_kill_left_is_removed_by_the_next_save_and_what_is_at_work_stays(tree, tmp_path):
    target = tmp_path / "a.nc"
    dead, alive = dead_draft_of(target), draft_of(target)
    machine = alive.name.split(".")[-2].partition("-")[0]
    elsewhere = tmp_path / dead.name.replace(machine, "0" * 12)
    old = tmp_path / elsewhere.name.replace("0" * 12, "1" * 12)
    again = tmp_path / alive.name.replace(f"-{os.getpid()}-", "-1-")
    for path in (dead, alive, elsewhere, old, again):
        path.touch()
    os.utime(old, (0, 0))
    save(tree, target)
    # process 1 is there, and another one than that which began a draft under its number
    assert {path.name for path in tmp_path.iterdir()} == {"a.nc", alive.name, elsewhere.name}


def test_a_process_that_has_ended_but_keeps_its_number_is_at_no_work(tmp_path):
    target = tmp_path / "a.nc"
    script = "import sys; from pathlib import Path; from chaosdrill import files; print(files.draft_of(Path('a.nc')))"
    with subprocess.Popen([sys.executable, "-c", script], cwd=tmp_path, stdout=subprocess.PIPE, text=True) as ended:
        draft = tmp_path / ended.stdout.read().removesuffix("\n")
        os.waitid(os.P_PID, ended.pid, os.WEXITED | os.WNOWAIT)
        draft.touch()
        remove_drafts(target)
        assert not draft.exists()


def test_a_read_only_archive_is_not_replaced(tree, tmp_path):
    target = save(tree, tmp_path / "a.nc")
    target.chmod(0o444)
    if os.getuid() == 0:
        # root may write anything, and an ordinary user is asked for
        shutil.chown(tmp_path, 65534)
        shutil.chown(target, 65534)
    done = subprocess.run([sys.executable, "-c", READ_ONLY], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "a.nc: is read-only, and will not be replaced" in done.stdout
    assert target.stat().st_mode & 0o777 == 0o444


READ_ONLY = """
import os
from chaosdrill.archive import check_writable
from chaosdrill.errors import ArchiveError
if os.getuid() == 0:
    os.setuid(65534)
try:
    check_writable("a.nc")
except ArchiveError as fault:
    print(fault)
"""


def test_who_may_read_and_write_the_earlier_archive_may_do_so_with_the_new_one(tree, tmp_path):
    target = save(tree, tmp_path / "a.nc")
    target.chmod(0o640)
    assert save(tree, target).stat().st_mode & 0o777 == 0o640


# Ctrl-C, a fork and threads do not leave a lock of the libraries that write held.

INTERRUPTED = """
import os, signal, sys
sys.path[:0] = sys.argv[2:]
from conftest import diagram
import chaosdrill as cd
import chaosdrill.archive.write as write, chaosdrill.files as files, xarray.backends.locks as locks
import xarray.backends.file_manager as manager, xarray.backends.netCDF4_ as netcdf
folder, one = sys.argv[1], diagram(30)
signal.signal(signal.SIGINT, signal.default_int_handler)
FILES = {module.__file__ for module in (write, files, locks, manager, netcdf)}

def save_watched(at):
    # each line of these files tells `at` that it comes, but for what Python forgets faults of
    def watch(frame, event, _):
        if event == "call":
            told = frame.f_code.co_filename in FILES and frame.f_code.co_name != "__del__"
            return watch if told else None
        if event == "line":
            at((frame.f_code.co_filename, frame.f_lineno))
        return watch
    sys.settrace(watch)
    try:
        cd.save(one, f"{folder}/a.nc")
    finally:
        sys.settrace(None)

lines, heard = {}, 0
cd.save(one, f"{folder}/a.nc")
save_watched(lambda line: lines.setdefault(line))
own = [line for line in lines if line[0] in (write.__file__, files.__file__)]
chosen_lines = own + [line for line in lines if line not in own][::5]
for chosen in chosen_lines:
    left = [chosen]

    def interrupt(line):
        if line in left:
            left.remove(line)
            signal.raise_signal(signal.SIGINT)

    signal.alarm(60)
    try:
        save_watched(interrupt)
    except KeyboardInterrupt:
        heard += 1
    assert left or os.listdir(folder) == ["a.nc"], (chosen, os.listdir(folder))
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
signal.alarm(0)
cd.save(one, f"{folder}/a.nc")
assert cd.open(f"{folder}/a.nc").to_dataset().identical(one.assign_attrs(cd.open(f"{folder}/a.nc").attrs))
print(len(chosen_lines), heard)
"""


def test_interrupts_wait_while_an_archive_is_written(tmp_path):
    """At any line of what writes, Ctrl-C leaves no lock held and no draft; a clock would choose lines by the load."""
    command = [sys.executable, "-c", INTERRUPTED, str(tmp_path), *PLACES]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    lines, heard = map(int, done.stdout.split())
    assert heard == lines > 100


FORKED = """
import os, signal, sys, threading
sys.path[:0] = sys.argv[2:]
from conftest import diagram
import chaosdrill as cd
folder, one = sys.argv[1], diagram(3000)
cd.save(one, f"{folder}/a.nc")
done = threading.Event()

def work():
    while not done.is_set():
        cd.save(one, f"{folder}/b.nc")

thread = threading.Thread(target=work)
thread.start()
codes = []
for _ in range(8):
    child = os.fork()
    if child == 0:
        signal.alarm(60)
        cd.open(f"{folder}/a.nc")
        cd.save(one, f"{folder}/c.nc")
        os._exit(0)
    codes.append(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
done.set()
thread.join()
print(codes)
"""


def test_a_process_forked_while_another_thread_saves_can_open_and_save(tmp_path):
    command = [sys.executable, "-W", "ignore", "-c", FORKED, str(tmp_path), *PLACES]
    done = subprocess.run(command, capture_output=True, text=True, timeout=540, check=False)
    assert done.stdout.strip() == str([0] * 8), done.stderr[-2000:]


# What cannot be opened is refused with the reason, whatever has happened to it.


def refusal(path):
    with pytest.raises(ArchiveError) as caught:
        open_archive(path)
    return str(caught.value)


def test_missing(tmp_path):
    assert "No such file" in refusal(tmp_path / "none.nc")


def test_folder(tmp_path):
    assert "directory" in refusal(tmp_path)


def test_empty(tmp_path):
    (tmp_path / "a.nc").touch()
    assert "is empty" in refusal(tmp_path / "a.nc")


def test_text(tmp_path):
    (tmp_path / "a.nc").write_text("time,state\n0,1\n")
    assert "not a NetCDF-4 file" in refusal(tmp_path / "a.nc")


def test_classic_netcdf(tmp_path):
    (tmp_path / "a.nc").write_bytes(b"CDF\x01" + bytes(100))
    assert "not a NetCDF-4 file" in refusal(tmp_path / "a.nc")


def test_somebody_elses(tmp_path):
    xr.Dataset({"x": ("t", [1.0])}).to_netcdf(tmp_path / "a.nc", engine="netcdf4")
    assert "not an archive of chaosdrill" in refusal(tmp_path / "a.nc")


@pytest.mark.parametrize("share", [0.01, 0.3, 0.6, 0.9, 0.999])
def test_truncated(tree, tmp_path, share):
    path = save(tree, tmp_path / "a.nc")
    content = path.read_bytes()[:-LENGTH]
    path.write_bytes(content[: int(share * len(content))])
    told = refusal(path)
    assert "truncated or damaged" in told
    assert told.endswith("; copy or download it once more, or compute it again")


def test_altered_bytes_raise_nothing_else(tree, tmp_path):
    path = save(tree, tmp_path / "a.nc")
    content = path.read_bytes()
    chance = random.Random(1)
    refused = 0
    for _ in range(8):
        altered = bytearray(content)
        for _ in range(20):
            altered[chance.randrange(len(altered))] = chance.randrange(256)
        path.write_bytes(altered)
        try:
            info(path)
        except ArchiveError:
            refused += 1
    assert refused > 0


def test_without_its_last_line_it_is_whole(tree, tmp_path):
    path = save(tree, tmp_path / "a.nc")
    path.write_bytes(path.read_bytes()[:-1])
    assert compare(open_archive(path), tree) == []


def test_the_last_line_is_the_digest_of_the_rest(tree, tmp_path):
    content = save(tree, tmp_path / "a.nc").read_bytes()
    assert content[-LENGTH:].split() == [b"chaosdrill", b"sha256", sha256(content[:-LENGTH]).hexdigest().encode()]


def test_of_a_later_format(tree, tmp_path):
    tree.attrs |= {"format_version": FORMAT + 1, "versions": '{"chaosdrill": "9.1.0"}'}
    message = refusal(save(tree, tmp_path / "a.nc"))
    assert f"format {FORMAT + 1}" in message
    assert "install" in message
    assert "9.1.0" in message


def test_of_the_first_format(tree, tmp_path):
    """Without number, digests and last line, and with texts under the names of their dimensions."""
    tree.to_netcdf(tmp_path / "a.nc", engine="netcdf4")
    with pytest.warns(UserWarning, match="a.nc: not sealed: /first, /second have no digests"):
        assert compare(open_archive(tmp_path / "a.nc"), tree) == []


# What is not the result of an analysis is refused when it is saved, cut or joined, not when it is read.


@pytest.fixture(scope="module")
def motion():
    return cd.trajectory(cd.build("impact-oscillator"), periods=3, samples=10)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (None, "expected an xarray.DataTree or an xarray.Dataset, received NoneType None"),
        ([1.0, 2.0], r"received list \[1.0, 2.0\]"),
        (xr.DataArray([1.0]), "received DataArray"),
        (xr.Dataset({"a": ("t", [1.0])}), "holds a, and no result of an analysis"),
        (xr.DataTree.from_dict({"g": xr.Dataset({"b": ("t", [1.0])})}), "holds b, and no result of an analysis"),
        (xr.Dataset(), "holds nothing, and no result"),
    ],
    ids=["None", "list", "array", "dataset", "tree", "empty"],
)
def test_save(given, message, tmp_path):
    with pytest.raises(ArchiveError, match=f"^tree: .*{message}"):
        cd.save(given, tmp_path / "a.nc")
    assert list(tmp_path.iterdir()) == []


def test_other_data_beside_a_result_are_saved(motion, tmp_path):
    tree = xr.DataTree.from_dict({"motion": motion, "mine": xr.Dataset({"a": ("t", [1.0])})})
    assert float(cd.open(cd.save(tree, tmp_path / "a.nc"))["mine/a"][0]) == 1.0


@pytest.mark.parametrize("runs", [None, [], {}, 3, "both"], ids=repr)
def test_join_of_what_names_no_trajectories(runs):
    with pytest.raises(ArchiveError, match=r"^runs is .*; it must be a mapping of names to trajectories"):
        cd.join(runs)


def test_join_of_a_list(motion):
    with pytest.raises(ArchiveError, match=r'^runs is a list; .* as in join\(\{"soft": one, "hard": another\}\)'):
        cd.join([motion, motion])


@pytest.mark.parametrize("wrong", [None, "a.nc", np.zeros(3)], ids=["None", "text", "array"])
def test_what_is_no_dataset(motion, wrong):
    with pytest.raises(ArchiveError, match=r"^runs\['b'\] is .*; it must be the xarray.Dataset of a trajectory"):
        cd.join({"a": motion, "b": wrong})
    with pytest.raises(ArchiveError, match=r"^ds is .*; it must be the xarray.Dataset of a trajectory"):
        cd.cut(wrong, 0.0, 1.0)


def test_a_node_of_a_tree_is_answered_with_the_way_to_its_dataset(motion):
    with pytest.raises(ArchiveError, match=r"to_dataset\(\)"):
        cd.cut(xr.DataTree(motion), 0.0, 1.0)


@pytest.mark.parametrize(("start", "stop", "name"), [("a", "b", "start"), (0.0, None, "stop"), (np.nan, 1.0, "start")])
def test_cut_at_what_is_no_time(motion, start, stop, name):
    with pytest.raises(ArchiveError, match=f"^{name} is .*; it must be a number"):
        cd.cut(motion, start, stop)


def test_join_of_what_is_joined_already(motion):
    joined = cd.join({"a": motion, "b": motion})
    with pytest.raises(ArchiveError, match="is already joined; join all runs at once"):
        cd.join({"both": joined, "again": joined})


def test_cut_of_joined_runs_counts_the_events_that_are_left():
    system = cd.build("impact-oscillator")
    runs = {str(x): cd.trajectory(system.with_initial(x=x), periods=12, samples=10) for x in (-0.4, 0.2)}
    both = cd.cut(cd.join(runs), 5.0, 20.0)
    apart = [cd.cut(run, 5.0, 20.0).sizes["event"] for run in runs.values()]
    assert both["event_count"].values.tolist() == apart
    assert sum(apart) == both.sizes["event"] > 0


@pytest.mark.parametrize(("name", "way"), [("foo.csv", "to_csv"), ("foo.XLSX", "to_excel"), ("foo.html", "report")])
def test_a_name_of_another_format_is_refused_with_the_way_to_it(tree, tmp_path, name, way):
    with pytest.raises(ArchiveError, match=rf"archives are NetCDF.*foo\.nc, .*{way}"):
        save(tree, tmp_path / name)
    assert not os.listdir(tmp_path)
    for kept in ("foo.nc", "foo", "foo.nc4", "run.2"):
        assert save(tree, tmp_path / kept).is_file()


# A name that was made here, as that of a picture beside its archive, follows no link; one that the user gave does.


def test_a_name_that_the_user_did_not_give_follows_no_link(tmp_path):
    victim, link = tmp_path / "victim.txt", tmp_path / "a.png"
    victim.write_text("of somebody else")
    link.symlink_to(victim)
    check_writable(link, ".png")
    with pytest.raises(ArchiveError, match=r"a\.png: is a link to .*victim\.txt, which you have not named; .*-o"):
        check_writable(link, ".png", named=False)
    with writing(link, "picture", named=False) as draft:
        draft.write_text("a picture")
    assert victim.read_text() == "of somebody else"
    assert not link.is_symlink()


@pytest.mark.parametrize("command", [["report"], ["plot"]])
def test_a_default_name_is_not_that_of_another_file(motion, tmp_path, command):
    path = cd.save(motion, tmp_path / "a.nc")
    victim = tmp_path / "victim.txt"
    victim.write_text("of somebody else")
    for name in ("a.html", "a.png", "a-trajectory.png", "a-phase-portrait.png", "a-time-history.png"):
        (tmp_path / name).symlink_to(victim)
    with pytest.raises(ArchiveError, match="which you have not named"):
        cd.report(path) if command == ["report"] else plot_archive(path)
    assert victim.read_text() == "of somebody else"


def test_digests_do_not_depend_on_how_values_are_printed(tree, monkeypatch):
    """To print is slow, and imports: a process that was forked meanwhile waited for the end of that import."""
    before = digests(tree["first"].to_dataset())
    monkeypatch.setattr(xr.Variable, "__repr__", lambda _: pytest.fail("printed"))
    assert digests(tree["first"].to_dataset()) == before


INTERRUPTED_EARLY = """
import os, signal
from types import SimpleNamespace
from chaosdrill.declared import Declared

declared, done = Declared(), []

def complete():
    if not done:
        done.append(1)
        raise OSError("too many open files")
    os.kill(os.getpid(), signal.SIGINT)
    declared.enter("a", 1)
    return ["a"]

declared.completed_by(complete)
for expected in (OSError, KeyboardInterrupt):
    try:
        list(declared)
    except expected:
        print("heard")
print(list(declared))
"""


def test_what_interrupts_the_import_of_the_analyses_leaves_none_out():
    """Ctrl-C waits for it, and what fails once is tried again."""
    command = [sys.executable, "-c", INTERRUPTED_EARLY]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.stdout.split("\n") == ["heard", "heard", "['a']", ""], done.stderr[-2000:]


FORKED_EARLY = """
import os, signal, threading, time
from types import SimpleNamespace
from chaosdrill.dataset import schema
from chaosdrill.declared import Declared

begun = threading.Event()
schema.ANALYSES = declared = Declared()

def complete():
    begun.set()
    time.sleep(0.3)
    declared.enter("a", SimpleNamespace(variables=()))
    return ["a"]

declared.completed_by(complete)
thread = threading.Thread(target=schema.SCHEMA.get, args=("a",))
thread.start()
begun.wait()
child = os.fork()
if child == 0:
    signal.alarm(20)
    os._exit(0 if schema.SCHEMA.get("a") == {} else 1)
print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
thread.join()
"""


def test_a_process_forked_while_another_thread_looks_up_the_analyses(tmp_path):
    command = [sys.executable, "-W", "ignore", "-c", FORKED_EARLY]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.stdout.strip() == "0", done.stderr[-2000:]
