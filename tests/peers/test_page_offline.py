"""The page while homebot is away, and after another one came in its place: killed, updated, and loaded without it."""

import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from tests.patience import PATIENCE
from tests.peers.chromium import Page, chromium
from tests.ports import reserve_door

import homebot

PAUSE = 0.1  # seconds between two attempts
PACKAGE = Path(homebot.__file__).parent
SHOWN = "Who uses it now"
KEPT = "navigator.serviceWorker.ready.then(arguments[0])"
BUILD = "return document.querySelector('meta[name=build]').content"
AWAY = "homebot cannot be reached since"
FAST = """
const wait = setTimeout, now = performance.now.bind(performance);
window.setTimeout = (call, length, ...given) => wait(call, length / 10, ...given);
performance.now = () => 10 * now();
"""
"""The time of the page passes ten times as fast."""
TYPING = "window.typing = setInterval(() => dispatchEvent(new KeyboardEvent('keydown')), 100)"


@pytest.fixture
def browser() -> Iterator[Any]:
    with chromium() as driver:
        yield driver


def wait_for(door: str) -> None:
    """Wait until somebody listens at *door*."""
    host, _, port = door.rpartition(":")
    for _ in range(round(PATIENCE / PAUSE)):
        with closing(socket.socket()) as asking:
            if not asking.connect_ex((host, int(port))):
                return
        time.sleep(PAUSE)
    pytest.fail(f"nobody listens at {door}")


@contextmanager
def program(folder: Path, door: str, package: Path = PACKAGE) -> Iterator[None]:
    """Run the homebot of *package* with its simulated house inside the block; at its end it is killed."""
    environment = {**os.environ, "HOMEBOT_DATA": str(folder / "data"), "PYTHONPATH": str(package.parent)}
    command = [sys.executable, "-m", "homebot", "run", "--door", door]
    with subprocess.Popen(
        command, cwd=folder, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as running:
        try:
            wait_for(door)
            yield
        finally:
            running.kill()
            running.wait(PATIENCE)


def newer(folder: Path) -> Path:
    """Return a copy of the package whose page has another color."""
    package = folder / "newer/homebot"
    shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__", "source"))
    with (package / "web/page/page.css").open("a") as styles:
        styles.write("/* newer */")
    return package


def opened(browser: Any, door: str) -> Page:
    page = Page(browser, cast("Any", SimpleNamespace(port=int(door.rpartition(":")[2]))))
    page.url = f"http://{door}/"
    page.opened("", "devices")
    browser.execute_async_script(KEPT)
    return page


def test_a_page_that_is_loaded_again_without_homebot_shows_the_house_of_before(browser: Any, tmp_path: Path) -> None:
    """The browser's own error page stayed until somebody came by, at each restart."""
    door = reserve_door()
    with program(tmp_path, door):
        page = opened(browser, door)
        before = browser.execute_script(BUILD)
    page.shown(AWAY)
    for view in ("", "#/energy"):
        browser.get("about:blank")
        page.opened(view, AWAY)
        page.shown("Rooms" if not view else SHOWN)
    with program(tmp_path, door):
        page.opened("#/home", "Rooms")
        page.hidden(AWAY)
        assert browser.execute_script(BUILD) == before
    assert not [one for one in page.problems() if "Refused" in one or "violates" in one]


def test_another_homebot_brings_its_page_to_each_screen_that_nobody_touches(browser: Any, tmp_path: Path) -> None:
    door = reserve_door()
    hurry = partial(browser.execute_cdp_cmd, "Page.addScriptToEvaluateOnNewDocument", {"source": FAST})
    hurry()
    with program(tmp_path, door):
        page = opened(browser, door)
        before = browser.execute_script(BUILD)
        first = browser.current_window_handle
        browser.switch_to.new_window("window")
        hurry()  # it holds for one window
        page.opened("#/security", "Doors and windows")
        browser.execute_script(TYPING)
    with program(tmp_path, door, newer(tmp_path)):
        page.hidden(AWAY)
        page.settled()
        assert browser.execute_script(BUILD) == before  # somebody is at it
        browser.execute_script("clearInterval(window.typing)")
        for window in (browser.current_window_handle, first):
            browser.switch_to.window(window)
            page.until(lambda: browser.execute_script(BUILD) != before)
            page.shown("devices")
