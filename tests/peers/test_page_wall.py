"""The page as a panel at a wall: what is worked on the House view itself, by mouse, touch and keyboard."""

import json
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pytest
from anyio import to_thread
from tests.peers.chromium import Page, axe_program, chromium, opened_page

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
COVER = "[role=group][aria-label='Big cover'] button[aria-label={}]"
WARMER = "[role=group][aria-label='heating: heating setpoint'] button[aria-label=more]"
ROUTINES = [
    {"name": "Evening", "when": ["22:00"], "do": ["lamp on, 40 %"], "enabled": False},
]
FILM = ("Film", "lamp", "on, 20 %")
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


SAVE_SCENE = """
const [token, name, target, value, done] = arguments;
const socket = new WebSocket(`${location.origin.replace(/^http/, "ws")}/?token=${token}`);
const change = (args) => socket.send(JSON.stringify({ op: "call_service", service: "/scenes/change", args }));
socket.onopen = () => change({ name, change: "save", target });
socket.onmessage = () => {
  socket.onmessage = (event) => socket.close() || done(JSON.parse(event.data).values.message);
  change({ name, change: "edit", values: [{ key: target, value }] });
};
"""
"""Saves a scene of a device or query, with the values in words."""


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
async def test_a_cover_is_closed_on_the_house_view(browser: Any, world: World, hand: str) -> None:
    async with opened_page(browser, world) as own:
        await own.open(shows="Big cover")
        await own.shows("open", ".devices")
        await work(own, hand, COVER.format("close"))
        await own.shows("Big cover: confirmed after", "[role=alert]")
        await own.shows("closed", ".devices")
        assert own.problems() == []


@pytest.mark.parametrize("hand", HANDS)
async def test_a_thermostat_is_made_warmer_on_the_house_view(browser: Any, world: World, hand: str) -> None:
    """Of several presses the last number is sent."""
    async with opened_page(browser, world) as own:
        await own.open(shows="20 °C")
        for _ in range(3):
            await work(own, hand, WARMER)
        await own.shows("heating: confirmed after", "[role=alert]")
        await own.shows("21.5 °C", ".stepper output")
        await own.open("#/journal", shows="heating setpoint 21.5 °C")
        await own.hides("heating setpoint 20.5 °C")


async def test_a_row_opens_to_a_slider_and_a_code_without_leaving_the_house(browser: Any, world: World) -> None:
    async with opened_page(browser, world, {"control": {"always_ask": False}}) as own:
        await own.open(shows="Front lock")
        await own.click("button[aria-label='more of Front lock']")
        await own.shows("code, if it needs one", ".devices")
        await own.write("input[name=code]", "4321")
        await own.click("div[aria-label=lock] button:nth-of-type(2)")
        await own.shows("Front lock: refused (gateway): 'lock' was refused: it takes no code", "[role=alert]")
        await own.click("div[aria-label=lock] button:nth-of-type(2)")
        await own.shows("unlocked", ".devices")
        assert own.browser.find_element("css selector", "input[name=code]").get_attribute("value") == ""
        await own.click("button[aria-label='more of Front lock']")
        await own.click("button[aria-label='more of lamp']")
        await own.shows("level", ".commands")
        await own.write("input[type=range]", "\ue011\ue014\ue014")  # Home, and the right arrow twice
        await own.shows("lamp: confirmed after", "[role=alert]")
        await own.shows("on · 2 %", ".devices")
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
        await own.open("#/house", shows="on · 40 %")
        assert own.problems() == []


async def test_a_form_writes_the_text_of_a_routine_which_is_edited_and_removed(browser: Any, world: World) -> None:
    name = 'Film <b>"2"'
    async with opened_page(browser, world, token=OWNER) as own:
        await own.open(f"#token={OWNER}", shows="heating")
        await own.open("#/routines", shows="There is no routine yet.")
        await own.click(".choices button")
        await own.shows("what starts it", "form")
        await own.write("[name=name]", name)
        await own.write("[name=when]", "21:00\n7:30 on weekdays")
        await own.write("[name=steps]", 'lamp on\n{ if = ["sun is down"], do = ["lamp off"] }')
        await own.click("form .buttons button")
        await own.shows("added", "[role=alert]")
        await own.shows(f"{name}\nwhen\n21:00\n7:30 on weekdays\ndo\nlamp on\nif sun is down: lamp off", "section")
        await own.click("section .choices button:nth-of-type(2)")
        await own.write("textarea", "nonsense")
        await own.click("form .buttons button")
        await own.shows("the text", "[role=alert]")
        await own.click("form .buttons button[type=button]")
        for _ in range(2):  # it asks before it removes
            await own.click("section .choices button:nth-of-type(3)")
        await own.shows("There is no routine yet.")
        assert own.problems() == []


@pytest.mark.parametrize("hand", HANDS)
async def test_a_scene_is_applied_and_undone_on_the_house_view(browser: Any, world: World, hand: str) -> None:
    async with opened_page(browser, world, token=OWNER) as own:
        await own.open(f"#token={OWNER}", shows="heating")
        assert await to_thread.run_sync(own.browser.execute_async_script, SAVE_SCENE, OWNER, *FILM) == ""
        await own.open("#/room/Living_Room", shows="Film")
        await own.open(shows="Film")
        await work(own, hand, "button.scene")
        await own.shows("Film: done", "[role=alert]")
        await own.shows("on · 20 %", ".devices")
        await work(own, hand, "button[aria-label='undo Film']")
        await own.shows("Film: undone", "[role=alert]")
        assert own.problems() == []


async def test_a_language_is_chosen_and_kept(browser: Any, world: World) -> None:
    async with opened_page(browser, world) as own:
        await own.open(shows="window covering")
        await own.click("footer option[value=de]")
        await own.shows("Rollladen oder Vorhang")
        await work(own, "mouse", COVER.format("schließen"))
        await own.shows("Big cover: bestätigt nach", "[role=alert]")
        await to_thread.run_sync(own.browser.refresh)
        await own.open("#/journal", shows="der Client local wollte geschlossen: bestätigt nach")
        await own.open("#/device/heating", shows="Solltemperatur")
        assert own.browser.execute_script("return document.documentElement.lang") == "de"
        await to_thread.run_sync(own.browser.execute_script, "localStorage.clear()")


async def test_a_device_is_renamed_placed_tagged_and_hidden(browser: Any, world: World) -> None:
    async with opened_page(browser, world, token=OWNER) as own:
        await own.open(f"#token={OWNER}", shows="heating")
        await own.click("button[aria-label='more of lamp']")
        await own.click(".opened summary")
        for field, text in (("name", " <i>"), ("room", "s"), ("tags", "warm, cosy")):
            await own.write(f".owner [name={field}]", text)
        await own.click(".owner .buttons button")
        await own.shows("there is no room 'living_rooms'; did you mean living_room?", ".owner")
        await own.click(".owner [name=new]")
        await own.click(".owner .buttons button")
        await own.shows("Living rooms", ".room:nth-of-type(2)")
        await own.shows("lamp <i>", ".room:nth-of-type(2)")
        await own.open("#/device/lamp", shows="cosy")
        await own.click(".owner [name=hidden]")
        await own.click(".owner .buttons button")
        await own.shows("saved", ".owner")
        await own.open("#/house", shows="show 1 hidden")
        await own.hides("lamp <i>")
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
        await own.shows("House alarm", ".devices")
        for button in own.browser.find_elements("css selector", "button.more"):
            await to_thread.run_sync(own.browser.execute_script, "arguments[0].click()", button)
        await own.shows("disarmed", "select[name=value]")
        assert MARKUP in await own.shows("level", ".devices") + await own.shows("smoke or heat", ".alert")
        for view in ("", "#/plan", "#/journal", f"#/device/{quote(MARKUP)}", f"#/room/{quote(MARKUP)}attic"):
            assert own.browser.find_elements("css selector", "main img, main b") == []
            assert await to_thread.run_sync(own.overflow) == 0
            assert await to_thread.run_sync(own.complaints, axe) == []
            await own.open(view, shows="devices")
        own.browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        assert own.problems() == []
