"""The page in a browser, light and dark."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

# The page in a real browser: it opens in silence, loads nothing, and answers to clicks and keys with the archive.


@pytest.fixture
def open_page(written, visit):
    return visit(written.path)


def sentence(browser, number=0):
    """What is read aloud of a chart, by a timer of the page that is due after the one that says it."""
    return browser.execute_async_script(
        """const [number, done] = arguments;
        setTimeout(() => done(document.querySelectorAll('.readout')[number].textContent), 200);""",
        number,
    )


def table(browser, caption, number=0):
    """Cells of one of the tables beside a chart."""
    return browser.execute_script(
        """const all = document.querySelectorAll('.explorer')[arguments[1]].querySelectorAll('.details table');
        const one = [...all].find((t) => t.caption.textContent.startsWith(arguments[0]));
        return [...one.tBodies[0].rows].map((row) => [...row.cells].map((cell) => cell.textContent));""",
        caption,
        number,
    )


def press(browser, *keys, number=0):
    from selenium.webdriver.common.by import By

    browser.find_elements(By.CSS_SELECTOR, ".chart")[number].send_keys(*keys)


def click(browser, across, up, number=0):
    """Click into a chart at these parts of its frame's width and height until the page has seen it."""
    from selenium.webdriver import ActionChains
    from selenium.webdriver.common.by import By
    from selenium.webdriver.support.wait import WebDriverWait

    canvas = browser.find_elements(By.CSS_SELECTOR, ".chart canvas")[number]
    browser.execute_script(
        """const [canvas] = arguments;
        delete canvas.dataset.clicked;
        canvas.addEventListener('click', () => setTimeout(() => { canvas.dataset.clicked = 'yes'; }), {once: true});""",
        canvas,
    )

    def seen(_):
        if canvas.get_dom_attribute("data-clicked") == "yes":
            return True
        # a page that is still laid out moves away from under the pointer
        if browser.execute_async_script(STANDS_STILL, canvas):
            width, height = canvas.size["width"], canvas.size["height"]
            left, right, top, bottom = 74, width - 22, 10, height - 42
            x, y = left + across * (right - left), bottom - up * (bottom - top)
            pointer = ActionChains(browser, duration=0)
            pointer.move_to_element_with_offset(canvas, round(x - width / 2), round(y - height / 2)).click().perform()
        return False

    WebDriverWait(browser, 60).until(seen, "the page has seen no click")


STANDS_STILL = """
const [canvas, done] = arguments;
const place = () => JSON.stringify(canvas.getBoundingClientRect());
canvas.scrollIntoView({block: 'center', behavior: 'instant'});
const before = place();
const loaded = () => document.readyState === 'complete';
requestAnimationFrame(() => requestAnimationFrame(() => done(loaded() && place() === before)));
"""


def test_opens_in_silence_and_loads_nothing(open_page):
    assert open_page.get_log("browser") == []
    events = [json.loads(entry["message"])["message"] for entry in open_page.get_log("performance")]
    asked = [e["params"]["request"]["url"] for e in events if e["method"] == "Network.requestWillBeSent"]
    outside = [url for url in asked if not url.startswith("data:")]
    assert outside == [open_page.current_url]


def test_first_reading(open_page):
    assert sentence(open_page) == ("omega = 2.5: periodic; period 2; Lyapunov exponents −2.5, −∞; 8 section points.")
    assert table(open_page, "Section points of one cycle") == [["1", "−0.125", "2.5"], ["2", "0.125", "2.5"]]
    assert table(open_page, "Lyapunov exponents") == [["1", "−2.5", "0.0025"], ["2", "−∞", "0.0025"]]


def test_a_click_shows_the_point_under_it(open_page):
    # cells reach from 1.95 to 3.05
    click(open_page, (2.2 - 1.95) / 1.1, 0.5)
    assert sentence(open_page).startswith("omega = 2.2: periodic; period 2; Lyapunov exponents −2.2,")
    assert table(open_page, "Section points of one cycle")[0] == ["1", "−0.125", "2.2"]


def test_arrow_keys(open_page):
    from selenium.webdriver.common.keys import Keys

    press(open_page, Keys.ARROW_RIGHT, Keys.ARROW_RIGHT, Keys.ARROW_LEFT)
    assert sentence(open_page).startswith("omega = 2.6:")
    press(open_page, Keys.END)
    assert sentence(open_page) == "omega = 3: escaped; Lyapunov exponents –, –; no section points."
    press(open_page, Keys.HOME, Keys.ARROW_LEFT)
    assert sentence(open_page).startswith("omega = 2:")


def test_a_chart_over_two_parameters(open_page, tree):
    from selenium.webdriver.common.keys import Keys

    press(open_page, Keys.HOME, Keys.ARROW_RIGHT, Keys.ARROW_UP, Keys.ARROW_UP, number=1)
    assert sentence(open_page, 1).startswith("zeta = 0.2, omega = 2: periodic; period 2; Lyapunov exponents −19.8")
    assert sentence(open_page, 1).endswith("; 4 section points.")
    assert table(open_page, "Section points of one cycle", 1) == [["1", "0.2", "2"], ["2", "0.2", "4"]]
    click(open_page, 0.9, 0.1, number=1)
    point = tree["chart"].isel(zeta=3, omega=0, seed=0)
    rows = dict(table(open_page, "This point", 1))
    assert rows["period"] == str(int(point["period"])) == "4"
    shown = float(table(open_page, "Lyapunov exponents", 1)[0][1].replace("−", "-"))
    assert np.isclose(shown, point["lyapunov_exponent"].values[0], rtol=1e-5)


def test_typed_values_go_to_the_nearest_point(open_page):
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys

    field = open_page.find_element(By.CSS_SELECTOR, ".controls input")
    field.send_keys(Keys.CONTROL, "a", Keys.NULL, "2.33", Keys.ENTER)
    assert sentence(open_page).startswith("omega = 2.3:")
    assert float(field.get_property("value")) == pytest.approx(2.3)


def test_every_view_can_be_shown(open_page):
    from selenium.webdriver.common.by import By
    from selenium.webdriver.support.select import Select

    for chart in open_page.find_elements(By.CSS_SELECTOR, ".explorer"):
        select = Select(chart.find_element(By.CSS_SELECTOR, ".controls select"))
        pictures = set()
        for option in range(len(select.options)):
            select.select_by_index(option)
            canvas = chart.find_element(By.CSS_SELECTOR, ".chart canvas")
            pictures.add(open_page.execute_script("return arguments[0].toDataURL()", canvas))
        assert len(pictures) == len(select.options) >= 3
    assert open_page.get_log("browser") == []


def test_focus_is_seen_and_every_control_has_a_name(open_page):
    from selenium.webdriver.common.keys import Keys

    press(open_page, Keys.ARROW_RIGHT)
    outline = "const s = getComputedStyle(document.activeElement); return [s.outlineStyle, parseFloat(s.outlineWidth)]"
    style, width = open_page.execute_script(outline)
    assert style == "solid"
    assert width >= 2
    nameless = """const all = document.querySelectorAll('select, input, [role], img, canvas, a, nav, section');
        const labelled = (e) => (e.labels && e.labels.length) || e.hasAttribute('aria-labelledby') || e.ariaLabel;
        const told = (e) => e.alt || e.ariaHidden || e.ariaLive || e.textContent.trim();
        return [...all].filter((e) => !labelled(e) && !told(e)).length;"""
    assert open_page.execute_script(nameless) == 0


def test_landmarks_are_told_apart_by_their_names(open_page):
    names = """const by = (e) => document.getElementById(e.getAttribute('aria-labelledby'));
        const title = (e) => e.ariaLabel || by(e).textContent;
        return [...document.querySelectorAll('section, nav, [role=region]')].map(title)"""
    found = open_page.execute_script(names)
    assert len(found) == len(set(found)) >= 6


def test_readout_is_announced(open_page):
    live = "const r = document.querySelector('.readout'); return [r.ariaLive, r.ariaAtomic, r.role]"
    assert open_page.execute_script(live) == ["polite", "true", "status"]


@pytest.mark.parametrize("width", [360, 1100])
def test_nothing_is_wider_than_the_window_but_what_scrolls_by_keyboard(open_page, width):
    size = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": width < 600}
    open_page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    open_page.refresh()
    try:
        assert open_page.execute_script("return document.documentElement.scrollWidth") <= width
        stuck = """return [...document.querySelectorAll('body *')].filter((e) => e.scrollWidth > e.clientWidth + 1
            && ['auto', 'scroll'].includes(getComputedStyle(e).overflowX) && e.tabIndex < 0).length"""
        assert open_page.execute_script(stuck) == 0
    finally:
        open_page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_stands_out_in_light_and_in_dark(open_page, scheme):
    feature = {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
    open_page.execute_cdp_cmd("Emulation.setEmulatedMedia", feature)
    colours = """const lit = (e) => [getComputedStyle(e).color, getComputedStyle(document.body).backgroundColor];
        return ['p', '.note', 'a[href="#scene"]', '.readout', 'th', 'td'].map((s) => lit(document.querySelector(s)))"""
    pairs = open_page.execute_script(colours)
    open_page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
    grounds = {luminance(ground) for _, ground in pairs}
    assert all(ground < 0.1 for ground in grounds) if scheme == "dark" else all(ground > 0.8 for ground in grounds)
    # WCAG 2.1, success criterion 1.4.3
    assert min(contrast(*pair) for pair in pairs) >= 4.5


def luminance(colour):
    """Relative luminance of a CSS colour, as WCAG defines it."""
    parts = [float(part) / 255 for part in colour[colour.index("(") + 1 : -1].split(",")[:3]]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one, other):
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def test_without_scripts_the_rest_is_there(written, visit, chromium):
    chromium.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": True})
    try:
        browser = visit(written.path)
        from selenium.webdriver.common.by import By

        text = browser.find_element(By.TAG_NAME, "body").text
        assert "This chart needs JavaScript" in text
        assert "Motions along" in text
        assert not browser.find_element(By.CSS_SELECTOR, ".stage").is_displayed()
    finally:
        chromium.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": False})


# Pages as they are read: in light and dark, on a telephone and on a desk, turned, and printed.


DOCS = Path(__file__).parents[2] / "docs"

THEMES = ["light", "dark"]
WIDTHS = [360, 1100]
# WCAG 2.1, success criterion 1.4.3
READABLE = 4.5

COLOURS = """
const parse = (colour) => {
  const parts = colour.slice(colour.indexOf('(') + 1, -1).split(',').map(Number);
  return parts.length > 3 ? parts : [...parts, 1];
};
const over = (top, below) => [0, 1, 2].map((i) => top[i] * top[3] + below[i] * (1 - top[3])).concat([1]);
const linear = (part) => (part /= 255) <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4;
const luminance = ([red, green, blue]) => 0.2126 * linear(red) + 0.7152 * linear(green) + 0.0722 * linear(blue);
const contrast = (...pair) => {
  const [low, high] = pair.map(luminance).sort((a, b) => a - b);
  return (high + 0.05) / (low + 0.05);
};
const ground = (element) => {
  const layers = [];
  for (let e = element; e; e = e.parentElement) layers.unshift(parse(getComputedStyle(e).backgroundColor));
  return layers.reduce((below, layer) => over(layer, below), [255, 255, 255, 1]);
};
"""

TEXTS = (
    COLOURS
    + """
const found = [];
const look = (element, text) => {
  if (!text.trim() || !element.checkVisibility() || element.closest('script, option')) return;
  const below = ground(element);
  found.push([contrast(over(parse(getComputedStyle(element).color), below), below), text.trim().slice(0, 40)]);
};
const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
while (walk.nextNode()) look(walk.currentNode.parentElement, walk.currentNode.data);
for (const field of document.querySelectorAll('select, input:not([type=checkbox])')) look(field, field.value);
return found;
"""
)

# the strip below a chart, with the numbers and the name of its axis
LABELS = (
    COLOURS
    + """
const canvas = document.querySelectorAll('.chart canvas')[arguments[0]];
const below = ground(canvas);
const strip = Math.round(36 * canvas.width / canvas.clientWidth);
const { data } = canvas.getContext('2d').getImageData(0, canvas.height - strip, canvas.width, strip);
const found = [];
for (let i = 0; i < data.length; i += 4) if (data[i + 3] === 255) found.push(contrast(data.slice(i, i + 3), below));
return [found.length, Math.max(...found)];
"""
)


def as_seen(browser, theme="light", width=1100, media=""):
    """Set what the reader has: a theme, a width in pixels, and perhaps paper."""
    preference = {"media": media, "features": [{"name": "prefers-color-scheme", "value": theme}]}
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", preference)
    size = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": width < 600}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)


@pytest.fixture
def page(written, visit, chromium):
    yield visit(written.path)
    chromium.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    chromium.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "", "features": []})


def settled(browser):
    """Wait until what follows a change of size or theme is drawn."""
    browser.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(arguments[0])))")


def width_of_contents(browser):
    return browser.execute_script("return document.documentElement.scrollWidth")


def brightness(browser):
    """Luminance of the page behind its text."""
    return browser.execute_script(COLOURS + "return luminance(ground(document.body))")


def hard_to_read(browser, least=100):
    """Texts whose contrast is too low, of all texts that can be seen."""
    texts = browser.execute_script(TEXTS)
    assert len(texts) > least
    return [text for text in texts if text[0] < READABLE]


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("theme", THEMES)
def test_every_text_can_be_read(page, theme, width):
    as_seen(page, theme, width)
    page.refresh()
    assert (brightness(page) < 0.1) == (theme == "dark")
    assert hard_to_read(page) == []
    assert width_of_contents(page) <= width


@pytest.mark.parametrize("number", [0, 1])
def test_axes_are_drawn_anew_when_the_theme_changes(page, number):
    for theme in (*THEMES, THEMES[0]):
        as_seen(page, theme)
        settled(page)
        pixels, strongest = page.execute_script(LABELS, number)
        assert pixels > 20
        assert strongest >= READABLE


def test_a_page_that_becomes_narrow_follows(page):
    for width in (1100, 360, 720):
        as_seen(page, width=width)
        settled(page)
        assert width_of_contents(page) <= width
        wider = "return [...document.querySelectorAll('canvas')].filter((c) => c.clientWidth > innerWidth).length"
        assert page.execute_script(wider) == 0


def test_paper_is_white_whatever_the_theme(page):
    as_seen(page, "dark", media="print")
    settled(page)
    assert brightness(page) == 1
    assert hard_to_read(page) == []


def test_a_value_is_shown_without_the_dust_of_binary_fractions(page):
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys

    # the third of four equal steps from 0.1 to 0.4 is 0.30000000000000004
    field = page.find_elements(By.CSS_SELECTOR, ".explorer")[1].find_element(By.CSS_SELECTOR, ".controls input")
    field.send_keys(Keys.CONTROL, "a", Keys.NULL, "0.31", Keys.ENTER)
    assert field.get_property("value") == "0.3"


@pytest.fixture(scope="session")
def documentation(tmp_path_factory):
    """A page of the documentation with a dataset and with code and output that are wider than it."""
    sphinx = pytest.importorskip("sphinx.application", reason="sphinx is not installed")
    for needed in ("furo", "myst_nb"):
        pytest.importorskip(needed, reason=f"{needed} is not installed")
    dataset = xr.Dataset({"x": ("t", np.ones(3), {"units": "m"})}, {"t": [0.0, 1.0, 2.0]}, {"title": "three points"})
    shown = {"text/html": dataset._repr_html_(), "text/plain": repr(dataset)}
    outputs = [
        {"output_type": "stream", "name": "stdout", "text": "printed" * 60},
        {"output_type": "execute_result", "execution_count": 1, "data": shown, "metadata": {}},
    ]
    code = {"cell_type": "code", "execution_count": 1, "metadata": {}, "outputs": outputs}
    cells = [
        {"cell_type": "markdown", "metadata": {}, "source": "# A page"},
        {**code, "source": "wide = " + " + ".join(["number"] * 60) + "  # a comment"},
    ]
    notebook = {"nbformat": 4, "nbformat_minor": 4, "metadata": {}, "cells": cells}
    source = tmp_path_factory.mktemp("documentation")
    (source / "index.ipynb").write_text(json.dumps(notebook), encoding="utf-8")
    settings = {
        "extensions": ["myst_nb"],
        "nb_execution_mode": "off",
        "html_theme": "furo",
        "html_static_path": [str(DOCS / "_static")],
        "html_css_files": ["pages.css"],
    }
    (source / "conf.py").write_text("".join(f"{key} = {value!r}\n" for key, value in settings.items()), "utf-8")
    out = source / "html"
    sphinx.Sphinx(source, source, out, source / "trees", "html", status=None).build()
    return out / "index.html"


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize(
    ("theme", "chosen"), [("light", "auto"), ("dark", "auto"), ("light", "dark"), ("dark", "light")]
)
def test_documentation_can_be_read(documentation, page, visit, theme, chosen, width):
    as_seen(page, theme, width)
    visit(documentation)
    page.execute_script("document.body.dataset.theme = arguments[0]", chosen)
    settled(page)
    assert (brightness(page) < 0.1) == ("dark" in (chosen, theme if chosen == "auto" else ""))
    assert "three points" in page.execute_script("return document.querySelector('.xr-wrap').textContent")
    assert hard_to_read(page, least=20) == []
    assert width_of_contents(page) <= width
    cut = "return [...document.querySelectorAll('pre')].filter((e) => e.scrollWidth > e.clientWidth + 1).length"
    assert page.execute_script(cut) == 0
