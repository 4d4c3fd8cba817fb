"""The cameras and boards in 3D turn by mouse, fingers and keys."""

import pytest
from browser import Browser
from pages import Page

CANVAS = "canvas.orbit"
STATE = """(() => {
  const {yaw, pitch, zoom, items} = document.querySelector('canvas.orbit').dataset;
  return [yaw, pitch, zoom, items].map(Number); })()"""

# A sum over the pixels, which changes with the picture.
PIXELS = """(() => { const canvas = document.querySelector('canvas.orbit');
  const {data} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  return new Uint32Array(data.buffer).reduce((sum, x) => (Math.imul(sum, 31) + x) | 0, 7); })()"""


@pytest.fixture
def scene(browser: Browser, pages: dict[str, Page]) -> Browser:
    browser.open(pages["good"].file)
    browser.middle_of(CANVAS)
    browser.frame()
    return browser


def test_shows_each_camera_and_board(scene: Browser, pages: dict[str, Page]) -> None:
    data = pages["good"].data
    assert scene.js(STATE)[3] == len(data["views"]) + len(data["boards"])


def test_the_mouse_turns_it(scene: Browser) -> None:
    (yaw, pitch, *_), pixels = scene.js(STATE), scene.js(PIXELS)
    scene.drag(CANVAS, 120, 40)
    turned = scene.js(STATE)
    assert turned[0] == pytest.approx(yaw - 120 * 0.008, abs=0.05)
    assert turned[1] == pytest.approx(pitch + 40 * 0.008, abs=0.05)
    assert scene.js(PIXELS) != pixels
    assert not scene.js("Boolean(document.querySelector('dialog[open]'))")


def test_the_wheel_zooms_after_a_click_only(scene: Browser) -> None:
    zoom = scene.js(STATE)[2]
    x, y = scene.middle_of(CANVAS)
    scene.mouse("mouseWheel", x, y, deltaX=0, deltaY=-60)
    scene.frame()
    assert scene.js(STATE)[2] == zoom
    scene.js("document.querySelector('canvas.orbit').focus()")
    scene.mouse("mouseWheel", x, y, deltaX=0, deltaY=-300)
    scene.wait(f"{STATE}[2] > {1.5 * zoom}")


def test_keys_turn_it(scene: Browser) -> None:
    yaw, pitch, zoom, _ = scene.js(STATE)
    scene.js("document.querySelector('canvas.orbit').focus()")
    for key in ("ArrowRight", "ArrowUp"):
        scene.press(key)
    assert scene.js(STATE)[0] == pytest.approx(yaw + 0.1, abs=0.01)
    assert scene.js(STATE)[1] == pytest.approx(pitch + 0.1, abs=0.01)


def test_fingers_turn_and_zoom_it(browser: Browser, pages: dict[str, Page]) -> None:
    browser.look(360, 740, touch=True)
    browser.open(pages["good"].file)
    x, y = browser.middle_of(CANVAS)
    browser.frame()
    yaw, pitch, zoom, _ = browser.js(STATE)
    browser.touch([(x, y)], [(x + 25, y + 10)], [(x + 50, y + 20)])
    turned = browser.js(STATE)
    assert turned[0] == pytest.approx(yaw - 50 * 0.008, abs=0.05)
    assert turned[1] == pytest.approx(pitch + 20 * 0.008, abs=0.05)
    browser.touch([(x - 20, y), (x + 20, y)], [(x - 40, y), (x + 40, y)],
                  [(x - 60, y), (x + 60, y)])
    closer = browser.js(STATE)
    assert closer[2] == pytest.approx(3 * zoom, rel=0.2)
    assert closer[:2] == turned[:2]


def test_a_click_on_a_camera_opens_its_picture(scene: Browser, pages: dict[str, Page]) -> None:
    x, y = scene.middle_of(CANVAS)
    places = [(x + dx, y + dy) for dy in range(-120, 121, 24) for dx in range(-120, 121, 24)]
    name = ""
    while not name:  # the name of the picture shows where the mouse is on a camera
        x, y = places.pop()
        scene.mouse("mouseMoved", x, y)
        name = scene.js("document.querySelector('canvas.orbit').title")
    for kind in ("mousePressed", "mouseReleased"):
        scene.mouse(kind, x, y, button="left", clickCount=1)
    scene.frame()
    index = scene.js("Number(document.querySelector('dialog[open]').dataset.view)")
    assert pages["good"].data["views"][index]["image"] == name


def test_buttons_choose_what_stands_still(scene: Browser, pages: dict[str, Page]) -> None:
    pixels = scene.js(PIXELS)
    scene.js("[...document.querySelectorAll('#scene button')].at(-1).click()")
    assert scene.js(PIXELS) != pixels
    assert scene.js(STATE)[3] == len(pages["good"].data["views"]) + 1
