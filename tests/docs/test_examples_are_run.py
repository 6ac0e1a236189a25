"""The check that runs the examples of the documentation fails where an example does."""

import runpy
from pathlib import Path

import pytest

EXECUTED = Path(__file__).parents[2] / "docs" / "_ext" / "executed.py"


@pytest.fixture(scope="module")
def check():
    return runpy.run_path(str(EXECUTED))


@pytest.mark.parametrize(
    "example",
    [
        "```python\nx = 1\nassert x == 2\n```",
        "```python\nx = 1\n```\n\n```sh\nfalse\n```",
        "```sh\npython3 studies/run.py nothing\n```",
        '```toml\n[analysis.orbit]\nkind = "periodic-orbit"\nperiods = 2\n```',
        "    chaosdrill run scene.toml\n",
    ],
)
def test_an_example_that_fails_is_told_with_its_page(check, tmp_path, example):
    page = tmp_path / "page.md"
    page.write_text(f"# A page\n\n{example}\n", encoding="utf-8")
    (fault,) = check["faults_of"](page)
    assert str(page) in fault


def test_examples_share_names_and_files_and_marked_ones_are_left_out(check, tmp_path):
    page = tmp_path / "page.md"
    page.write_text(
        "```python\nnumber = 3\nopen('note.txt', 'w').close()\n```\n\n```sh\n# not run: it would fail\nfalse\n```\n\n"
        "```sh\ntest -f note.txt\n```\n\n```python\nassert number == 3\n```\n",
        encoding="utf-8",
    )
    assert check["faults_of"](page) == []
