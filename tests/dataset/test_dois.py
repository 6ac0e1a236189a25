"""DOIs in sources, documentation and the list of references are well formed, and each stands for one work."""

import re
from collections import defaultdict
from pathlib import Path

from chaosdrill.dataset.references import REFERENCES

ROOT = Path(__file__).parents[2]
DOI = re.compile(r"\b10\.\d{4,5}/[^\s`\"'\]]+")
MADE = {"_build", "generated", "jupyter_execute", "out"}
"""Folders of what builds and studies leave."""

PRIMES = (53, 47, 43, 41, 37, 31, 29, 23, 19, 17, 13, 7, 5, 3, 2)


def whole(found: str) -> str:
    """A DOI without the punctuation of the sentence, or the bracket of the link, in which it stands."""
    while found[-1] in ".,;:" or (found[-1] == ")" and found.count(")") > found.count("(")):
        found = found[:-1]
    return found


def mentions():
    """(DOI, text since the one before) of all files but this one; the list of references is read as such."""
    files = [ROOT / "README.md", ROOT / "CITATION.cff"]
    for folder in ("chaosdrill", "docs", "studies", "tests"):
        files += [path for kind in ("py", "md") for path in (ROOT / folder).rglob(f"*.{kind}")]
    for path in files:
        if path.name == Path(__file__).name or MADE & set(path.relative_to(ROOT).parts):
            continue
        text, end = path.read_text(encoding="utf-8"), 0
        for match in DOI.finditer(text):
            yield whole(match[0]), text[max(end, match.start() - 150) : match.start()]
            end = match.end()


def item_digit(issn: str, year: str, number: str) -> str:
    """Check digit of an Elsevier item number, as it was given up to 1990."""
    values = (10 if c == "X" else int(c) for c in issn + year + number)
    return "0123456789X"[sum(a * b for a, b in zip(values, PRIMES, strict=True)) % 11]


def well_formed(doi):
    """Brackets in pairs, and the check digits of books and of Elsevier's items."""
    paired = doi.count("(") == doi.count(")") and doi.count("<") == doi.count(">")
    if isbn := re.fullmatch(r"10\.\d{4}/(?:1\.)?(97[89][-\d]+)", doi):
        digits = [int(c) for c in isbn[1].replace("-", "")]
        return paired and len(digits) == 13 and (sum(digits[::2]) + 3 * sum(digits[1::2])) % 10 == 0
    if doi.startswith("10.1016/") and not doi.startswith("10.1016/j."):
        item = re.fullmatch(r"10\.1016/S?(\d{4})-(\d{3}[\dX])\((\d\d)\)(\d{5})-(\w)", doi)
        return paired and item and (item[3] > "90" or item_digit(item[1] + item[2], item[3], item[4]) == item[5])
    return paired


def test_form():
    dois = {doi for doi, _ in mentions()} | {reference.doi for reference in REFERENCES.values() if reference.doi}
    assert len(dois) > 100
    assert [doi for doi in sorted(dois) if not well_formed(doi)] == []
    # one digit of an item of 1985 is another
    assert well_formed("10.1016/0167-2789(85)90011-9")
    assert not well_formed("10.1016/0167-2789(85)90012-9")


def test_no_doi_has_two_entries():
    dois = [reference.doi for reference in REFERENCES.values() if reference.doi]
    assert len(dois) == len(set(dois))


def test_every_doi_has_one_year():
    years = defaultdict(set)
    for doi, before in mentions():
        years[doi].update(re.findall(r"\b(?:19|20)\d\d\b", before)[-1:])
    for reference in REFERENCES.values():
        years[reference.doi].add(str(reference.year))
    years.pop("")
    assert {doi: found for doi, found in years.items() if len(found) > 1} == {}
    assert sum(len(found) for found in years.values()) > 30
