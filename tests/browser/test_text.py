"""Texts of files are texts, never HTML; numbers can be copied."""

from browser import Browser
from pages import HOSTILE_FOLDER, HOSTILE_PICTURES, Page

BUTTON = "#formats .copy"


def test_names_that_are_html_show_as_text(browser: Browser, pages: dict[str, Page]) -> None:
    page = pages["hostile"]
    assert {view["image"] for view in page.data["views"]} > set(HOSTILE_PICTURES.values())
    browser.open(page.file)
    text = browser.js("document.querySelector('main').innerText")
    for name in [*HOSTILE_PICTURES.values(), HOSTILE_FOLDER]:
        assert name in text, name
    # An alert would have made the calls above fail. Nothing else came into being either.
    assert browser.js("document.querySelectorAll('img').length") == 0
    assert browser.js("document.scripts.length") == 2
    for index, view in enumerate(page.data["views"]):
        if view["image"] in HOSTILE_PICTURES.values():
            browser.js("document.querySelector(`.view[data-view='${a[0]}']`).click()", index)
            assert view["image"] in browser.js(
                "document.querySelector('#viewer-title').textContent")
            browser.press("Escape")
    assert browser.complaints() == []


def test_shows_each_format(browser: Browser, pages: dict[str, Page]) -> None:
    page = pages["bare"]
    browser.open(page.file)
    shown = browser.js("[...document.querySelectorAll('#formats details')].map((node) => ({"
                       "name: node.querySelector('summary').textContent,"
                       "text: node.querySelector('pre').textContent}))")
    assert shown == page.data["formats"]


def test_a_button_copies(browser: Browser, pages: dict[str, Page]) -> None:
    browser.cdp("Browser.grantPermissions",
                permissions=["clipboardReadWrite", "clipboardSanitizedWrite"])
    browser.open(pages["bare"].file)
    browser.click(BUTTON)
    browser.wait(f"document.querySelector('{BUTTON}').textContent === 'Copied'")
    assert browser.js("navigator.clipboard.readText()") == pages["bare"].data["formats"][0]["text"]


def test_without_a_clipboard_the_text_is_selected(browser: Browser, pages: dict[str, Page]) -> None:
    browser.open(pages["bare"].file)
    browser.js("(() => { Object.defineProperty(navigator, 'clipboard', {value: undefined});"
               " document.execCommand = () => false; })()")
    browser.click(BUTTON)
    browser.wait(f"document.querySelector('{BUTTON}').textContent.startsWith('Selected')")
    selected = browser.js("getSelection().toString()")
    assert selected.strip() == pages["bare"].data["formats"][0]["text"].strip()
