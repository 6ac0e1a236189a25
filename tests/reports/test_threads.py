"""Reports and pictures from two threads at once are those made alone, and matplotlib is left as it was."""

import threading
from io import BytesIO

import matplotlib as mpl
from matplotlib import pyplot

import chaosdrill as cd


def _picture(dataset):
    """A picture as a file, whose figure pyplot forgets."""
    figure = cd.plot(dataset).figure
    figure.set_dpi(60)
    stored = BytesIO()
    figure.savefig(stored, format="png")
    pyplot.close(figure)
    return stored.getvalue()


def test_two_threads_make_what_one_makes(written, tmp_path, monkeypatch):
    monkeypatch.setitem(mpl.rcParams, "font.size", 14.0)
    archive, page = written.archive, written.path.read_bytes()
    diagram = cd.open(archive)["diagram"].to_dataset()
    alone, before = _picture(diagram), dict(mpl.rcParams)
    ready, faults = threading.Barrier(2), []

    def make(number):
        ready.wait(60)
        try:
            made = cd.report(archive, tmp_path / f"{number}.html")
            faults.extend(made.faults)
            if made.path.read_bytes() != page:
                faults.append(f"page {number} differs")
            if _picture(diagram) != alone:
                faults.append(f"picture {number} differs")
        except Exception as fault:
            faults.append(repr(fault))

    threads = [threading.Thread(target=make, args=(number,)) for number in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(120)
    assert faults == []
    assert dict(mpl.rcParams) == before
