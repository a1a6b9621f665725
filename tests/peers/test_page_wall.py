"""The page as a panel at a wall: what is worked on Home and in a room, by mouse, touch and keyboard."""

import json
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote

import anyio
import pytest
from anyio import to_thread
from anyio.abc import TaskStatus
from tests.peers.chromium import NEVER_LATER, Page, axe_program, chromium, opened_page
from tests.ports import reserve_port

from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.memory import MemoryGateway
from homebot.house import World
from homebot.house.description import load_world
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions

HOUSE = """
[house]
dialect = "zigbee2mqtt"
[rooms.living_room]
[devices.big_cover]
kind = "cover"
is_open = true
travel_time = 1.0
room = "living_room"
[devices.heating]
kind = "thermostat"
room = "living_room"
[devices.front_lock]
kind = "lock"
room = "living_room"
[devices.lamp]
kind = "lamp"
room = "living_room"
"""
COVER_CARD = ".card[aria-label='Big cover']"
COVER = ".card[aria-label='Big cover'] button[aria-label='Big cover: {}']"
RADIO = ".card[aria-label='Radio']"
WARMER = "[role=group][aria-label='heating: heating setpoint'] button[aria-label=more]"
ROUTINES = [
    {"name": "Evening", "when": ["22:00"], "do": ["lamp on, 40 %"], "enabled": False},
]
SCENES = [
    {"name": "Film", "values": {"lamp": "on, 20 %"}},
    {"name": "Guests", "values": {"front_lock": "unlock"}},
]
READING = {
    "#/room/living_room": ("Guests", "more of Film", "more of Guests"),
    "#/device/lamp": ("30 d", "1 h", "24 h", "7 d", "30 d", "1 y"),
    "#/routines": ("Evening", "look for habits"),
    "#/security": ("Front lock",),
}
"""Views for a page that may only read: a text of each, and its buttons."""

ACTING = "main :is(button:enabled, input, textarea):not(.tile *, .more, .about, .pill)"
"""What acts in a view, beside what opens a sheet."""

SCENE = ".scene button[aria-label='{} Film']"
HANDS = ("mouse", "touch", "keyboard")
MARKUP = "<img src=x onerror=alert(1)><b>"
LONG = "x" * 300
TURNED = "\u202egnp.pmal"
DEVICES: dict[str, dict[str, object]] = {
    "light/evil": {"schema": "json", "brightness": True, "supported_color_modes": ["hs"], "command_topic": "a/set"},
    "light/long": {"command_topic": "b/set"},
    "light/turned": {"command_topic": "c/set"},
    "binary_sensor/smoke": {"device_class": "smoke"},
    "alarm_control_panel/panel": {"command_topic": "d/set", "code": "REMOTE_CODE"},
}
NAMES = {"evil": MARKUP, "long": LONG, "turned": TURNED, "smoke": f"Smoke {MARKUP}", "panel": "House alarm"}
STATES = {"evil": '{"state":"ON","brightness":99,"color":{"h":9,"s":90}}', "smoke": "ON", "panel": "armed_away"}
OWNER = "hunter2-and-some-more"


class Radio(MemoryGateway):
    """Has a player that plays."""

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        part = simple_part("speaker", settable=("playback",), readable=("media_title", "media_artist"))
        self.devices.put(GatewayDevice("radio", "Radio", (part,), area="living_room"), "new")
        values = {"playback": "playing", "media_title": "Blue in Green", "media_artist": "Miles Davis"}
        await self.devices.report("radio", values)
        await super().serve(task_status=task_status)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as driver:
        yield driver


@pytest.fixture
def world(tmp_path: Path) -> World:
    (tmp_path / "house.toml").write_text(HOUSE)
    return load_world(tmp_path / "house.toml")


@pytest.fixture
async def hostile_broker() -> AsyncIterator[MemoryBroker]:
    """A broker that keeps devices whose names would like to be programs, to fill the page, or to turn it around."""
    async with MemoryBroker() as broker:
        options = MqttOptions.from_url(broker.url, client_id="hostile")
        async with MqttConnection(options, broker.make_client, status_topic=None) as connection:
            await connection.wait_connected()
            for place, config in DEVICES.items():
                key = place.partition("/")[2]
                device = {"identifiers": [key], "name": NAMES[key], "suggested_area": f"{MARKUP}attic"}
                found = {"unique_id": key, "device": device, "name": None, "state_topic": f"{key}/state", **config}
                await connection.publish(
                    f"homeassistant/{place}/config", json.dumps(found).encode(), qos=1, retain=True
                )
                await connection.publish(f"{key}/state", STATES.get(key, "ON").encode(), qos=1, retain=True)
        yield broker


async def work(page: Page, hand: str, selector: str) -> None:
    """Work what *selector* finds by mouse, by touch, or by the keyboard alone."""
    match hand:
        case "mouse":
            await page.click(selector)
        case "touch":
            await page.tap(selector)
        case _:
            await to_thread.run_sync(page.tabbed, selector)


@pytest.mark.parametrize("hand", HANDS)
async def test_a_cover_is_closed_in_its_room(browser: Any, world: World, hand: str) -> None:
    async with opened_page(browser, world) as own:
        await own.open("#/room/living_room", shows="Big cover")
        await own.shows("Open", COVER_CARD)
        await work(own, hand, COVER.format("close"))
        await own.shows("Big cover: confirmed after", "[role=alert]")
        await own.shows("Closed", COVER_CARD)
        assert own.problems() == []


@pytest.mark.parametrize("hand", HANDS)
async def test_a_thermostat_is_made_warmer_on_home(browser: Any, world: World, hand: str) -> None:
    """Of several presses the last number is sent."""
    async with opened_page(browser, world) as own:
        await own.open(shows="20 °C")
        for _ in range(3):
            await work(own, hand, WARMER)
        await own.shows("heating: confirmed after", "[role=alert]")
        await own.shows("set to 21.5 °C", ".tile.stepping")
        await own.open("#/journal", shows="heating setpoint 21.5 °C")
        await own.hides("heating setpoint 20.5 °C")


async def test_a_sheet_has_a_slider_and_closes_by_keys_and_by_the_way_back(browser: Any, world: World) -> None:
    async with opened_page(browser, world) as own:
        await own.open(shows="lamp")
        await own.click("button[aria-label='more of lamp']")
        await own.shows("Why", ".sheet")
        await own.click(".dimmer .column button:nth-of-type(3)")
        await own.shows("lamp: confirmed after", "[role=alert]")
        await own.shows("50 %", ".sheet header")
        for leave in ("arguments[0].back()", "dispatchEvent(new KeyboardEvent('keydown', { key: 'Escape' }))"):
            await to_thread.run_sync(own.browser.execute_script, leave.replace("arguments[0]", "history"))
            await own.hides("Why")
            await to_thread.run_sync(own.focused, "button[aria-label='more of lamp']")
            await own.click("button[aria-label='more of lamp']")
            await own.shows("Why", ".sheet")
        assert own.problems() == []


@pytest.mark.parametrize("hand", HANDS)
async def test_a_routine_is_switched_on_and_run(browser: Any, world: World, hand: str) -> None:
    async with opened_page(browser, world, {"routines": ROUTINES}, token=OWNER) as own:
        await own.open(f"#token={OWNER}", shows="heating")
        await own.open("#/routines", shows="lamp on, 40 %")
        await work(own, hand, "[role=switch][aria-label=Evening][aria-checked=false]")
        await own.shows("Evening", "section:has([aria-checked=true])")
        await work(own, hand, "section .choices button")
        await own.shows("last runs", "section")
        await own.open("#/house", shows="40 %")
        assert own.problems() == []


@pytest.mark.parametrize("hand", HANDS)
async def test_a_form_writes_the_text_of_a_routine_which_is_edited_and_removed(
    browser: Any, world: World, hand: str
) -> None:
    name = 'Film <b>"2"'
    async with opened_page(browser, world, token=OWNER) as own:
        await own.open(f"#token={OWNER}", shows="heating")
        await own.open("#/routines", shows="There is no routine yet.")
        await work(own, hand, ".choices button")
        await own.shows("what starts it", "form")
        await own.write("[name=name]", name)
        await own.write("[name=when]", "21:00\n7:30 on weekdays")
        await own.write("[name=steps]", 'lamp onn\n{ if = ["lamp is on"], do = ["lamp off"] }')
        await work(own, hand, "form .buttons button")
        await own.shows("'lamp onn' is no step", "form [role=alert]")
        assert own.browser.execute_script("return getSelection().toString()") == '"lamp onn"'
        await own.clear("[name=steps]")
        await own.write("[name=steps]", 'lamp on\n{ if = ["lamp is on"], do = ["lamp off"] }')
        await work(own, hand, "form .buttons button")
        await own.shows("added", "[role=alert]")
        await own.shows(f"{name}\nwhen\n21:00\n7:30 on weekdays\ndo\nlamp on\nif lamp is on: lamp off", "section")
        await work(own, hand, "section .choices button:nth-of-type(2)")
        await own.write("textarea", "nonsense")
        await work(own, hand, "form .buttons button")
        await own.shows("the text", "form [role=alert]")
        await work(own, hand, "form .buttons button[type=button]")
        for _ in range(2):  # it asks before it removes
            await work(own, hand, "section .choices button:nth-of-type(3)")
        await own.shows("There is no routine yet.")
        assert own.problems() == []


async def test_a_thermostat_tells_the_next_change_of_its_schedule(browser: Any, world: World) -> None:
    routines = [
        {"name": name, "when": [when], "do": [f"heating to {warm} °C"]}
        for name, when, warm in (("Night", "22:30 on mondays", 18), ("Day", "6:00 on tuesdays", 21))
    ]
    async with opened_page(browser, world, {"routines": routines}) as own:
        text = await own.open("#/climate", shows="heating to")
        assert text.count("heating to") == 1
        await own.click(".climate .link")
        await own.shows("heating to", ".sheet")


async def test_a_ready_made_routine_asks_for_its_devices_and_is_saved(browser: Any, world: World) -> None:
    async with opened_page(browser, world, token=OWNER) as own:
        await own.open(f"#token={OWNER}", shows="heating")
        await own.open("#/routines", shows="There is no routine yet.")
        await own.click(".choices button:nth-of-type(2)")
        await own.shows("A plug goes off at night")
        await own.click("[name=heating_night]")
        await own.shows("heating", "[name=heater]")
        await own.click("form .buttons button")
        await own.shows("the text", "form")
        await own.click("form .buttons button")
        await own.shows("added", "[role=alert]")
        await own.shows("'heating' to 18 °C", "main")
        assert own.problems() == []


@pytest.mark.parametrize("hand", HANDS)
async def test_a_scene_is_applied_and_undone_on_home(browser: Any, world: World, hand: str) -> None:
    async with opened_page(browser, world, {"scenes": SCENES}) as own:
        await own.open("#/room/Living_Room", shows="Film")
        await own.open(shows="Film")
        await work(own, hand, ".scene button")
        await own.shows("Film: done", "[role=alert]")
        await own.shows("20 %", ".tile.lit")
        await work(own, hand, SCENE.format("undo"))
        await own.shows("Film: undone", "[role=alert]")
        await own.open("#/device/lamp", shows="asked for off, as the scene Film was undone")
        assert own.problems() == []


@pytest.mark.parametrize("hand", HANDS)
async def test_a_scene_is_saved_edited_and_removed(browser: Any, world: World, hand: str) -> None:
    async with opened_page(browser, world, token=OWNER) as own:
        await own.open(f"#token={OWNER}", shows="heating")
        await own.open("#/room/living_room", shows="New scene")
        await work(own, hand, ".scenes > button")
        await own.write("form [name=name]", MARKUP)
        for device in ("lamp", "heating"):
            box = f"[name=device][value={device}]"
            await work(own, hand, box if hand == "keyboard" else f"label:has({box})")
        await work(own, hand, "form .buttons button")
        await own.shows(MARKUP, ".scene")
        await work(own, hand, ".scene [aria-expanded=false]")
        await own.write("form [name=value1]", ", 30 %")
        await own.write("form [name=name]", "!")
        await own.clear("form [name=value0]")
        await work(own, hand, "form .buttons button")
        await own.shows("these contradict each other", "[role=alert]")
        await own.clear("form [name=value1]")
        await own.write("form [name=value1]", "on, 30 %")
        await work(own, hand, "form .buttons button")
        await own.shows(f"{MARKUP}!", ".scenes")
        await work(own, hand, ".scene button")
        await own.shows("30 %", ".tile.lit")
        await work(own, hand, ".scene [aria-expanded=false]")
        await own.hides("heating", "form")
        for _ in range(2):  # it asks before it removes
            await work(own, hand, "form .buttons button:nth-of-type(3)")
        await own.hides(MARKUP)
        assert own.problems() == []


async def test_a_scene_that_unlocks_is_applied_once_a_person_agrees(browser: Any, world: World) -> None:
    async with opened_page(browser, world, {"scenes": SCENES}, token=OWNER) as own:
        await own.open(f"#token={OWNER}", shows="Guests")
        for button in (2, 1):
            await own.click(".scene:nth-of-type(2) button")
            await own.shows("Guests: Front lock", "[aria-label=question]")
            await own.click(f"[aria-label=question] button:nth-of-type({button})")  # a touch is not enough
        await own.hold("[aria-label=question] .hold")
        await own.shows("Guests: done", "[role=alert]")
        await own.shows("Unlocked", ".tile.open")
        assert own.problems() == []


async def test_a_page_that_may_only_read_shows_everything_and_has_no_button_that_acts(
    browser: Any, world: World
) -> None:
    async with opened_page(browser, world, {"scenes": SCENES, "routines": ROUTINES}, scope=["read"]) as own:
        for view, (text, *buttons) in READING.items():
            await own.open(view, shows=text)
            await to_thread.run_sync(own.settled)
            found = own.browser.find_elements("css selector", ACTING)
            texts = [one.get_attribute("aria-label") or one.text for one in found if one.is_displayed()]
            assert texts == buttons, view
            await own.hides("Hold to")
            await own.hides("Commands")
        assert own.problems() == []


async def test_a_language_is_chosen_and_kept(browser: Any, world: World) -> None:
    async with opened_page(browser, world) as own:
        await own.open("#/system", shows="This screen")
        await own.click("[name=language] option[value=de]")
        await own.shows("Dieser Bildschirm")
        await own.open("#/room/living_room", shows="Lichter")
        await work(own, "mouse", COVER.format("schließen"))
        await own.shows("Big cover: bestätigt nach", "[role=alert]")
        await to_thread.run_sync(own.browser.refresh)
        await own.open("#/journal", shows="der Client local wollte geschlossen: bestätigt nach")
        await own.open("#/device/heating", shows="Solltemperatur")
        assert own.browser.execute_script("return document.documentElement.lang") == "de"
        await to_thread.run_sync(own.browser.execute_script, "localStorage.clear()")


async def test_a_first_view_in_another_language_loads_what_it_says_and_no_more(browser: Any, world: World) -> None:
    added = browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": NEVER_LATER})
    async with opened_page(browser, world) as own:
        await own.open(shows="heating")
        await to_thread.run_sync(browser.execute_script, "localStorage.setItem('homebot.language', 'de')")
        await own.open("?german", shows="Favoriten")
        await own.shows("Soll", ".tile.stepping")
        await own.shows("Verriegelt")
        loaded = "return performance.getEntriesByType('resource').map((one) => one.name).join()"
        assert "/de-" in browser.execute_script(loaded)
        assert "/de_late-" not in browser.execute_script(loaded)
        await to_thread.run_sync(browser.execute_script, "localStorage.clear()")
    browser.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", added)


async def test_a_player_says_what_it_plays(browser: Any, world: World) -> None:
    tables: dict[str, object] = {
        "gateways": {"mqtt": {"root": "home425"}, "radio": {"class": f"{__name__}:Radio", "act": True}}
    }
    async with opened_page(browser, world, tables) as own:
        await own.open("#/room/living_room", shows="Playing · Blue in Green · Miles Davis")
        await own.click(f"{RADIO} .chief")
        await own.shows("Paused", RADIO)


async def test_a_device_is_renamed_placed_tagged_and_hidden(browser: Any, world: World) -> None:
    async with opened_page(browser, world, token=OWNER) as own:
        await own.open(f"#token={OWNER}", shows="heating")
        await own.click("button[aria-label='more of lamp']")
        await own.click(".sheet summary")
        for field, text in (("name", " <i>"), ("room", "s"), ("tags", "warm, cosy")):
            await own.write(f".fields [name={field}]", text)
        await own.click(".fields .buttons button")
        await own.shows("there is no room 'living_rooms'; did you mean living_room?", ".fields")
        await own.click(".fields [name=new]")
        await own.click(".fields .buttons button")
        await own.open("#/room/living_rooms", shows="lamp <i>")
        await own.open("#/device/lamp", shows="cosy")
        await own.click(".fields [name=hidden]")
        await own.click(".fields .buttons button")
        await own.shows("saved", ".fields")
        await own.open("#/house", shows="show 1 hidden")
        await own.hides("lamp <i>", ".tiles")
        await own.click("button[aria-pressed=false]")
        await own.shows("lamp <i>")
        assert own.problems() == []


async def test_the_page_installs_on_a_tablet_and_begins_with_the_room_of_its_wall(browser: Any, world: World) -> None:
    async with opened_page(browser, world) as own:
        await own.open("#/room/living_room", shows="Big cover")
        errors = await to_thread.run_sync(browser.execute_cdp_cmd, "Page.getInstallabilityErrors", {})
        assert errors["installabilityErrors"] == []
        await to_thread.run_sync(browser.get, "about:blank")
        await own.open("?installed", shows="Big cover")
        assert browser.current_url.endswith("#/room/living_room")
        assert browser.title == "Living room · villa"
        assert own.problems() == []


@pytest.mark.parametrize("width", [1280, 390])
async def test_hostile_names_are_names_and_everything_open_has_no_complaint_of_axe(
    browser: Any, hostile_broker: MemoryBroker, width: int
) -> None:
    axe = await to_thread.run_sync(axe_program)
    async with opened_page(browser, services=(HostedBroker.in_memory(hostile_broker),)) as own:
        own.resize(width, 800)
        await own.open(shows="is there a fire?")
        await own.click("button[aria-label='more of House alarm']")
        await own.shows("Disarmed", ".sheet .modes")
        assert await to_thread.run_sync(own.complaints, axe) == []
        await own.open(shows="smoke or heat")
        assert MARKUP in await own.shows("smoke or heat", ".banner")
        for view in ("", "#/plan", "#/journal", f"#/device/{quote(MARKUP)}", f"#/room/{quote(MARKUP)}attic"):
            assert own.browser.find_elements("css selector", "main img, main b") == []
            assert await to_thread.run_sync(own.overflow) == 0
            assert await to_thread.run_sync(own.complaints, axe) == []
            await own.open(view, shows="Home")
            await to_thread.run_sync(own.until, lambda: own.browser.find_elements("css selector", "h1"))
        own.browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        assert own.problems() == []


async def test_cameras_show_their_newest_picture_and_say_if_there_is_none(browser: Any, world: World) -> None:
    port = reserve_port()
    tables = {
        "Porch": {"url": f"http://127.0.0.1:{port}/icon.png"},
        "lamp": {"url": f"http://127.0.0.1:{port}/icon.png"},
        "Gate": {"url": f"http://127.0.0.1:{port}/page.js"},
    }
    drawn = "return [...document.querySelectorAll(`${arguments[0]} img`)].filter((one) => one.naturalWidth).length"
    async with opened_page(browser, world, {"pictures": tables}, port=port) as own:
        text = await own.open("#/security", shows="no JPEG, PNG, GIF or WebP")
        assert "Porch" in text
        assert text.count("picture") == 1  # that there is none stood there twice
        await to_thread.run_sync(own.until, lambda: browser.execute_script(drawn, "main") == 2)
        await own.open("#/room/living_room", shows="lamp")
        await own.click("button[aria-label='more of lamp']")
        await to_thread.run_sync(own.until, lambda: browser.execute_script(drawn, ".sheet") == 1)
        await own.click("button[aria-label=close]")
        assert own.problems() == []
