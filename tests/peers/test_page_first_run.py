"""From an empty folder to a lamp that is switched by a phone's browser: no file is edited, no other command run."""

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from anyio import to_thread
from tests.patience import PATIENCE
from tests.peers.chromium import Page, chromium
from tests.ports import reserve_door, reserve_port

from homebot.clock import LoopClock
from homebot.config import parse_config
from homebot.gateways.mqtt.embedded_broker import embedded_broker
from homebot.graph import Graph
from homebot.house.description import parse_world
from homebot.runtime import Runtime

HOUSE = {
    "house": {"dialect": "zigbee2mqtt"},
    "rooms": {"hall": {}},
    "devices": {"hall_lamp": {"kind": "lamp", "room": "hall"}},
}
LAMP = ".tile:has([aria-label*='lamp'])"


@pytest.fixture
def browser() -> Iterator[Any]:
    with chromium() as driver:
        yield driver


@contextmanager
def new_home(folder: Path) -> Iterator[tuple[int, str]]:
    """Run ``homebot run --new`` in the empty *folder* inside the block; yield the port and the code that it prints."""
    environment = {**os.environ, "HOMEBOT_DATA": str(folder.parent / "data"), "PYTHONUNBUFFERED": "1"}
    command = [sys.executable, "-m", "homebot", "run", "--new", "--door", reserve_door()]
    with subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.PIPE, text=True) as program:
        try:
            assert program.stdout is not None
            found = next(filter(None, (re.search(r":(\d+)/#code=(\w+)", line) for line in program.stdout)))
            yield int(found[1]), found[2]
        finally:
            program.terminate()
            program.wait(PATIENCE)


def set_up(page: Page, code: str, broker: str) -> None:
    """Do what the owner of a new home does, from the code to the first lamp."""
    page.become_phone()
    page.opened(f"#code={code}", "Deutsch")
    page.clicked("a.chief")
    page.filled("[name=latitude]", "48.2")
    page.filled("[name=longitude]", "16.4")
    page.clicked("form .buttons button")
    page.shown("latitude = 48.2")
    page.clicked("a.chief")
    page.clicked("[name=gateway] option[value=mqtt]")
    page.filled("form [name=url]", broker)
    page.clicked("form [name=act]")
    page.clicked("form .buttons button")
    page.shown("[gateways.mqtt]")
    page.clicked("[name=again]")
    page.shown("1 device")
    page.clicked("a.chief")
    page.shown("Hall lamp")
    page.clicked("form .buttons button")
    page.shown("Every device has a room.")
    page.opened("#/home", "Hall lamp")
    page.tapped(f"{LAMP} .main")
    page.shown("%", f"{LAMP}.lit")
    assert page.overflow() == 0


async def test_a_new_home_is_set_up_by_its_page_alone(browser: Any, tmp_path: Path) -> None:
    (folder := tmp_path / "home").mkdir()
    world = parse_world(HOUSE, "house.toml")
    async with embedded_broker(Graph(), LoopClock(), ports=[reserve_port()]) as broker:
        tables = {"home": {"name": "other"}, "gateways": {"mqtt": {"url": broker.url}}}
        config = await to_thread.run_sync(parse_config, tables, "test")
        async with Runtime(config, house=world, house_broker=broker.url, with_door=False):
            await to_thread.run_sync(walk, browser, folder, broker.url)
    text = await to_thread.run_sync((folder / "homebot.toml").read_text)
    assert text.startswith("# The home of this folder.")


def walk(browser: Any, folder: Path, broker: str) -> None:
    with new_home(folder) as (port, code):
        set_up(Page(browser, cast("Any", SimpleNamespace(port=port))), code, broker)


def test_system_adds_people_and_addresses_and_downloads_a_backup(browser: Any, tmp_path: Path) -> None:
    (folder := tmp_path / "home").mkdir()
    with new_home(folder) as (port, code):
        page = Page(browser, cast("Any", SimpleNamespace(port=port)))
        page.opened(f"#code={code}", "Deutsch")
        page.opened("#/system", "Backup")
        page.opened("#/setup/people", "Phone in the network")
        page.filled("[name=name]", "Anna")
        page.filled("[name=ping]", "192.168.1.23")
        page.clicked("form .buttons button")
        page.shown("[people.Anna]")
        page.shown("start homebot again")
        page.clicked("[role=status] button")
        page.shown("undone")
        page.hidden("192.168.1.23")
        page.opened("#/setup/alerts", "send a test message")
        page.filled("[name=url]", "json://127.0.0.1:9/my-secret")
        page.clicked("form .buttons button")
        page.shown("json://…et")
        page.hidden("my-secret")
        page.clicked("[name=test]")
        page.shown("did not answer, or refused it")
        page.clicked("main .box button")
        page.clicked("main .box button.bad")
        page.hidden("json://…et")
        page.opened("#/setup/backup", "make a backup")
        page.clicked("[name=backup]")
        page.shown("was downloaded")
    assert "notify" not in (folder / "homebot.toml").read_text()
