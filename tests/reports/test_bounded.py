"""A chart in a page has a bounded size, and says what was left out of it."""

import base64

import numpy as np
from support.archives import chart, diagram

from chaosdrill.reports.charts import GRID_BYTES, SECTION_BYTES, explorer_data


def test_small_ones_are_whole():
    data, left_out = explorer_data(diagram())
    assert left_out == []
    section = np.frombuffer(base64.b64decode(data["section"]["values"]), dtype="<f4").reshape(11, 1, 8, 2)
    np.testing.assert_array_equal(section, diagram()["section"].values.astype("f4"))
    exponents = next(q for q in data["quantities"] if q["name"] == "lyapunov_exponent")
    held = np.frombuffer(base64.b64decode(exponents["values"]), dtype="<f4").reshape(11, 1, 2)
    np.testing.assert_array_equal(held, diagram()["lyapunov_exponent"].values.astype("f4"))


def test_large_charts_are_thinned_and_say_so():
    data, left_out = explorer_data(chart(1200, 900).drop_vars("section"))
    assert left_out == ["Of 1200 x 900 points this chart holds 600 x 450, one in 2 each way; the archive has all."]
    zeta = np.frombuffer(base64.b64decode(data["axes"][0]["values"]))
    np.testing.assert_array_equal(zeta, np.linspace(0.1, 0.4, 1200)[::2])
    held = sum(len(text) for text in (data["outcome"], data["period"], *(q["values"] for q in data["quantities"])))
    assert held < 4 / 3 * GRID_BYTES


def test_of_long_sections_the_last_points_are_kept():
    data, left_out = explorer_data(diagram(200, 8001))
    assert left_out == ["Of 8001 section points of each run this chart holds the last 3750."]
    assert len(data["section"]["values"]) <= 4 / 3 * SECTION_BYTES
    section = np.frombuffer(base64.b64decode(data["section"]["values"]), dtype="<f4").reshape(200, 3750, 2)
    # the last of 8001 points of a cycle of two is its first one
    assert section[0, -1, 0] == -0.125


def test_points_stand_in_ascending_order():
    data, _ = explorer_data(chart().isel(zeta=[2, 0, 3, 1]))
    assert np.all(np.diff(np.frombuffer(base64.b64decode(data["axes"][0]["values"]))) > 0)
    assert list(np.frombuffer(base64.b64decode(data["period"]), dtype="<i2")) == [
        n for n in (1, 2, 3, 4) for _ in range(3)
    ]


def test_many_charts_share_what_a_page_holds():
    data, _ = explorer_data(chart(1200, 900), 0.25)
    held = sum(len(text) for text in (data["outcome"], data["period"], *(q["values"] for q in data["quantities"])))
    assert 0.1 * GRID_BYTES < held < 0.25 * 4 / 3 * GRID_BYTES
    whole, part = (explorer_data(diagram(200, 8001), share)[0]["section"]["iterates"] for share in (1.0, 0.25))
    assert part == whole // 4
