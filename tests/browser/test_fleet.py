"""The page of a fleet: its table, its links and a chart of each parameter."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from browser import Browser
from pages import Page, data_of

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "fleet"))
import fleets  # noqa: E402


def longer(corners: Path) -> None:
    """Corners of a lens that is 5 % longer."""
    head, *lines = corners.read_text().splitlines()
    rows = [line.rsplit(",", 2) for line in lines]
    corners.write_text("\n".join([head] + [
        f"{name},{319.5 + 1.05 * (float(u) - 319.5)},{199.5 + 1.05 * (float(v) - 199.5)}"
        for name, u, v in rows]) + "\n")


@pytest.fixture(scope="module")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> Page:
    place = tmp_path_factory.mktemp("fleet")
    fleets.make_sets(place, 40)
    longer(place / "cameras/c0007/corners.csv")
    fleets.calibrate_serially(place, "fleet")
    done = subprocess.run([os.environ["TAGCAL_COMMAND"], "fleet", "fleet", "--out", "fleet.html"],
                          cwd=place, capture_output=True, text=True)
    assert done.returncode == 1, done.stderr
    return Page(place / "fleet.html", data_of(place / "fleet.html"))


def test_the_page_names_the_worst_and_leads_to_it(browser: Browser, fleet: Page) -> None:
    browser.open(fleet.file)
    assert "Units fail" in browser.js("document.querySelector('header').innerText")
    rows = browser.js("[...document.querySelectorAll('#worst tbody tr')].map((r) => r.innerText)")
    assert len(rows) == len(fleet.data["fleet"]["worst"]) == 10
    assert rows[0].startswith("c0007") and "outlying" in rows[0]
    link = browser.js("document.querySelector('#worst a').getAttribute('href')")
    assert link == "fleet/c0007.yaml" and (fleet.file.parent / link).is_file()
    assert browser.complaints() == []


def test_each_parameter_has_its_charts(browser: Browser, fleet: Page) -> None:
    browser.open(fleet.file)
    group = fleet.data["fleet"]["groups"][0]
    histogram = group["parameters"][0]["histogram"]
    assert sum(histogram["counts"]) + histogram["outside"] == group["num_units"] == 40
    for name in ("histogram-f", "control-f"):
        marks = browser.js(f"document.querySelector('[data-chart={name}]').dataset.marks")
        assert int(marks) == 40
    assert browser.js("document.querySelectorAll('.plot canvas').length") == 2
    assert "Large dots fail: c0007" in browser.js("document.querySelector('#parameters-0').innerText")
    assert group["parameters"][0]["spread_text"].replace("+- ", "±\N{NO-BREAK SPACE}") in browser.js(
        "document.querySelector('#population-0').innerText")
