"""The page of a rig: its numbers are those of the data, which are the terminal's."""

from browser import Browser
from pages import Page

ROWS = "[...document.querySelectorAll(a[0])].map((row) => row.innerText)"


def shown(text: str) -> str:
    return text.replace("+- ", "±\N{NO-BREAK SPACE}").replace("-", "\N{MINUS SIGN}", 1) \
        if text.startswith("-") else text.replace("+- ", "±\N{NO-BREAK SPACE}")


def test_each_pair_has_its_numbers(browser: Browser, pages: dict[str, Page]) -> None:
    for name in ("rig", "rig_file"):
        data = pages[name].data
        browser.open(pages[name].file)
        rows = browser.js(ROWS, "#pairs tbody tr")
        assert len(rows) == len(data["pairs"]) == 3
        for pair in data["pairs"]:
            a, b = (data["cameras"][pair[side]]["name"] for side in "ab")
            row = next(row for row in rows if row.startswith(f"{a} – {b}"))
            assert shown(pair["baseline"]) in row
            assert (pair.get("disagreement") or "") in row
            depths = next(row for row in browser.js(ROWS, "#depth tbody tr")
                          if row.startswith(f"{a} – {b}"))
            for depth in pair["depths"]:
                assert shown(depth["text"].split(" m ", 1)[1]) in depths
    assert browser.complaints() == []


def test_the_graph_has_an_edge_a_pair(browser: Browser, pages: dict[str, Page]) -> None:
    page = pages["rig"]
    browser.open(page.file)
    assert browser.js("document.querySelectorAll('#pairs .edge').length") == len(page.data["pairs"])
    labels = browser.js("[...document.querySelectorAll('#pairs text.pair')].map((n) => "
                        "n.textContent)")
    assert sorted(labels) == sorted(f"{pair['disagreement']}, {pair['num_instants']} instants"
                                    for pair in page.data["pairs"])


def test_the_timeline_has_each_picture(browser: Browser, pages: dict[str, Page]) -> None:
    page = pages["rig"]
    states = [instant["state"] for instant in page.data["instants"]]
    assert states.count("rejected") == 1 and states.count("used") == 13
    browser.open(page.file)
    for camera in range(3):
        taken = [i["state"] for i in page.data["instants"] if camera in i["cameras"]]
        for kind in ("used", "rejected"):
            marks = browser.js(
                "(document.querySelectorAll('#instants svg')[a[0]].querySelector(`.${a[1]}`)"
                "?.getAttribute('d').match(/M/g) ?? []).length", camera, kind)
            assert marks == taken.count(kind), (camera, kind)
    assert "005.png, 009.png (2 of 3 used)" in browser.js("document.querySelector('#instants').innerText")


def test_a_name_leads_to_its_lens(browser: Browser, pages: dict[str, Page]) -> None:
    page = pages["rig"]
    browser.open(page.file)
    browser.click("#cameras a[href='#camera-2']")
    assert browser.js("Math.abs(document.querySelector('#camera-2').getBoundingClientRect().top)"
                      ) < 700
    names = browser.js(ROWS, "#camera-2 .parameters b")
    assert names == [row["name"] for row in page.data["cameras"][2]["parameters"]]


def test_the_ellipsoids_say_by_how_much_they_are_enlarged(browser: Browser,
                                                         pages: dict[str, Page]) -> None:
    page = pages["rig"]
    browser.open(page.file)
    text = browser.js("document.querySelector('#scene figcaption').innerText")
    assert " × as large" in text
    browser.middle_of("canvas.orbit")
    browser.frame()
    items = browser.js("[...document.querySelectorAll('canvas.orbit')].map((canvas) =>"
                       " Number(canvas.dataset.items))")
    assert items == [3 + 2 + 14, 3 + 2]  # cameras, ellipsoids but the reference's, boards
