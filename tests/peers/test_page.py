"""The page in Chromium: every view, its accessibility, hostile names, and the build that is committed."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from anyio import to_thread
from tests.peers.network import missing_programs
from tests.peers.node_package import node_folder

from homebot.config import parse_config
from homebot.house import SimulatedLamp, World, thesis_world
from homebot.runtime import Runtime

webdriver: Any = pytest.importorskip("selenium.webdriver")  # brings trio: installed by hand, `pip install selenium`
Service: Any = pytest.importorskip("selenium.webdriver.chrome.service").Service
By: Any = pytest.importorskip("selenium.webdriver.common.by").By
WebDriverWait: Any = pytest.importorskip("selenium.webdriver.support.ui").WebDriverWait

SOURCE = Path(__file__).parents[2] / "src/homebot/web/source"
BUILT = SOURCE.parent / "page"
WITHIN = 10.0
FLAGS = (
    "--headless=new",
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--lang=en",
    "--window-size=1200,900",
)
MARKUP = "<img src=x onerror=alert(1)><b>lamp"


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    """Return Debian's Chromium, without a window."""
    if missing := missing_programs("chromium", "chromedriver"):
        pytest.skip(f"not installed: {missing} (apt-get install chromium chromium-driver)")
    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    for flag in (*FLAGS, *(["--no-sandbox"] if os.geteuid() == 0 else [])):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))
    yield driver
    driver.quit()


@pytest.fixture(scope="module")
def axe() -> str:
    """Return the program that judges accessibility."""
    return (node_folder(Path(__file__).parent / "page") / "node_modules/axe-core/axe.min.js").read_text()


class Page:
    """The page of one running homebot, in a browser that is asked from a thread."""

    def __init__(self, browser: Any, port: int) -> None:
        self.browser = browser
        self.url = f"http://127.0.0.1:{port}/"

    async def open(self, view: str = "", *, shows: str) -> str:
        """Open *view* and return its text as soon as it shows a text."""
        await to_thread.run_sync(self.browser.get, f"{self.url}{view}")
        return await self.shows(shows)

    async def shows(self, text: str, place: str = "#page") -> str:
        def seen(browser: Any) -> str:
            found: str = browser.find_element(By.CSS_SELECTOR, place).text
            return found if text in found else ""

        return await to_thread.run_sync(WebDriverWait(self.browser, WITHIN, 0.05).until, seen)

    async def hides(self, text: str) -> None:
        def gone(browser: Any) -> bool:
            return text not in browser.find_element(By.CSS_SELECTOR, "#page").text

        await to_thread.run_sync(WebDriverWait(self.browser, WITHIN, 0.05).until, gone)

    async def click(self, selector: str) -> None:
        def press(browser: Any) -> bool:
            for found in browser.find_elements(By.CSS_SELECTOR, selector):
                found.click()
                return True
            return False

        await to_thread.run_sync(WebDriverWait(self.browser, WITHIN, 0.05).until, press)

    async def write(self, selector: str, text: str) -> None:
        await to_thread.run_sync(lambda: self.browser.find_element(By.CSS_SELECTOR, selector).send_keys(text))

    def problems(self) -> list[str]:
        """Return the errors of the browser, violations of the content security policy among them."""
        return [one["message"] for one in _log(self.browser) if one["level"] == "SEVERE"]


def _log(browser: Any) -> list[dict[str, str]]:
    """Return the lines of the browser's log since the last call."""
    lines: list[dict[str, str]] = browser.get_log("browser")
    return lines


@pytest.fixture
def page(chromium: Any) -> Callable[..., Any]:
    """Give what opens the page of a simulated house."""

    @asynccontextmanager
    async def opened(
        world: World | None = None, tables: dict[str, object] | None = None, **door: object
    ) -> AsyncIterator[Page]:
        _log(chromium)
        gateways = {"gateways": {"mqtt": {"root": "home425"}}}
        config = parse_config(
            {"home": {"name": "villa"}, "door": {"port": 0, **door}, **gateways, **(tables or {})}, "test"
        )
        async with Runtime(config, house=world or thesis_world(), robot="robot") as runtime:
            assert runtime.door is not None
            own = Page(chromium, runtime.door.port)
            try:
                yield own
            finally:
                chromium.execute_script("sessionStorage.clear()")
                chromium.get("about:blank")

    return opened


async def test_a_lamp_is_turned_on_and_the_page_says_how_that_is_known(page: Any) -> None:
    async with page() as own:
        await own.open(shows="3 devices")
        assert "villa" in await own.shows("roomlights405")
        await own.click("button[aria-label='turn philips165 on']")
        await own.shows("confirmed after", "[role=alert]")
        await own.click("button[aria-label='turn philips165 off']")
        assert own.problems() == []


@pytest.mark.parametrize(
    ("view", "shown"),
    [
        ("#/device/lights%2Froomlights405", "What is known, and from where"),
        ("#/device/lights%2Froomlights405", "It is so since homebot first heard of it."),
        ("#/plan", "Room 405"),
        ("#/plan", "robot: Room 405"),
        ("#/journal", "Nothing has happened yet."),
        ("#/system", "Nothing is wrong."),
        ("#/graph", "/discovery/states"),
        ("#/rates", "messages lost"),
        ("#/nonsense", "There is no such view."),
    ],
)
async def test_each_view_shows_what_homebot_says(page: Any, view: str, shown: str) -> None:
    async with page() as own:
        await own.open(view, shows=shown)
        assert own.problems() == []


async def test_what_happens_is_in_the_journal_at_once_with_the_reason(page: Any) -> None:
    async with page() as own:
        await own.open("#/device/lights%2Fphilips165", shows="Commands")
        await own.click("div[aria-label='on off'] button")
        await own.shows("the client local asked for on", "ol")
        text = await own.open("#/journal", shows="confirmed after")
        assert "philips165 the client local asked for on" in text
        assert own.problems() == []


async def test_a_name_with_markup_is_a_name(page: Any) -> None:
    """Whoever names a device may not run a script at its owner's."""
    async with page(World.of(SimulatedLamp(MARKUP))) as own:
        await own.open(shows=MARKUP)
        assert own.browser.find_elements(By.CSS_SELECTOR, "main img, main b") == []
        assert own.problems() == []


async def test_a_door_with_a_token_shows_nothing_before_it_is_typed_in(page: Any) -> None:
    async with page(token="hunter2") as own:
        text = await own.open(shows="a valid token is needed")
        assert "not logged in" in text
        assert "roomlights405" not in text
        for typed, shown in (("wrong", "a valid token is needed"), ("hunter2", "3 devices")):
            await own.write("input[type=password]", typed)
            await own.click("form button")
            await own.shows(shown)
        assert "hunter2" not in own.browser.current_url


async def test_a_device_that_can_hurt_is_approved_after_its_topics_were_shown(page: Any) -> None:
    tables = {
        "gateways": {"mqtt": {"root": "home425"}, "real": {"class": "homebot.gateways.memory:MemoryGateway"}},
        "places": {"devices": {"lights/roomlights405": {"tags": ["always_ask"]}}},
    }
    async with page(tables=tables, token="hunter2") as own:
        await own.open("#/system", shows="a valid token is needed")
        await own.write("input[type=password]", "hunter2")
        await own.click("form button")
        await own.shows("Waiting for your approval")
        await own.click("button[aria-label='show what approving roomlights405 allows']")
        await own.shows("home425/lights/roomlights405", ".box")
        await own.click(".box button")
        await own.hides("roomlights405")
        assert own.problems() == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1200, 390])
async def test_axe_finds_nothing_serious(page: Any, axe: str, scheme: str, width: int) -> None:
    def judge(browser: Any, view: str) -> list[str]:
        browser.execute_script(axe)
        found = browser.execute_async_script("axe.run().then(r => arguments[0](r.violations))")
        serious = [one for one in found if one["impact"] in {"serious", "critical"}]
        return [f"{view} {one['id']}: {one['nodes'][0]['html']}" for one in serious]

    async with page() as own:
        chosen = {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
        size = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": width < 600}
        own.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", chosen)
        own.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        found = []
        for view, shown in (
            ("", "roomlights405"),
            ("#/device/lights%2Froomlights405", "What is known"),
            ("#/plan", "Room 405"),
            ("#/journal", "every step"),
            ("#/system", "Nothing is wrong."),
            ("#/graph", "/discovery/states"),
            ("#/rates", "messages lost"),
        ):
            await own.open(view, shows=shown)
            found += await to_thread.run_sync(partial(judge, own.browser, view))
        own.browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        assert found == []


async def test_the_committed_page_is_what_its_source_builds(tmp_path: Path) -> None:
    """`make page` was run after the last change."""
    home = node_folder(SOURCE)
    shutil.copytree(SOURCE, home, dirs_exist_ok=True)
    command = ("npm", "run", "--silent", "build", "--", f"--outdir={tmp_path}")
    done = await to_thread.run_sync(partial(subprocess.run, command, cwd=home, check=False, capture_output=True))
    assert done.returncode == 0, done.stderr[-2000:]
    for name in ("page.js", "page.css"):
        assert (tmp_path / name).read_bytes() == (BUILT / name).read_bytes(), f"{name}: run make page"
