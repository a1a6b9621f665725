"""The page of a house that has been lived in: what its views look like in the evening of a family's day.

With ``HOMEBOT_WRITE_GOLDEN=1`` the pictures of README and documentation are written to ``docs/images``.
"""

import base64
import os
import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path
from random import Random
from typing import Any, ClassVar

import anyio
import pytest
from anyio import to_thread
from anyio.abc import TaskStatus
from tests.peers.chromium import Page, chromium

import homebot
from homebot.clock import LoopClock
from homebot.config import Config, parse_config
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.memory import MemoryGateway
from homebot.house import World
from homebot.house.description import parse_world
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.runtime import Runtime
from homebot.testing.virtual_house import parse_time

FAMILY = Path(homebot.__file__).parent / "house" / "family"
IMAGES = Path(__file__).parents[2] / "docs" / "images"
LARGEST = 100_000  # bytes of a picture
QUALITY = 80  # of WebP
PACE = 12.0  # times the clock, so that an hour of history is half a day of the house
BEGIN = parse_time("2026-11-02 17:41").timestamp()
WRITES = bool(os.environ.get("HOMEBOT_WRITE_GOLDEN"))
LIVED = 3660.0 if WRITES else 300.0  # seconds; the pictures show the house's evening
TOKEN = "hunter2"

STOPPED_CLOCK = f"""
const now = {1000 * (BEGIN + LIVED):.0f};
globalThis.Date = class extends Date {{
  constructor(...given) {{ if (given.length) super(...given); else super(now); }}
  static now() {{ return now; }}
}};
"""
"""The clock of the browser, which stands still as that of homebot does."""

SCREEN, WALL, PHONE = (1280, 900), (1280, 800), (390, 844)
HEAT = "#/device/kitchen_heat"
HOUR = "button[aria-pressed=false]"
LOCK = "button[aria-label='show what approving Front lock allows']"
LAMP = "button[aria-label='more of {} lamp']"
SCENES = [
    {"name": "Dinner", "values": {"lights in kitchen": "on, 60 %"}},
    {"name": "Film", "values": {"lights in living": "on, 20 %"}},
]
ROUTINES = [
    {
        "name": "Hall light at night",
        "when": ["hall motion occupied"],
        "if": ["after 22:00"],
        "do": ["hall lamp on, 20 %", "wait until hall motion clear for 2m, at most 30m", "undo"],
        "mode": "restart",
    },
    {"name": "Good night", "when": ["22:30 on weekdays"], "do": ["all lights off", "notify Good night"]},
]

EACH = {
    "home": ("", "Kitchen lamp", ""),
    "room": ("#/room/living", "Living lamp", ""),
    "sheet": ("#/room/living", "Living lamp", LAMP.format("Living")),
    "security": ("#/security", "Doors and windows", ""),
    "climate": ("#/climate", "Kitchen", ""),
    "plan": ("#/plan", "Kitchen lamp", ""),
    "routines": ("#/routines", "Good night", ""),
    "journal": ("#/journal", "confirmed after", ""),
    "system": ("#/system", "Waiting for your approval", ""),
}
"""By view: its address, a text of it, what is clicked."""

ENERGY = {"energy": ("#/energy", "on other days like this", "")}


def drawn(views: dict[str, tuple[str, str, str]]) -> list[tuple[str, tuple[int, int], str, str, str, str, str]]:
    """Return how *views* look at a wall and on a phone, by day and by night."""
    return [
        (f"{view}-{place}-{scheme}", size, scheme, "en", *shown)
        for view, shown in views.items()
        for place, size in (("wall", WALL), ("phone", PHONE))
        for scheme in ("light", "dark")
    ]


VIEWS = (
    *(drawn(EACH) if WRITES else ()),
    ("", WALL, "light", "en", "", "Kitchen lamp", ""),
    ("phone-de", PHONE, "dark", "de", "", "Kitchen lamp", ""),
    ("", WALL, "dark", "en", "#/room/living", "Living lamp", ""),
    ("", PHONE, "dark", "en", "#/room/living", "Living lamp", LAMP.format("Living")),
    ("", WALL, "light", "en", "#/security", "Doors and windows", ""),
    ("", WALL, "dark", "en", "#/climate", "Kitchen", ""),
    ("", WALL, "light", "en", "#/energy", "Who uses it now", ""),
    ("", PHONE, "light", "fr", "#/security", "Portes et fenêtres", ""),
    ("", PHONE, "dark", "nl", "#/climate", "Kitchen", ""),
    ("", PHONE, "light", "it", "#/energy", "Chi la usa adesso", ""),
    ("", PHONE, "light", "es", "#/room/kitchen", "Kitchen lamp", ""),
    ("device", (1280, 820), "light", "en", HEAT, "Why", HOUR),
    ("", SCREEN, "light", "en", "#/plan", "Kitchen lamp", ""),
    ("", PHONE, "dark", "de", "#/system", "Wartet auf deine Freigabe", ""),
    ("people-phone", PHONE, "light", "de", "#/setup/people", "Handy im Netz", ""),
    ("addresses-phone", PHONE, "dark", "de", "#/setup/alerts", "Testnachricht senden", ""),
    ("backup-phone", PHONE, "light", "en", "#/setup/backup", "make a backup", ""),
    ("pairing", WALL, "dark", "en", "#/setup/devices", "Bridge", ""),
    ("pairing-phone", PHONE, "light", "de", "#/setup/devices", "Bridge", "form[aria-label=Bridge] button"),
    ("approval", (1280, 480), "light", "en", "#/system", "Waiting for your approval", LOCK),
    ("", SCREEN, "light", "fr", "#/device/lamp_meter", "Énergie par jour", ""),
    ("", SCREEN, "light", "es", "#/journal", "confirmado tras", ""),
    ("", SCREEN, "light", "nl", "#/graph", "/discovery/states", ""),
    ("", PHONE, "dark", "it", HEAT, "Perché", HOUR),
    ("", PHONE, "dark", "de", "#/plan", "Kitchen lamp", ""),
    ("", PHONE, "dark", "en", "#/system", "Waiting for your approval", LOCK),
    ("", PHONE, "dark", "fr", "#/journal", "confirmé après", ""),
    ("", PHONE, "dark", "nl", "#/routines", "Good night", ""),
    ("", PHONE, "dark", "es", "#/graph", "/discovery/states", ""),
)
"""Views: name of the picture, size of the window, color scheme, language, address, a text of it, what is clicked."""


class Meters(MemoryGateway):
    """Counts what a house and some of its devices use, each hour."""

    WATTS: ClassVar = {
        "house": ("House", "hall", 410.0),
        "fridge": ("Fridge", "kitchen", 62.0),
        "oven": ("Oven", "kitchen", 88.0),
        "washer": ("Washing machine", "bathroom", 55.0),
        "desk": ("Desk", "study", 41.0),
    }
    """Name, room and usual power of each."""

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        part = simple_part("electrical_meter", readable=("power", "energy"))
        for key, (name, room, _) in self.WATTS.items():
            self.devices.put(GatewayDevice(key, name, (part,), area=room), "new")
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._count)
            await super().serve(task_status=task_status)

    async def _count(self) -> None:
        used, chance = dict.fromkeys(self.WATTS, 100.0), Random(2)  # noqa: S311 - the same each time
        while True:
            for key, (_, _, watts) in self.WATTS.items():
                now = watts * chance.uniform(0.5, 1.5)
                used[key] += now / 1000
                await self.devices.report(key, {"power": round(now), "energy": round(used[key], 3)})
            await anyio.sleep(3600)


@pytest.fixture
def browser() -> Iterator[Any]:
    with chromium() as driver:
        yield driver


def home() -> Config:
    """The configuration of the family's home at its pace here; the owner has not approved its lock yet."""
    tables = tomllib.loads((FAMILY / "home.toml").read_text("utf-8"))
    tables["door"] = {"port": 0, "token": TOKEN}
    tables["routines"] = ROUTINES
    tables["scenes"] = SCENES
    tables["gateways"]["mqtt"]["stale_after"] = "50s"
    tables["gateways"]["real"] = {"class": "homebot.gateways.memory:MemoryGateway"}
    tables["gateways"]["hub"] = {"class": "tests.peers.test_page_pairing:Hub", "act": True}
    tables["apps"]["lights_out"]["quiet_after"] = "45s"
    tables["apps"]["window_heating"]["open_for"] = "10s"
    tables["control"]["presence_guard"]["absent_after"] = "40s"
    return parse_config(tables, "test")


def family() -> World:
    tables = tomllib.loads((FAMILY / "house.toml").read_text("utf-8"))
    tables["house"]["pace"] = PACE
    tables["devices"]["robot"]["speed"] = 0.15
    tables["devices"]["front_lock"] = {"kind": "lock", "room": "hall"}
    tables["devices"]["lamp_meter"] = {"kind": "power_meter", "room": "living", "of": "living_lamp"}
    return parse_world(tables, "house.toml")


@pytest.mark.virtual_time
async def test_every_view_of_a_house_that_is_lived_in_fits(browser: Any) -> None:
    async with MemoryBroker() as broker:
        runtime = Runtime(
            home(),
            house=family(),
            robot="robot",
            clock=LoopClock(BEGIN),
            services=(HostedBroker.in_memory(broker),),
            random=Random(1),  # noqa: S311 - the same day each time
        )
        async with runtime:
            await anyio.sleep(LIVED)
            assert runtime.rosbridge is not None
            # Virtual time stands still while a thread works.
            await to_thread.run_sync(look, Page(browser, runtime.rosbridge))


def look(page: Page) -> None:
    """Open every view, as wide as a screen and as a phone, and write the pictures if they are asked for."""
    begin(page, "Kitchen lamp")
    approve(page, "Kitchen window")
    show(page, VIEWS)


def begin(page: Page, shows: str) -> None:
    """Open Home with the clock of the house."""
    page.browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": STOPPED_CLOCK})
    page.browser.execute_cdp_cmd("Emulation.setTimezoneOverride", {"timezoneId": "UTC"})
    page.prefer("light")
    page.resize(*SCREEN)
    page.opened(f"#token={TOKEN}", shows)


def show(page: Page, views: Iterable[tuple[str, tuple[int, int], str, str, str, str, str]]) -> None:
    """Open *views*, which fit their windows, and write those with a name."""
    for picture, (width, height), scheme, language, view, shows, clicked in views:
        page.prefer(scheme)
        page.resize(width, height)
        page.opened("#/more", "English")
        page.clicked(f"[name=language] option[value={language}]")
        page.browser.execute_script("document.activeElement.blur()")
        page.opened(view, shows)
        if clicked:
            page.clicked(clicked)
        page.settled()
        assert page.overflow() == 0, f"{view} at {width} pixels"
        if picture and WRITES:
            write(page, picture, width, height)
    assert page.problems() == []


def approve(page: Page, name: str) -> None:
    """Approve the device of that name, which leaves the front door's lock to be approved."""
    page.opened("#/system", "Waiting for your approval")
    page.clicked(f"button[aria-label='show what approving {name} allows']")
    page.clicked(".box button")
    page.settled()


def write(page: Page, name: str, width: int, most: int) -> None:
    """Write the picture of what the page shows, at most as high as *most*; on a phone it has the bar at its end."""
    page.resize(width, min(most, page.height()) if width > PHONE[0] else most)
    found = page.browser.execute_cdp_cmd("Page.captureScreenshot", {"format": "webp", "quality": QUALITY})
    picture = base64.b64decode(found["data"])
    assert len(picture) < LARGEST
    IMAGES.mkdir(exist_ok=True)
    (IMAGES / f"{name}.webp").write_bytes(picture)


@pytest.mark.virtual_time
async def test_energy_is_compared_with_other_days_and_told_by_room_and_device(browser: Any) -> None:
    tables = {
        "home": {"name": "family"},
        "door": {"port": 0, "token": TOKEN},
        "gateways": {"meters": {"class": "tests.peers.test_page_pictures:Meters"}},
        "places": {"devices": {"house": {"tags": ["house meter"]}}},
        "history": {"enabled": True},
    }
    lived = 22 * 86_400.0 + 3 * 3600
    clock = LoopClock(BEGIN + LIVED - lived)
    async with Runtime(parse_config(tables, "test"), clock=clock) as runtime:
        await anyio.sleep(lived)
        assert runtime.rosbridge is not None
        page = Page(browser, runtime.rosbridge)
        await to_thread.run_sync(begin, page, "Kitchen")
        text = await to_thread.run_sync(page.opened, "#/energy", "on other days like this")
        assert "No meter of its own" in text
        await to_thread.run_sync(show, page, drawn(ENERGY))
