"""The order of the page: by use at this time of day, then as the owner changes it, on every screen."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from anyio import to_thread
from tests.peers.chromium import Page, axe_program, chromium, opened_page

from homebot.house import World
from homebot.house.description import load_world

ROOMS = {
    "attic": ("lamp_a", "lamp_b", "lamp_c"),
    "cellar": ("lamp_d", "lamp_e", "lamp_f"),
    "study": ("lamp_g",),
    "tower": ("lamp_h", "lamp_i"),
}
TILES = ".favorites .tile .name"
ROOM_NAMES = ".rooms .name bdi"
FIRST_ROW = ".edits:first-of-type > .editrow:first-child"
ROW = ".editrow[data-step='{}']"


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as driver:
        yield driver


@pytest.fixture
def world(tmp_path: Path) -> World:
    lamps = [(lamp, room) for room, lamps in ROOMS.items() for lamp in lamps]
    rooms = "".join(f"[rooms.{room}]\n" for room in ROOMS)
    devices = "".join(f'[devices.{lamp}]\nkind = "lamp"\nroom = "{room}"\n' for lamp, room in lamps)
    (tmp_path / "house.toml").write_text(f'[house]\ndialect = "zigbee2mqtt"\n{rooms}{devices}')
    return load_world(tmp_path / "house.toml")


def texts(page: Page, selector: str) -> list[str]:
    return [one.text for one in page.browser.find_elements("css selector", selector)]


async def test_favorites_and_rooms_are_filled_by_use_when_home_is_opened_not_before(browser: Any, world: World) -> None:
    async with opened_page(browser, world) as own:
        await own.open(shows="Lamp a")
        assert "Lamp g" in (before := texts(own, TILES))
        assert (before.index("Lamp a"), texts(own, ROOM_NAMES)[0]) == (0, "Attic")
        await own.click("[aria-label*='Lamp g'].main")
        await own.shows("Lamp g: confirmed after", "[role=alert]")
        await to_thread.run_sync(own.settled)
        assert (texts(own, TILES), texts(own, ROOM_NAMES)[0]) == (before, "Attic")
        await own.open("#/more", shows="English")
        await own.open("?again#/home", shows="Lamp g")
        assert (texts(own, TILES)[0], texts(own, ROOM_NAMES)[0]) == ("Lamp g", "Study")
        assert own.problems() == []


async def test_stars_order_icons_and_hidden_rooms_are_changed_for_every_screen_and_undone(
    browser: Any, world: World
) -> None:
    axe = await to_thread.run_sync(axe_program)
    async with opened_page(browser, world) as own:
        await own.open(shows="Lamp a")
        wall = browser.current_window_handle
        await to_thread.run_sync(browser.switch_to.new_window, "window")
        try:
            await own.open(shows="Lamp a")
            await own.connected(2)
            await own.click(".edit")
            await own.shows("every screen shows")
            for lamp in ("lamp_d", "lamp_g"):
                await own.click(f"{ROW.format(lamp)} [aria-label$=favorite]")
                await own.shows("Lamp", f"{ROW.format(lamp)}:has([aria-pressed=true])")
            await own.click(f"{ROW.format('lamp_g')} [aria-label$=earlier]")
            await own.shows("Lamp g", FIRST_ROW)
            await to_thread.run_sync(own.focused, "[aria-label='Lamp g: later']")
            await own.click(f"{ROW.format('lamp_a')} [aria-label$='not here']")
            await own.hides("Lamp a", ".edits")
            await own.click(f"{ROW.format('study')} [aria-label$=icon]")
            await own.click(".picks [aria-label=office]")
            await own.click(f"{ROW.format('study')} [aria-label$=earlier]")
            await own.click(f"{ROW.format('cellar')} [aria-label$=hide]")
            await own.shows("", f"{ROW.format('cellar')}:has([aria-pressed=true])")
            assert await to_thread.run_sync(own.complaints, axe) == []
            browser.switch_to.window(wall)
            await own.hides("Cellar", ".rooms")
            assert texts(own, TILES)[:2] == ["Lamp g", "Lamp d"]
            assert "Lamp a" not in texts(own, TILES)
            assert texts(own, ROOM_NAMES)[0] == "Attic"
            await own.open("?again#/home", shows="Lamp g")
            assert texts(own, ROOM_NAMES) == ["Attic", "Study", "Tower"]
            await own.click(".edit")
            await own.click(".editing .ways button")  # undo
            await own.shows("", f"{ROW.format('cellar')}:has([aria-pressed=false])")
        finally:
            browser.switch_to.window(browser.window_handles[-1])
            browser.close()
            browser.switch_to.window(wall)
        assert own.problems() == []
