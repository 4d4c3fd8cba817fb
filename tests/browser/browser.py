"""One headless Chromium for all tests, with what they ask of it."""

import json
import time
from pathlib import Path
from typing import Any

from selenium import webdriver
from selenium.webdriver.chrome.service import Service

ARGUMENTS = ["--headless=new", "--disable-gpu", "--hide-scrollbars", "--disable-dev-shm-usage",
             "--no-sandbox",  # Chromium does not start as root without it
             "--host-resolver-rules=MAP * ~NOTFOUND", "--force-device-scale-factor=1"]
OFFLINE = ("file:", "data:", "about:", "chrome:")


class Browser:
    def __init__(self, chromium: str, driver: str) -> None:
        options = webdriver.ChromeOptions()
        options.binary_location = chromium
        for argument in ARGUMENTS:
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        self.driver = webdriver.Chrome(service=Service(driver), options=options)
        self.driver.set_script_timeout(20)

    def close(self) -> None:
        self.driver.quit()

    def cdp(self, command: str, **parameters: Any) -> Any:
        return self.driver.execute_cdp_cmd(command, parameters)

    def js(self, script: str, *arguments: Any) -> Any:
        """The value of an expression, which may be a promise; `a` has the arguments."""
        return self.driver.execute_async_script(
            "const a = [...arguments], done = a.pop();"
            f"Promise.resolve((() => ({script}))()).then(done, (e) => done(`failed: ${{e}}`));",
            *arguments)

    def frame(self) -> None:
        """Waits until what changed is on the screen."""
        self.js("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame("
                "() => done(1))))")

    def look(self, width: int = 1200, height: int = 900, scheme: str = "light",
             media: str = "", touch: bool = False) -> None:
        """The size of the window, and what the style sheet asks for."""
        self.cdp("Emulation.setDeviceMetricsOverride", width=width, height=height,
                 deviceScaleFactor=1, mobile=touch)
        self.cdp("Emulation.setTouchEmulationEnabled", enabled=touch)
        self.cdp("Emulation.setEmulatedMedia", media=media,
                 features=[{"name": "prefers-color-scheme", "value": scheme}])
        self.frame()

    def open(self, file: Path) -> None:
        self.logs("browser")
        self.logs("performance")
        self.driver.get(file.as_uri())
        self.frame()

    def logs(self, kind: str) -> list[Any]:
        return self.driver.get_log(kind)

    def complaints(self) -> list[str]:
        """Errors and warnings of the console since the page was opened."""
        return [entry["message"] for entry in self.logs("browser")
                if entry["level"] in ("SEVERE", "WARNING")]

    def requests(self) -> list[str]:
        """Addresses that the page asked for, other than files and data inside of it."""
        events = [json.loads(entry["message"])["message"] for entry in self.logs("performance")]
        addresses = [event["params"]["request"]["url"] for event in events
                     if event["method"] == "Network.requestWillBeSent"]
        assert addresses, "the log of the network is empty"
        return [address for address in addresses if not address.startswith(OFFLINE)]

    def press(self, key: str) -> None:
        text = {"text": "\r"} if key == "Enter" else {}
        for kind in ("keyDown" if text else "rawKeyDown", "keyUp"):
            self.cdp("Input.dispatchKeyEvent", type=kind, key=key, code=key,
                     windowsVirtualKeyCode=KEY_CODES.get(key, 0), **text)
        self.frame()

    def middle_of(self, selector: str) -> tuple[float, float]:
        """The middle of an element on the screen, after scrolling to it."""
        return tuple(self.js(
            "(() => { const node = document.querySelector(a[0]);"
            " node.scrollIntoView({block: 'center', behavior: 'instant'});"
            " const box = node.getBoundingClientRect();"
            " return [box.x + box.width / 2, box.y + box.height / 2]; })()", selector))

    def mouse(self, kind: str, x: float, y: float, **more: Any) -> None:
        self.cdp("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def click(self, selector: str) -> None:
        x, y = self.middle_of(selector)
        for kind in ("mousePressed", "mouseReleased"):
            self.mouse(kind, x, y, button="left", clickCount=1)
        self.frame()

    def drag(self, selector: str, dx: float, dy: float, steps: int = 4) -> None:
        x, y = self.middle_of(selector)
        self.mouse("mousePressed", x, y, button="left", buttons=1, clickCount=1)
        for step in range(1, steps + 1):
            self.mouse("mouseMoved", x + dx * step / steps, y + dy * step / steps, button="left",
                       buttons=1)
        self.mouse("mouseReleased", x + dx, y + dy, button="left", clickCount=1)
        self.frame()

    def touch(self, *steps: list[tuple[float, float]]) -> None:
        """Fingers at the places of each step, then none."""
        for number, fingers in enumerate([*steps, []]):
            kind = "touchStart" if number == 0 else "touchMove" if fingers else "touchEnd"
            self.cdp("Input.dispatchTouchEvent", type=kind,
                     touchPoints=[{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(fingers)])
        self.frame()

    def wait(self, condition: str, seconds: float = 5) -> None:
        end = time.monotonic() + seconds
        while not self.js(condition):
            assert time.monotonic() < end, f"never true: {condition}"
            time.sleep(0.02)


KEY_CODES = {"Escape": 27, "ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40,
             "Tab": 9, "Enter": 13}
