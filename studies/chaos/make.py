"""How chaotic the drill is: angles, growth over windows, transients, shares of basins, effects of one per cent.

    python studies/chaos/make.py [--docs]          (or: python3 studies/run.py chaos)

The scenes run through the command line, as a user would run them, and go on where an earlier run was cut short; an
archive that is already there is not made again. Pictures and tables are written to ``studies/chaos/out/``, with
``--docs`` to the documentation, too. The exit code is 0 if every claim of the page holds.
"""

import argparse
import shutil
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE.parent / "charts"))  # its independent program, claims and tables

import attractor  # noqa: E402
import drawing  # noqa: E402
import lives  # noqa: E402
import percent  # noqa: E402
import shares  # noqa: E402
import xarray as xr  # noqa: E402
from findings import Claim, read, table  # noqa: E402
from running import chaosdrill, page, say  # noqa: E402

OUT = HERE / "out"
DOCS = HERE.parent.parent / "docs"
SCENES = {
    "attractor": ("vectors", "growth", "dimensions"),
    "stability_load": ("shares",),
    "stability_amplitude": ("shares",),
}
"""Scenes, and the analyses of each that are drawn."""

PICTURES = (
    "attractor-vectors",
    "attractor-growth",
    "attractor-dimensions",
    "escape-rates",
    "stability_load-shares",
    "stability_amplitude-shares",
    "one-per-cent",
)
"""Pictures that the page shows."""


def main() -> int:
    """Run every scene, draw, compare; return the exit code of the first command that fails, else 1 if a claim does."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--docs", action="store_true", help="write the page of the documentation and its pictures, too")
    given = parser.parse_args()
    started = time.monotonic()
    OUT.mkdir(exist_ok=True)
    for scene, groups in SCENES.items():
        say(f"{scene}.toml")
        archive = OUT / f"{scene}.nc"
        if not archive.is_file():
            code = chaosdrill("run", HERE / f"{scene}.toml", "-o", archive, "--resume")
            if code:
                return code
        for group in groups:
            code = chaosdrill("plot", archive, "--group", group, "-o", OUT / f"{scene}-{group}.png")
            if code:
                return code
    parts, claims = findings()
    for name, text in parts.items():
        (OUT / f"{name}.md").write_text(text, encoding="utf-8")
    print(parts["claims"])
    if given.docs:
        (DOCS / "chaos.md").write_text(page(HERE / "page.md", parts), encoding="utf-8")
        for picture in PICTURES:
            shutil.copy(OUT / f"{picture}.png", DOCS / "_static" / f"chaos_{picture.replace('-', '_')}.png")
    say(f"done in {time.monotonic() - started:.0f} s; archives, pictures and tables are in {OUT}")
    return 0 if all(claim.holds for claim in claims) else 1


def findings() -> tuple[dict[str, str], list[Claim]]:
    """Return the tables of the page by name, and all claims; draw what no single analysis shows."""
    archive = OUT / "attractor.nc"
    parts, claims = {}, []
    for name, found in (
        ("angles", attractor.angles(read(archive, "vectors"))),
        ("spectrum", attractor.spectrum(read(archive, "spectrum"))),
        ("separations", attractor.separations(read(archive, "spectrum"))),
        ("dimensions", attractor.dimensions(read(archive, "dimensions"))),
        ("windows", attractor.windows(read(archive, "growth"))),
    ):
        parts[name] = found[0]
        claims += found[1]
    say("how long chaos lasts")
    over_eta, over_b = (line(name) for name in ("eta", "b"))
    claims += lives.claims(over_eta, over_b)
    drawing.escape_rates(over_eta, over_b).savefig(OUT / "escape-rates.png")
    for name, scene in (("load", "stability_load"), ("amplitude", "stability_amplitude")):
        parts[name], more = shares.compare(read(OUT / f"{scene}.nc", "shares"))
        claims += more
    say("one per cent")
    parts["percent"], more, effects = percent.compare()
    claims += more
    drawing.one_per_cent(effects).savefig(OUT / "one-per-cent.png")
    parts["claims"] = table(
        ["claim", "found", "holds"], ([c.text, c.found, "yes" if c.holds else "no"] for c in claims)
    )
    return parts, claims


def line(name: str) -> xr.Dataset:
    """Return the escape rates over one parameter, from the file of an earlier run if there is one."""
    file = OUT / f"lives_{name}.nc"
    if not file.is_file():
        lives.along(name).to_netcdf(file)
    return xr.load_dataset(file)


if __name__ == "__main__":
    sys.exit(main())
