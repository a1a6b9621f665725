"""Debian's Chromium, driven by selenium, with the page of a running homebot in it."""

import os
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path
from typing import Any, Protocol

import pytest
from anyio import to_thread
from tests.patience import PATIENCE
from tests.peers.network import missing_programs
from tests.peers.node_package import node_folder

from homebot.config import parse_config
from homebot.house import World, thesis_world
from homebot.mqtt.clients import HostedBroker
from homebot.runtime import Runtime

NAME = "house.example"
"""A name of this computer, for the browser alone."""

SMALLEST_TARGET = 44
"""Pixels of CSS that a finger needs: WCAG 2.2, success criterion 2.5.5."""

NEVER_LATER = """
const later = setTimeout;
globalThis.setTimeout = (work, delay) => (delay === 2000 ? 0 : later(work, delay));
"""
"""Lets nothing be loaded two seconds after the first view."""

_AXE = """
const done = arguments[0];
const isInvisible = (node) => node.any.some((check) => check.data?.messageKey === "equalRatio");
axe.run({ resultTypes: ["violations", "incomplete"] }).then(({ violations, incomplete }) => {
  const unseen = incomplete.filter((one) => one.id === "color-contrast" && one.nodes.some(isInvisible));
  done([...violations, ...unseen.map((one) => ({ ...one, nodes: one.nodes.filter(isInvisible) }))]);
});
"""
"""A text in the colour of its background is left to a person by axe, and is an error here."""

_PLACE = """
arguments[0].scrollIntoView({ block: "center" });
const box = arguments[0].getBoundingClientRect();
return [box.x + box.width / 2, box.y + box.height / 2, box.width, box.height];
"""

_HAS_FOCUS = "return document.activeElement === document.querySelector(arguments[0])"

_FLAGS = (
    "--headless=new",
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--hide-scrollbars",
    "--lang=en",
    "--window-size=1200,900",
    f"--host-resolver-rules=MAP {NAME} 127.0.0.1",
    "--ignore-certificate-errors",
)


@contextmanager
def chromium() -> Iterator[Any]:
    """Run Chromium without a window inside the block; the test is skipped where it is not installed."""
    if missing := missing_programs("chromium", "chromedriver"):
        pytest.skip(f"not installed: {missing} (apt-get install chromium chromium-driver)")
    webdriver: Any = pytest.importorskip("selenium.webdriver", reason="selenium is not installed (make test-peers)")
    service: Any = pytest.importorskip("selenium.webdriver.chrome.service")
    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    for flag in (*_FLAGS, *(["--no-sandbox"] if os.geteuid() == 0 else [])):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=service.Service("/usr/bin/chromedriver"))
    try:
        yield driver
    finally:
        driver.quit()


def axe_program() -> str:
    """Return the program that checks accessibility; the test is skipped where it cannot be installed."""
    return (node_folder(Path(__file__).parent / "page") / "node_modules/axe-core/axe.min.js").read_text()


_CONFIRM = 1.0
"""Seconds after which the page takes a hold for a yes."""

_SHORT_HOLD = """
const [x, y, seconds, done] = arguments;
const found = document.elementFromPoint(x, y);
const point = { clientX: x, clientY: y, isPrimary: true, pointerId: 7, pointerType: "touch" };
const at = { bubbles: true, cancelable: true, ...point };
found.dispatchEvent(new PointerEvent("pointerdown", at));
setTimeout(() => {
  found.dispatchEvent(new PointerEvent("pointerup", at));
  found.dispatchEvent(new MouseEvent("click", { ...at, detail: 1 }));
  done();
}, 1000 * seconds);
"""
"""A touch that ends by a timer of the page, before a later one; that of the driver may come late on a slow machine."""


class Door(Protocol):
    """What a page needs of its door."""

    @property
    def port(self) -> int: ...

    @property
    def client_count(self) -> int: ...


class Page:
    """The page of one running homebot. The browser is asked from a thread, in which homebot goes on."""

    def __init__(self, browser: Any, door: Door) -> None:
        self.browser = browser
        self.door = door
        self.url = f"http://127.0.0.1:{door.port}/"
        browser.get_log("browser")  # that of the page before

    async def open(self, view: str = "", *, shows: str) -> str:
        """Open *view* and return its text as soon as it has the text *shows*."""
        return await to_thread.run_sync(lambda: self.opened(view, shows))

    def opened(self, view: str, shows: str) -> str:
        """Do the same in the thread of the caller."""
        self.browser.get(f"{self.url}{view}")
        return self.shown(shows, "#page")

    async def shows(self, text: str, place: str = "#page") -> str:
        return await to_thread.run_sync(self.shown, text, place)

    async def hides(self, text: str, place: str = "#page") -> None:
        await to_thread.run_sync(self.hidden, text, place)

    def hidden(self, text: str, place: str = "#page") -> None:
        """Wait until *place* has *text* no more, in the thread of the caller."""
        self.until(lambda: text not in self._text(place))

    async def connected(self, clients: int) -> None:
        """Wait until the door has so many clients."""
        await to_thread.run_sync(lambda: self.until(lambda: self.door.client_count == clients))

    async def click(self, selector: str) -> None:
        await to_thread.run_sync(lambda: self.clicked(selector))

    def clicked(self, selector: str) -> None:
        """Click the element of *selector* as soon as nothing covers it, in the thread of the caller.

        What is drawn between the look and the click may move it below the bar.
        """
        self.until(lambda: self._is_clicked(selector))

    def _is_clicked(self, selector: str) -> bool:
        found = self.browser.find_elements("css selector", selector)
        if found:
            self.browser.execute_script("arguments[0].scrollIntoView({ block: 'nearest' })", found[0])  # above the bar
            found[0].click()
        return bool(found)

    def used(self, selector: str, use: Callable[[Any], object]) -> None:
        """Have *use* do something with the element of *selector*, as soon as it is there and takes it."""
        self.until(lambda: [use(self.browser.find_element("css selector", selector))])

    async def write(self, selector: str, text: str) -> None:
        await to_thread.run_sync(self.used, selector, lambda field: field.send_keys(text))

    def filled(self, selector: str, text: str) -> None:
        """Let the field of *selector* have *text*, in the thread of the caller."""
        self.used(selector, lambda field: field.clear())
        self.used(selector, lambda field: field.send_keys(text))

    async def clear(self, selector: str) -> None:
        await to_thread.run_sync(self.used, selector, lambda field: field.clear())

    def type(self, keys: str) -> None:
        """Press keys, whatever has the focus, in the thread of the caller."""
        pytest.importorskip("selenium.webdriver").ActionChains(self.browser).send_keys(keys).perform()

    async def lacks(self, selector: str) -> None:
        """Wait until there is no element of *selector*."""
        await to_thread.run_sync(self.until, lambda: not self.browser.find_elements("css selector", selector))

    def focused(self, selector: str) -> None:
        """Wait until the element of *selector* has the focus, in the thread of the caller."""
        self.until(lambda: self.browser.execute_script(_HAS_FOCUS, selector))

    def tabbed(self, selector: str) -> None:
        """Press the element of *selector* with the keyboard alone, in the thread of the caller."""
        self.until(lambda: self.browser.find_element("css selector", selector).is_displayed())
        for _ in range(100):  # what has the focus may be drawn anew at any time
            if self.browser.execute_script(_HAS_FOCUS, selector):
                self.type(" ")
                return
            self.type("\ue004")  # Tab
        pytest.fail(f"{selector} is not reached with the tab key")

    def resize(self, width: int, height: int) -> None:
        """Let the window be so large, a phone's if it is narrow."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)

    def become_phone(self) -> None:
        """Be a phone with a touch screen, until :meth:`become_computer`."""
        size = {"width": 390, "height": 844, "deviceScaleFactor": 3, "mobile": True}
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        self.browser.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True, "maxTouchPoints": 5})

    def become_computer(self) -> None:
        self.browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        self.browser.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": False})

    async def tap(self, selector: str) -> None:
        """Touch the element of *selector*, as a finger does: only if nothing covers it, and it is in the window."""
        await to_thread.run_sync(lambda: self.tapped(selector))

    def tapped(self, selector: str) -> None:
        """Do the same in the thread of the caller."""
        x, y, *size = self.placed(selector)
        assert min(size) >= SMALLEST_TARGET, f"{selector} is {size} pixels"
        self.finger("touchStart", (x, y))
        self.finger("touchEnd")

    async def hold(self, selector: str, seconds: float = 1.3) -> None:
        """Keep the finger on the element of *selector* for so long."""
        await to_thread.run_sync(lambda: self.held(selector, seconds))

    def held(self, selector: str, seconds: float) -> None:
        """Do the same in the thread of the caller."""
        x, y, _, _ = self.placed(selector)
        if seconds < _CONFIRM:
            self.browser.execute_async_script(_SHORT_HOLD, x, y, seconds)
            return
        self.finger("touchStart", (x, y))
        self.pass_time(seconds)
        self.finger("touchEnd")

    def placed(self, selector: str) -> tuple[float, float, float, float]:
        """Return the place of the element of *selector*, as soon as it is drawn; see :meth:`place_of`."""

        def place() -> tuple[float, float, float, float] | None:
            found = self.place_of(self.browser.find_element("css selector", selector))
            return found if min(found[2:]) else None

        drawn: tuple[float, float, float, float] = self.until(place)
        return drawn

    def place_of(self, element: Any) -> tuple[float, float, float, float]:
        """Return the middle, the width and the height of *element*, which is in the window then."""
        place: list[float] = self.browser.execute_script(_PLACE, element)
        x, y, width, height = place
        return x, y, width, height

    def finger(self, kind: str, *points: tuple[float, float]) -> None:
        """Let fingers be at *points*: ``touchStart``, ``touchMove`` or ``touchEnd``."""
        found = [{"x": x, "y": y, "id": at} for at, (x, y) in enumerate(points)]
        self.browser.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": found})

    def pass_time(self, seconds: float) -> None:
        """Let time pass in the browser."""
        self.browser.execute_async_script("setTimeout(arguments[1], 1000 * arguments[0])", seconds)

    def prefer(self, scheme: str) -> None:
        """Let the owner prefer *scheme*: light or dark."""
        chosen = {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", chosen)

    def complaints(self, axe: str) -> list[str]:
        """Return the complaints of *axe* about the accessibility of the page."""
        if not self.browser.execute_script("return 'axe' in window"):  # half a megabyte
            self.browser.execute_script(axe)
        found = self.browser.execute_async_script(_AXE)
        return [f"{self.browser.current_url} {one['id']}: {one['nodes'][0]['html']}" for one in found]

    def settled(self) -> None:
        """Wait until homebot has answered, and the answer is drawn."""
        quiet = "const done = arguments[0]; setTimeout(() => requestAnimationFrame(() => setTimeout(done)), 400)"
        self.browser.execute_async_script(quiet)

    def overflow(self) -> int:
        """Return by how many pixels the page is wider than its window."""
        pixels: int = self.browser.execute_script("return document.documentElement.scrollWidth - innerWidth")
        return max(pixels, 0)

    def height(self) -> int:
        """Return the height of the page, in pixels."""
        bottoms = "[...document.querySelectorAll('main *')].map((one) => one.getBoundingClientRect().bottom)"
        pixels: int = self.browser.execute_script(f"return Math.ceil(Math.max(...{bottoms}) + scrollY) + 16")
        return pixels

    def picture(self) -> bytes:
        """Return the picture of the window, as PNG."""
        picture: bytes = self.browser.get_screenshot_as_png()
        return picture

    def problems(self) -> list[str]:
        """Return the errors of the browser, violations of the content security policy among them."""
        return [one["message"] for one in self.browser.get_log("browser") if one["level"] == "SEVERE"]

    def shown(self, text: str, place: str = "#page") -> str:
        """Wait until *place* has *text*, in the thread of the caller."""
        shown: str = self.until(lambda: found if text in (found := self._text(place)) else "")
        return shown

    def _text(self, place: str) -> str:
        text: str = self.browser.find_element("css selector", place).text
        return text

    def until(self, seen: Callable[[], Any]) -> Any:
        """Return what *seen* returns, as soon as that is something, in the thread of the caller."""
        support: Any = pytest.importorskip("selenium.webdriver.support.ui")
        errors: Any = pytest.importorskip("selenium.common.exceptions")
        moving = [
            errors.StaleElementReferenceException,
            errors.ElementClickInterceptedException,
            errors.InvalidElementStateException,  # it is not drawn, or disabled, as yet
        ]
        return support.WebDriverWait(self.browser, PATIENCE, 0.05, moving).until(lambda _: seen())


@asynccontextmanager
async def opened_page(
    browser: Any,
    world: World | None = None,
    tables: dict[str, object] | None = None,
    services: tuple[HostedBroker, ...] = (),
    **door: object,
) -> AsyncIterator[Page]:
    """Run homebot in a simulated house inside the block, and yield its page."""
    gateways = {"gateways": {"mqtt": {"root": "home425"}}}
    home = {"home": {"name": "villa"}, "door": {"port": 0, **door}, **gateways, **(tables or {})}
    config = await to_thread.run_sync(parse_config, home, "test")
    async with Runtime(config, house=world or thesis_world(), robot="robot", services=services) as runtime:
        assert runtime.rosbridge is not None
        try:
            yield Page(browser, runtime.rosbridge)
        finally:
            browser.execute_script("sessionStorage.clear()")
            browser.get("about:blank")
