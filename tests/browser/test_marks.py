"""Every page opens without a complaint and without a network, and every chart has its marks."""

from browser import Browser
from pages import Page

# Charts of each page.
RESIDUALS = ["residual-vectors", "residual-map", "distribution", "radial-profile"]
EXPECTED = {
    "good": ["coverage", "next-view", *RESIDUALS, "uncertainty", "rms", "views", "scene", "warp",
             "ladder"],
    "fisheye": ["coverage", "next-view", *RESIDUALS, "uncertainty", "rms", "views", "scene", "warp",
                "ladder"],
    "findings": ["coverage", "next-view", *RESIDUALS, "uncertainty", "rms", "views", "scene",
                 "warp"],
    "no_answer": ["coverage", "views"],
    "difference": ["difference", "difference-parameters"],
    "poses": [*RESIDUALS, "rms", "views", "scene"],
    "bare": ["uncertainty"],
    "rig": ["pairs", "depth", "rectified", "rig", "instants", *3 * ["coverage", "uncertainty"]],
    "rig_file": ["depth", "rig", *3 * ["uncertainty"]],
    "handeye": ["robot", "robot-position", "robot-rotation"],
    "handeye_refused": ["robot"],
    "hostile": ["coverage", *RESIDUALS, "uncertainty", "rms", "views", "scene"],
}

# Number of subpaths of an SVG path: marks of one kind are one path.
COUNT = "(document.querySelector(a[0])?.getAttribute('d').match(/M/g) ?? []).length"

# The colours of style.css with which each canvas draws its data.
COLOURS = {"distribution": ["--sky", "--vermilion"], "radial-profile": ["--blue", "--orange"],
           "rms": ["--sky", "--vermilion"], "scene": ["--blue", "--square"],
           "robot": ["--blue", "--vermilion"], "robot-position": ["--sky", "--vermilion"],
           "rig": ["--blue", "--vermilion"], "depth": ["--blue", "--vermilion"]}

# The number of pixels that are nearly of these colours in the canvas of a chart.
PAINTED = """(() => {
  const canvas = document.querySelector(`[data-chart=${a[0]}] canvas`);
  const {data} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  const style = getComputedStyle(document.documentElement);
  return a[1].map((name) => {
    const hex = style.getPropertyValue(name).trim();
    const colour = [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16)).concat(255);
    let count = 0;
    for (let at = 0; at < data.length; at += 4)
      count += colour.every((value, i) => Math.abs(value - data[at + i]) < 40);
    return count;
  });
})()"""


def test_opens_quietly_and_offline(browser: Browser, page: Page) -> None:
    browser.wait("document.documentElement.dataset.ready === '1'")
    assert browser.complaints() == []
    assert browser.requests() == []
    assert browser.js("document.querySelectorAll('.failed').length") == 0
    assert browser.js("document.title") == f"{page.data['title']} - tagcal report"
    assert page.data["verdict"]["level"] == browser.js(
        "document.querySelector('.verdict').dataset.level")


def test_has_its_charts(browser: Browser, page: Page, page_name: str) -> None:
    charts = browser.js(
        "[...document.querySelectorAll('[data-chart]')].map((node) => [node.dataset.chart,"
        " Number(node.dataset.marks), node.querySelector('.chart-body').clientHeight,"
        " node.querySelector('figcaption').textContent])")
    assert sorted(name for name, *_ in charts) == sorted(EXPECTED[page_name])
    for name, marks, height, words in charts:
        assert marks > 0 and height > 20, name
        assert words.startswith("How to read it: ") and len(words) > 60, name
    for name in COLOURS.keys() & EXPECTED[page_name]:
        counts = browser.js(PAINTED, name, COLOURS[name])
        assert min(counts) > 50, (name, COLOURS[name], counts)


def test_draws_each_corner(browser: Browser, page: Page, page_name: str) -> None:
    corners = page.data.get("corners") or {"u": []}
    if not corners["u"]:
        return
    rejected = sum(corners["rejected"])
    used = len(corners["u"]) - rejected
    known = sum(not bad and du is not None for bad, du in zip(corners["rejected"], corners["du"]))
    if "coverage" in EXPECTED[page_name]:
        assert browser.js(COUNT, "#coverage path.dots.used") == used
        assert browser.js(COUNT, "#coverage path.rejected") == rejected
    if known:
        assert browser.js(COUNT, "[data-chart=residual-vectors] path.vector") == known
        cells = browser.js("document.querySelectorAll('[data-chart=residual-map] .cell').length")
        assert cells == browser.js(
            "Number(document.querySelector('[data-chart=residual-map]').dataset.marks)")


def test_draws_maps_with_contours(browser: Browser, pages: dict[str, Page]) -> None:
    for name, chart, count in [("good", "uncertainty", len(pages["good"].data["projection"])),
                               ("fisheye", "warp", 1),
                               ("difference", "difference",
                                len(pages["difference"].data["difference"]["maps"]))]:
        browser.open(pages[name].file)
        maps = browser.js(
            "Promise.all([...document.querySelectorAll(`[data-chart=${a[0]}] svg`)]"
            ".map(async (svg) => { const image = new Image();"
            " image.src = svg.querySelector('image').getAttribute('href'); await image.decode();"
            " return [image.naturalWidth, svg.querySelectorAll('.contour').length]; }))", chart)
        assert len(maps) == count, chart
        assert all(width > 50 for width, _ in maps), chart
        assert sum(contours for _, contours in maps) > 0, chart


def test_shows_what_was_found(browser: Browser, page: Page) -> None:
    text = browser.js("document.querySelector('main').innerText")
    for finding in page.data["findings"]:
        assert finding["sentence"] in text
    for note in page.data["notes"]:
        assert note in text
    rows = browser.js("[...document.querySelectorAll('table.ladder tbody tr')].map((row) =>"
                      " row.dataset.model)")
    assert rows == [step["model"] for step in page.data.get("ladder") or []]
    for sentence in [page.data["verdict"]["sentence"].partition(": ")[2], page.data.get("next") or ""]:
        assert sentence[1:] in text  # its first letter may be a capital
    for name in [row["name"] for row in page.data.get("parameters") or []]:
        assert browser.js("[...document.querySelectorAll('#parameters td b')]"
                          ".some((node) => node.textContent === a[0])", name)
