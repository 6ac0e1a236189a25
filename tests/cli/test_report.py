import json

import numpy as np
import pytest
import xarray as xr

from chaosdrill.archive import save


@pytest.fixture
def archive(tmp_path):
    """A spectrum that says little, from no scene."""
    ds = xr.Dataset(
        {
            "lyapunov_exponent": ("exponent", np.array([0.5, -1.0])),
            "lyapunov_error": ("exponent", np.array([0.01, 0.02])),
        },
        attrs={"kind": "lyapunov-spectrum"},
    )
    return save(xr.DataTree.from_dict({"spectrum": ds}), tmp_path / "result.nc")


def test_prints_the_page_it_wrote(call, archive, tmp_path):
    page = tmp_path / "page.html"
    answer = call("report", archive, "-o", page, "--json")
    assert answer.code == 1
    told = json.loads(answer.out)
    assert told["path"] == str(page)
    assert told["groups"] == ["spectrum"]
    assert told["bytes"] == page.stat().st_size
    # it has no history, of which the picture of convergence is made
    assert [fault.split(":")[0:2] for fault in told["faults"]] == [["spectrum", " convergence"]]
    assert "could not be shown: spectrum: convergence" in answer.err


def test_exit_codes(call, archive, tmp_path):
    assert call("report", tmp_path / "none.nc").code == 1
    assert call("report", archive, "-o", tmp_path / "page.png").code == 2
    assert "a report is a file" in call("report", archive, "-o", "-").err
    assert call("report").code == 2
