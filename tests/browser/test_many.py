"""Long lists start folded: hundreds of pictures, and a note for each of them."""

from typing import Any

import pytest
from browser import Browser
from pages import Page, changed

SHOWN = "document.querySelectorAll('.view').length"


@pytest.fixture
def many(browser: Browser, pages: dict[str, Page]) -> Page:
    def change(data: Any) -> None:
        data["views"] = 4 * data["views"]
        data["findings"] = [{"code": "view_repeated", "severity": "note",
                             "sentence": f"{number}.png: not used"} for number in range(50)]
        data["findings"].append({"code": "extrapolated", "severity": "warning",
                                 "sentence": "no corners below"})

    page = changed(pages["good"], "many.html", change)
    browser.open(page.file)
    return page


def test_the_first_pictures_are_shown_then_all(browser: Browser, many: Page) -> None:
    assert browser.js(SHOWN) == 24
    browser.click("#views .more button")
    assert browser.js(SHOWN) == len(many.data["views"]) == 64
    assert not browser.js("document.querySelector('#views .more').checkVisibility()")


def test_findings_of_one_kind_fold_up(browser: Browser, many: Page) -> None:
    entries = browser.js("[...document.querySelectorAll('.findings li')].map((li) => li.innerText)")
    assert len(entries) == 2
    assert "no corners below" in entries[0]  # the gravest first
    assert "0.png" in entries[1] and "49 more of this kind" in entries[1]
    browser.click(".findings summary")
    assert "49.png: not used" in browser.js("document.querySelector('.findings').innerText")
