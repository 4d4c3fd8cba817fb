"""The page of a camera on a robot: its numbers are those of the data, which are the terminal's."""

from browser import Browser
from pages import Page

ROWS = "[...document.querySelectorAll(a[0])].map((row) => [...row.cells].map((c) => c.innerText.trim()))"
ITEMS = "Number(document.querySelector('canvas.orbit').dataset.items)"


def shown(text: str) -> str:
    text = text.replace("+- ", "±\N{NO-BREAK SPACE}")
    return "\N{MINUS SIGN}" + text[1:] if text.startswith("-") else text


def test_both_places_have_their_numbers(browser: Browser, pages: dict[str, Page]) -> None:
    page = pages["handeye"]
    browser.open(page.file)
    columns = list(zip(*browser.js(ROWS, "#places .table-frame tbody tr")))
    camera, board = page.data["places"]
    assert list(columns[1]) == [shown(text) for text in camera["texts"]]
    assert list(columns[2]) == [shown(text) for text in board["texts"]]
    heads = browser.js(ROWS, "#places thead tr")
    assert heads == [["", "camera in the hand", "board in the base"]]
    assert shown(page.data["robot"]["text"]) in browser.js("document.querySelector('#places').innerText")


def test_rejected_poses_stand_first_then_the_worst(browser: Browser, pages: dict[str, Page]) -> None:
    page = pages["handeye"]
    browser.open(page.file)
    used = [pose for pose in page.data["poses"] if pose["state"] == "used"]
    assert len(used) == 11
    used.sort(key=lambda pose: -pose["score"])
    first, *rows = browser.js(ROWS, "#poses tbody tr")
    assert first[0].split() == ["004.png", "rejected"] and first[1:] == 4 * ["–"]
    assert rows == [[pose["image"], *pose["texts"]] for pose in used]
    marks = browser.js("document.querySelector('[data-chart=robot-position]').dataset.marks")
    assert int(marks) == 11


def test_the_robot_stands_in_3d(browser: Browser, pages: dict[str, Page]) -> None:
    browser.open(pages["handeye"].file)
    browser.middle_of("canvas.orbit")
    browser.frame()
    hands = 12 + 1  # and the next one, each with its camera and a line to it
    assert browser.js(ITEMS) == 1 + 3 * hands + 1  # base, hands, board


def test_a_refusal_shows_the_robot_alone(browser: Browser, pages: dict[str, Page]) -> None:
    browser.open(pages["handeye_refused"].file)
    browser.middle_of("canvas.orbit")
    browser.frame()
    assert browser.js(ITEMS) == 1 + 12  # base, hands
    for part in ("places", "poses", "formats", "next"):
        assert browser.js("document.getElementById(a[0]) === null", part), part
    assert "their places are not known" in browser.js("document.querySelector('#scene').innerText")
    assert browser.complaints() == []
