"""The workers of a Dask cluster give the same bits; one that dies is replaced; what is wrong is said."""

import os
import pickle
import signal
import sys
import threading
from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import pytest
from support.logistic_task import Deadly, Faulty, Logistic

from chaosdrill.errors import ChaosdrillError, SettingsError
from chaosdrill.sweep import execute
from chaosdrill.sweep.fingerprint import origin
from chaosdrill.sweep.schedule import run_packed
from chaosdrill.sweep.store import kept_points
from chaosdrill.sweep.tuning import TUNING

dask = pytest.importorskip("dask")
distributed = pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def cluster():
    """Two worker processes on this machine."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", os.pathsep.join([str(Path(__file__).parents[1]), *sys.path]))
        # a chunk may take one worker with it before it is given up
        with (
            dask.config.set({"distributed.scheduler.allowed-failures": 1}),
            distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as local,
        ):
            yield local


def test_a_cluster_changes_no_bit(cluster, whole, same, tmp_path):
    task = Logistic(units=700)
    found = execute(task, scheduler=cluster.scheduler_address, store=tmp_path)
    assert same(found, whole(task))


def test_a_worker_that_is_killed_is_replaced_and_its_chunks_rerun(cluster, whole, same):
    task = Logistic(units=400, pause=0.01)
    pids = [worker.pid for worker in cluster.workers.values()]
    told = []

    def progress(done, total, outcomes):
        told.append(done)
        if len(told) == 6:
            os.kill(pids[0], signal.SIGKILL)

    found = execute(task, scheduler=cluster.scheduler_address, progress=progress)
    assert told[5] < 400
    assert same(found, whole(replace(task, pause=0.0)))


def test_a_chunk_that_kills_its_workers_is_not_tried_for_ever(cluster, tmp_path):
    with pytest.raises(ChaosdrillError, match=r"several workers .* died on the same chunk"):
        execute(Deadly(), scheduler=cluster.scheduler_address, store=tmp_path)
    assert 0 < kept_points(tmp_path)[0] < 500


_NONE, _SILENT = "is not the address of a Dask scheduler", "no Dask scheduler answers"


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("tcp://127.0.0.1:9", _SILENT), ("127.0.0.1:9", _SILENT), ("tcp://nowhere.invalid:9", _SILENT),
        ("nowhere://1", _NONE), ("", _NONE), (8786, _NONE),
    ],
)  # fmt: skip
def test_an_address_without_a_scheduler(task, address, words, monkeypatch):
    monkeypatch.setattr("chaosdrill.sweep.schedule.TUNING", replace(TUNING, answer_s=0.5))
    with pytest.raises(SettingsError, match=words):
        execute(task, scheduler=address)


@pytest.mark.parametrize("address", ["10.0.0.5", "nowhere://1:2"])
def test_no_client_of_an_address_that_is_none(task, address, monkeypatch):
    # it would print a traceback and wait for 20 s when it is collected
    monkeypatch.setattr("distributed.Client", lambda *_, **__: pytest.fail("a client was made"))
    with pytest.raises(SettingsError, match=r"missing port|unknown address scheme"):
        execute(task, scheduler=address)


def test_dask_is_not_installed(task, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(SettingsError, match=r"pip install 'chaosdrill\[dask\]'"):
        execute(task, scheduler="tcp://127.0.0.1:9")


def test_a_worker_with_other_versions_is_refused(task):
    expected = deepcopy(origin())
    expected["versions"]["numba"] = "0.1"
    with pytest.raises(SettingsError, match=r'versions.numba: "0.1" here, .* there'):
        run_packed(pickle.dumps(task), expected, 0, 1)


def test_a_fault_on_a_worker_comes_through(cluster):
    with pytest.raises(ZeroDivisionError, match="unit 200"):
        execute(Faulty(), scheduler=cluster.scheduler_address)


@pytest.mark.usefixtures("interruptible")
def test_an_interruption_ends_soon_and_keeps_what_has_finished(cluster, tmp_path, whole, same):
    task = Logistic(units=2000, pause=0.002)
    timer = threading.Timer(0.3, os.kill, [os.getpid(), signal.SIGINT])

    def progress(done, total, outcomes):
        if done and not timer.ident:
            timer.start()

    with pytest.raises(KeyboardInterrupt):
        execute(task, scheduler=cluster.scheduler_address, store=tmp_path, progress=progress)
    told = []
    found = execute(replace(task, pause=0.0), store=tmp_path, progress=lambda *seen: told.append(seen[0]))
    assert 0 < told[0] < 2000
    assert same(found, whole(replace(task, pause=0.0)))
