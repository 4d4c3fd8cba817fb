"""Thumbnails, and the picture that a click enlarges."""

from typing import Any

from browser import Browser
from pages import Page, changed

OPEN = "Boolean(document.querySelector('dialog.viewer[open]'))"
SHOWN = "Number(document.querySelector('dialog.viewer').dataset.view)"
ZOOM = "Number(document.querySelector('dialog.viewer svg').dataset.zoom ?? 1)"
SVG = "dialog.viewer .viewer-image svg"


def test_has_a_thumbnail_for_each_view(browser: Browser, page: Page) -> None:
    views = page.data.get("views")
    if not views:
        return
    cards = browser.js(
        "Promise.all([...document.querySelectorAll('.view')].map(async (card) => {"
        " const [node, picture] = [card.querySelector('image'), new Image()];"
        " if (node) { picture.src = node.getAttribute('href'); await picture.decode(); }"
        " return [Number(card.dataset.view), picture.naturalWidth, node?.getBBox().width ?? 0,"
        " Number(card.dataset.corners), card.querySelector('.name').textContent]; }))")
    assert sorted(index for index, *_ in cards) == list(range(len(views)))
    of_view = page.data["corners"]["view"]
    for index, natural, drawn, corners, name in cards:
        view = views[index]
        assert name == view["image"]
        assert natural == (view["thumbnail_size"] or [0])[0]
        assert drawn == (page.data["image_size"][0] if view["thumbnail"] else 0)
        assert corners == of_view.count(index)
    residuals = [views[index]["rms_px"] or 0 for index, *_ in cards]
    assert residuals == sorted(residuals, reverse=True)


def test_a_click_enlarges_and_escape_closes(browser: Browser, pages: dict[str, Page]) -> None:
    browser.open(pages["findings"].file)
    order = browser.js("[...document.querySelectorAll('.view')].map((v) => Number(v.dataset.view))")
    browser.click(".view")
    assert browser.js(OPEN) and browser.js(SHOWN) == order[0]
    view = pages["findings"].data["views"][order[0]]
    title = browser.js("document.querySelector('#viewer-title').textContent")
    assert title == f"{view['image']} (1 of {len(order)})"
    crosses = browser.js("(document.querySelector('dialog path.rejected')?.getAttribute('d')"
                         ".match(/M/g) ?? []).length")
    assert crosses == view["num_rejected"] > 0
    browser.press("ArrowRight")
    assert browser.js(SHOWN) == order[1]
    browser.press("ArrowLeft")
    browser.press("ArrowLeft")
    assert browser.js(SHOWN) == order[-1]
    browser.press("Escape")
    assert not browser.js(OPEN)
    assert browser.js("Number(document.activeElement.dataset.view)") == order[0]
    assert browser.complaints() == []


def test_the_keyboard_alone_opens_and_closes(browser: Browser, pages: dict[str, Page]) -> None:
    browser.open(pages["good"].file)
    browser.js("document.querySelector('.view').focus()")
    browser.press("Enter")
    assert browser.js(OPEN)
    for _ in range(12):  # the focus stays inside
        browser.press("Tab")
        assert browser.js("document.activeElement === document.body ||"
                          " Boolean(document.activeElement.closest('dialog'))")
    browser.press("Escape")
    assert not browser.js(OPEN)
    assert browser.js("document.activeElement === document.querySelector('.view')")


def test_an_enlarged_picture_zooms(browser: Browser, pages: dict[str, Page]) -> None:
    browser.open(pages["good"].file)
    browser.click(".view")
    x, y = browser.middle_of(SVG)
    browser.mouse("mouseWheel", x, y, deltaX=0, deltaY=-400)
    browser.wait(f"{ZOOM} > 2")
    before = browser.js("document.querySelector(a[0]).getAttribute('viewBox')", SVG)
    browser.drag(SVG, 60, 30)
    assert browser.js("document.querySelector(a[0]).getAttribute('viewBox')", SVG) != before
    browser.press("0")
    assert browser.js(ZOOM) == 1


def test_two_fingers_zoom_an_enlarged_picture(browser: Browser, pages: dict[str, Page]) -> None:
    browser.look(360, 740, touch=True)
    browser.open(pages["good"].file)
    browser.click(".view")
    x, y = browser.middle_of(SVG)
    browser.touch([(x - 20, y), (x + 20, y)], [(x - 40, y), (x + 40, y)],
                  [(x - 80, y), (x + 80, y)])
    assert browser.js(ZOOM) > 2.5
    before = browser.js("document.querySelector(a[0]).getAttribute('viewBox')", SVG)
    browser.touch([(x, y)], [(x + 30, y)], [(x + 60, y + 10)])
    assert browser.js("document.querySelector(a[0]).getAttribute('viewBox')", SVG) != before


def test_the_order_can_be_chosen(browser: Browser, pages: dict[str, Page]) -> None:
    browser.open(pages["findings"].file)
    browser.js("(() => { const choice = document.querySelector('#views select');"
               " choice.value = 'name'; choice.dispatchEvent(new Event('change')); })()")
    shown = browser.js("[...document.querySelectorAll('.view')].map((v) => Number(v.dataset.view))")
    assert shown == sorted(shown)


def test_an_ambiguous_picture_shows_both_poses(browser: Browser, pages: dict[str, Page]) -> None:
    def change(data: Any) -> None:
        view = data["views"][3]
        view["status"] = "ambiguous"
        view["hypotheses"] = [{**view["hypotheses"][0], "probability": p} for p in (0.75, 0.25)]

    page = changed(pages["poses"], "ambiguous.html", change)
    browser.open(page.file)
    assert browser.js("[...document.querySelectorAll('.view .tag')].map((tag) => [tag.textContent,"
                      " Number(tag.closest('.view').dataset.view)])") == [["ambiguous", 3]]
    browser.js("document.querySelector('.view[data-view=\"3\"]').click()")
    odds = browser.js("[...document.querySelectorAll('dialog table[aria-label=\"Poses that fit\"]"
                      " tbody tr')].map((row) => row.cells[1].textContent)")
    assert odds == ["75.0 %", "25.0 %"]
