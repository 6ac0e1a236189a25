"""Archives that are built to do harm are opened or refused; the study tries thousands of them."""

from pathlib import Path

import pytest

STUDY = Path(__file__).parents[2] / "studies" / "fuzz"


@pytest.mark.filterwarnings("ignore")
def test_a_few_hostile_files(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(STUDY))
    import hostile

    found = hostile.run(tmp_path, files=20, seconds=None, seed=1, keep=tmp_path)
    assert found["wrong"] == []
    assert found["files"] == 20
    assert found["slowest"] < hostile.MOST_S
    # the study is worth nothing where files are not hostile
    assert sum(number for outcome, number in found["outcomes"].items() if outcome.startswith("refused")) > 10
