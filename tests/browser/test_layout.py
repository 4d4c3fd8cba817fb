"""Small and large screens, light and dark, paper, and pictures of all of them to look at."""

import base64
import re

import pytest
from browser import Browser
from pages import Page

WIDTHS = (360, 800, 1600)
HEIGHT = 900
LEAST_CONTRAST = 4.5  # WCAG 2.2, AA

# Elements that reach out of the window, other than in frames that scroll by themselves.
OUTSIDE = """[...document.querySelectorAll('main *')].filter((node) => {
  const box = node.getBoundingClientRect();
  if (box.right <= innerWidth + 0.5 && box.left >= -0.5) return false;
  for (let up = node; up; up = up.parentElement)
    if (['auto', 'scroll', 'hidden'].includes(getComputedStyle(up).overflowX)) return false;
  return true;
}).map((node) => node.outerHTML.slice(0, 80))"""

# [contrast, text] of each text on the page, by WCAG's relative luminance.
CONTRASTS = """(() => {
  const rgba = (css) => (css.match(/[\\d.]+/g) ?? [0, 0, 0, 0]).map(Number);
  const over = ([r, g, b, a = 1], below) => [r, g, b].map((x, i) => a * x + (1 - a) * below[i]);
  const behind = (node) => {
    if (!node) return [255, 255, 255];
    return over(rgba(getComputedStyle(node).backgroundColor), behind(node.parentElement));
  };
  const luminance = (rgb) => rgb.map((x) => x / 255).map((x) =>
    (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4))
    .reduce((sum, x, i) => sum + [0.2126, 0.7152, 0.0722][i] * x, 0);
  return [...document.querySelectorAll('body *:not(script, style, noscript, svg, svg *)')]
    .filter((node) => node.checkVisibility() && [...node.childNodes].some((child) =>
      child.nodeType === Node.TEXT_NODE && child.textContent.trim()))
    .map((node) => {
      const ground = behind(node);
      const style = getComputedStyle(node);
      const [a, b] = [over(rgba(style.color), ground), ground].map(luminance);
      return [(Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05), node.textContent.slice(0, 60)];
    });
})()"""


def test_nothing_scrolls_sideways(browser: Browser, page: Page) -> None:
    for width in WIDTHS:
        browser.look(width, HEIGHT)
        assert browser.js("document.documentElement.scrollWidth") == width
        assert browser.js(OUTSIDE) == [], width


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_stands_out(browser: Browser, page: Page, scheme: str) -> None:
    browser.look(scheme=scheme)
    texts = browser.js(CONTRASTS)
    assert len(texts) > 20
    assert [entry for entry in texts if entry[0] < LEAST_CONTRAST] == []
    background = browser.js("getComputedStyle(document.body).backgroundColor")
    assert (sum(map(int, re.findall(r"\d+", background)[:3])) > 384) == (scheme == "light")


def test_charts_follow_light_and_dark(browser: Browser, pages: dict[str, Page]) -> None:
    browser.open(pages["good"].file)
    canvases = ("[...document.querySelectorAll('.chart canvas')].map((canvas) =>"
                " canvas.toDataURL())")
    light = browser.js(canvases)
    browser.look(scheme="dark")
    dark = browser.js(canvases)
    assert len(light) == 4 and all(a != b for a, b in zip(light, dark))


# What is seen at the moment of printing.
WATCH_PRINT = """addEventListener('beforeprint', () => { window.printed = {
  formats: [...document.querySelectorAll('.format pre')].map((pre) => pre.checkVisibility()),
  views: [...document.querySelectorAll('.view')].length,
  page: getComputedStyle(document.documentElement).getPropertyValue('--page').trim()}; })"""


def test_paper_shows_all(browser: Browser, pages: dict[str, Page]) -> None:
    data = pages["good"].data
    browser.look(scheme="dark")
    browser.open(pages["good"].file)
    browser.js(WATCH_PRINT)
    opened = "[...document.querySelectorAll('details')].map((node) => node.open)"
    before = browser.js(opened)
    pdf = base64.b64decode(browser.cdp("Page.printToPDF", printBackground=True)["data"])
    assert pdf.startswith(b"%PDF") and len(re.findall(rb"/Type\s*/Page\b", pdf)) >= 3
    printed = browser.js("window.printed")
    assert printed["formats"] == [True] * len(data["formats"])
    assert printed["views"] == len(data["views"])
    assert printed["page"] == "#f4f5f7"  # paper is light
    assert browser.js(opened) == before


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_saves_pictures(browser: Browser, page: Page, page_name: str, scheme: str,
                        request: pytest.FixtureRequest) -> None:
    folder = request.config.getoption("--pictures")
    folder.mkdir(parents=True, exist_ok=True)
    for width in WIDTHS:
        browser.look(width, HEIGHT, scheme)
        height = browser.js("document.documentElement.scrollHeight")
        browser.look(width, height, scheme)
        picture = browser.cdp("Page.captureScreenshot", format="png")["data"]
        (folder / f"{page_name}-{width}-{scheme}.png").write_bytes(base64.b64decode(picture))
