"""The browser and the pages, once for all tests."""

import os
from pathlib import Path
from typing import Iterator

import pytest
from browser import Browser
from pages import MAKERS, Page, make_pages


@pytest.fixture(scope="session")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Page]:
    return make_pages(os.environ["TAGCAL_COMMAND"], tmp_path_factory.mktemp("pages"))


@pytest.fixture(scope="session")
def session() -> Iterator[Browser]:
    browser = Browser(os.environ["TAGCAL_CHROMIUM"], os.environ["TAGCAL_CHROMEDRIVER"])
    yield browser
    browser.close()


@pytest.fixture
def browser(session: Browser) -> Browser:
    """The browser as each test finds it: a window of 1200 pixels, light."""
    session.look()
    return session


@pytest.fixture(scope="module")
def page(session: Browser, pages: dict[str, Page], page_name: str) -> Page:
    """Each page in turn, opened once for all tests of a file that ask for it."""
    session.look()
    session.open(pages[page_name].file)
    return pages[page_name]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--pictures", metavar="FOLDER", type=Path,
                     help="save pictures of all pages in three widths, light and dark")


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    if "page_name" in metafunc.fixturenames:
        names = [make.__name__ for make in MAKERS]
        metafunc.parametrize("page_name", names, scope="module")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if not config.getoption("--pictures"):
        items[:] = [item for item in items if "saves_pictures" not in item.name]
