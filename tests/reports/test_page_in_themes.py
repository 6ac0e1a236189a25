"""Pages as they are read: in light and dark, on a telephone and on a desk, turned, and printed."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

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
