"""The page in Chromium: every view, its accessibility, hostile names, and the build that is committed."""

import json
import os
import re
import shutil
import subprocess
from collections.abc import AsyncIterator, Callable, Iterator, Mapping
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import aiohttp
import anyio
import pytest
from anyio import to_thread
from anyio.abc import SocketAttribute, SocketStream
from tests.hanging_link import HangingLink
from tests.peers.chromium import NEVER_LATER, Page, axe_program, chromium, opened_page
from tests.peers.node_package import node_folder
from tests.web.told_messages import told_messages

from homebot.apps import App
from homebot.house import SimulatedLamp, World
from homebot.house.description import load_world
from homebot.house.devices import SimulatedDoorLock
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions

SOURCE = Path(__file__).parents[2] / "src/homebot/web/source"
BUILT = SOURCE.parent / "page"
TABLES = ("languages.json", "told.json", "reasons.json")
MARKUP = "<img src=x onerror=alert(1)><b>lamp"
LAMP = "#/device/lights%2Froomlights405"
SWITCH = ".tile [role=switch][aria-label*=philips165]"
BACKSPACE = "\ue003"  # of WebDriver
PANEL = {
    "homeassistant/alarm_control_panel/panel/config": json.dumps(
        {"unique_id": "panel", "device": {"identifiers": ["panel"], "name": "panel"}, "name": None}
        | {"state_topic": "panel/state", "command_topic": "panel/set", "code": "REMOTE_CODE"}
    ),
    "panel/state": "armed_away",
}
"""A panel that is kept by the broker alone."""

SMOKE = {
    "homeassistant/binary_sensor/smoke/config": json.dumps(
        {"unique_id": "smoke", "device": {"identifiers": ["smoke"], "name": "Kitchen smoke"}, "name": None}
        | {"state_topic": "smoke/state", "device_class": "smoke"}
    ),
    "smoke/state": "ON",
}

PLUG = {
    f"homeassistant/{kind}/plug/config": json.dumps(
        {"unique_id": kind, "device": {"identifiers": ["plug"], "name": "Plug"}, "state_topic": topic} | more
    )
    for kind, topic, more in (
        ("switch", "plug/state", {"name": None, "command_topic": "plug/set", "device_class": "outlet"}),
        ("sensor", "plug/power", {"name": "Power", "device_class": "power", "unit_of_measurement": "W"}),
    )
} | {"plug/state": "ON", "plug/power": "42"}

RARE = {
    f"homeassistant/{kind}/{key}/config": json.dumps(
        {"unique_id": key, "device": {"identifiers": [device], "name": device}, "state_topic": f"{key}/state"}
        | {"command_topic": f"{key}/set", **more}
    )
    for kind, key, device, more in (
        ("select", "mode", "Heat pump", {"name": "Operating mode", "options": ["Comfort", "Eco"]}),
        ("text", "shown", "Heat pump", {"name": "Display text"}),
        ("number", "volume", "Bell volume", {"name": None}),
        ("event", "bell", "Bell", {"name": None, "event_types": ["ring"]}),
        ("device_tracker", "phone", "Anna's phone", {"name": None}),
    )
} | {"mode/state": "Eco", "shown/state": "Hello", "volume/state": "40", "phone/state": "home"}
"""Devices that few houses have: how Home Assistant announces each."""

VIEWS = (
    ("", "roomlights405"),
    (LAMP, "What is known, and from where"),
    (LAMP, "It is so since homebot first heard of it."),
    ("#/room/Room%20405", "roomlights405"),
    ("#/plan", "Room 405"),
    ("#/plan", "robot: Room 405"),
    ("#/journal", "Nothing has happened yet."),
    ("#/system", "Nothing is wrong."),
    ("#/graph", "/discovery/states"),
    ("#/rates", "Busiest topics"),
    ("#/nonsense", "There is no such view."),
)
"""Views, each with a text that it shows."""

STRANGER = """
const [port, done] = arguments;
const found = [];
const ask = async (path, how) => {
  try {
    found.push(await (await fetch(`http://127.0.0.1:${port}${path}`, how)).text());
  } catch {
    return;
  }
};
const socket = new WebSocket(`ws://127.0.0.1:${port}`, "homebot.log_in");
socket.onopen = () => {
  socket.send(JSON.stringify({ op: "auth", token: "" }));
  socket.send(JSON.stringify({ op: "call_service", service: "/discovery/list" }));
};
socket.onmessage = (event) => {
  found.push(event.data);
  socket.close();
};
socket.onclose = async () => {
  const body = JSON.stringify({ device: "philips165", do: "on" });
  await ask("/api/devices");
  await ask("/api/command", { method: "POST", headers: { "Content-Type": "application/json" }, body });
  await ask("/api/command", { method: "POST", mode: "no-cors", body });
  done(found.filter((text) => text));
};
"""
"""What a page of another program tries; returns what it was answered."""

COVERED = """
scrollTo(0, document.documentElement.scrollHeight);
const last = [...document.querySelectorAll("main section")].at(-1).getBoundingClientRect();
return last.bottom > document.querySelector("[role=alert]").getBoundingClientRect().top;
"""
"""Whether the outcome of a command covers the end of the page, also after it was scrolled there."""

DRAWN_LATE = """
const later = setTimeout;
globalThis.setTimeout = (work, delay) => later(work, delay === 35 ? 1000 : delay);
globalThis.requestAnimationFrame = (work) => later(work, 1000);
"""
"""Lets a second pass before the page's library does what follows a drawing: after a frame, at the latest in 35 ms."""

LISTED_LATE = """
const { send } = WebSocket.prototype;
WebSocket.prototype.send = function (frame) {
  setTimeout(() => send.call(this, frame), frame.includes("/discovery/list") ? 1000 : 0);
};
"""
"""Lets the list of devices be asked for a second later than all else."""

ALWAYS_ASKING = {
    "gateways": {"mqtt": {"root": "home425"}, "real": {"class": "homebot.gateways.memory:MemoryGateway"}},
    "places": {"devices": {"lights/philips165": {"tags": ["always_ask"]}}},
}


ROUTINES = [{"name": "Good night", "when": ["22:30"], "do": ["all lights off"]}]

COMMAND = """
const [target, command, done] = arguments;
const socket = new WebSocket(location.origin.replace(/^http/, "ws"));
const call = { op: "call_service", service: "/devices/command", args: { target, command } };
socket.onopen = () => socket.send(JSON.stringify(call));
socket.onmessage = (event) => socket.close() || done(JSON.parse(event.data).values.outcome);
"""

HOLD = """
const done = arguments[0];
const socket = new WebSocket(location.origin.replace(/^http/, "ws"), "homebot.log_in");
const setting = { capability: "on_off", value: false };
const held = { device: "lights/philips165", setting, lease: "x", by: "rosie", ttl: 600 };
socket.onopen = () => {
  socket.send(JSON.stringify({ op: "auth", token: sessionStorage.getItem("homebot.token") }));
  socket.send(JSON.stringify({ op: "call_service", service: "/control/hold", args: held }));
};
socket.onmessage = (event) => JSON.parse(event.data).service === "/control/hold" && done();
"""
"""Holds a lamp off, as a robot does."""

HISTORY = """
const done = arguments[0];
const socket = new WebSocket(location.origin.replace(/^http/, "ws"));
const call = { op: "call_service", service: "/history/read", args: { device: "plug" } };
const ask = () => socket.send(JSON.stringify(call));
socket.onopen = ask;
socket.onmessage = (event) => (JSON.parse(event.data).result ? socket.close() || done() : setTimeout(ask, 100));
"""
"""Waits for the history, which begins after the start."""
FAST = "const wait = setTimeout; window.setTimeout = (call, length) => wait(call, length / 10)"

BARE_BROWSER = """
globalThis.localStorage = { getItem: () => null, setItem: () => null };
globalThis.document = { documentElement: {} };
Object.defineProperty(globalThis, "navigator", { value: { languages: ["en-GB"] } });
"""
"""What the words of the page need of a browser."""


class Nightly(App):
    """Is called at ten."""

    async def run(self) -> None:
        self.daily("22:00", self.run)


OpenPage: TypeAlias = Callable[..., AbstractAsyncContextManager[Page]]


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as driver:
        yield driver


@pytest.fixture(scope="module")
def axe() -> str:
    return axe_program()


@pytest.fixture
def page(browser: Any) -> OpenPage:
    """Return the function that opens the page of a simulated house."""
    return partial(opened_page, browser)


@pytest.fixture
def zigbee_lamp(tmp_path: Path) -> World:
    house = '[house]\ndialect = "zigbee2mqtt"\n[rooms.hall]\n[devices.lamp]\nkind = "lamp"\nroom = "hall"\n'
    (tmp_path / "house.toml").write_text(house)
    return load_world(tmp_path / "house.toml")


async def test_a_lamp_is_turned_on_and_the_page_says_how_that_is_known(page: OpenPage) -> None:
    async with page() as own:
        await own.open(shows="3 devices")
        assert "villa" in await own.shows("roomlights405")
        await own.click(f"{SWITCH}[aria-checked=false]")
        await own.shows("confirmed after", "[role=alert]")
        await own.click(f"{SWITCH}[aria-checked=true]")
        assert own.problems() == []


async def test_what_always_asks_is_done_once_the_person_at_the_page_agrees(page: OpenPage) -> None:
    """One tap unlocked the front door, and opened the garage."""
    tables = {
        "control": {"always_ask": False},
        "places": {"devices": {"lights/lamp": {"tags": ["always_ask"]}}},
    }
    world = World.of(SimulatedDoorLock("front_door"), SimulatedLamp("lamp"))
    locked = world.devices["front_door"].device.state
    tile = ".tile .main[aria-label*='Front door']"
    async with page(world, tables, token="hunter2") as own:
        await own.open("#token=hunter2", shows="2 devices")
        await own.click(".tile .main[aria-label*=lamp]")  # what the owner lets ask
        await own.shows("Hold to turn on", ".tile .asks")
        await own.open("#/device/locks%2Ffront_door", shows="Hold to unlock")
        await own.click("div[aria-label=lock] .hold")
        await own.open("#/home", shows="Front door")
        await own.click(tile)
        await own.shows("Hold to unlock", ".asks")
        await own.click(".asks .hold")
        await own.hold(".asks .hold", 0.4)
        await own.click(".asks .no")
        await own.hides("Hold to unlock", ".tiles")
        assert locked() == "locked"
        await own.open("#/journal", shows="Nothing has happened yet.")
        await own.open("#/home", shows="Front door")
        await own.click(tile)
        await own.hold(".asks .hold")
        await own.shows("Unlocked", ".tile.open")
        await own.click(tile)
        await own.shows("Locked", ".tile.secure")  # to lock asks nobody
        assert own.problems() == []


async def test_a_routine_gets_the_right_that_it_lacks_and_is_run_once_the_person_at_the_page_agrees(
    page: OpenPage,
) -> None:
    """A tap on "run now" unlocked the front door."""
    world = World.of(SimulatedDoorLock("front_door"))
    fields = {"[name=name]": "Let in", "[name=when]": "7:00", "[name=steps]": "front door unlock"}
    yes, no = ".agreement .hold", ".agreement button:nth-of-type(2)"
    async with page(world, token="hunter2") as own:
        await own.open("#token=hunter2", shows="1 device")
        await own.open("#/routines", shows="There is no routine yet.")
        await own.click(".choices button")
        for field, text in {**fields, "textarea.code": 'act = "light"'}.items():
            await own.write(field, text)
        await own.click("form .buttons button")
        await own.shows("let this routine command light?", ".agreement")
        await own.hold(yes)
        await own.shows("is refused", ".bad")
        for answer in (no, yes):
            await own.click(".bad + .choices button")
            await own.shows("let this routine command Front door?", ".agreement")
            await own.shows("is refused", ".bad")
            await (own.hold if answer == yes else own.click)(answer)
        await own.shows('may command\nlight, id="locks/front_door"', "dl")
        await own.hides("is refused")
        for answer in (no, yes):
            await own.click("section > .choices button")
            await own.shows("Let in: Front door (it is a door lock)?", ".agreement")
            assert world.devices["front_door"].device.state() == "locked"
            await (own.hold if answer == yes else own.click)(answer)
        await own.open("#/device/locks%2Ffront_door", shows="unlocked")
        assert own.problems() == []


async def test_a_person_outranks_the_lease_of_a_robot_once_asked(page: OpenPage) -> None:
    """The token of the owner, which may be any robot too, was refused as one."""
    async with page(token="hunter2") as own:
        await own.open("#token=hunter2", shows="philips165")
        await to_thread.run_sync(own.browser.execute_async_script, HOLD)
        await own.click(f"{SWITCH}[aria-checked=false]")
        await own.shows("held off by rosie", "[role=alert]")
        await own.click("[role=alert] button")
        await own.shows("philips165", ".tile.lit")
        assert own.problems() == []


async def test_a_lamp_is_turned_on_with_the_keyboard_alone(page: OpenPage) -> None:
    async with page() as own:
        await own.open(shows="philips165")
        await to_thread.run_sync(own.tabbed, "[role=switch][aria-label*=philips165]")
        await own.shows("philips165: confirmed after", "[role=alert]")


async def test_each_view_shows_what_homebot_says(page: OpenPage) -> None:
    async with page() as own:
        for view, shown in VIEWS:
            await own.open(view, shows=shown)
        assert own.problems() == []


async def test_the_system_view_shows_what_the_doctor_finds_and_when_jobs_are_due_at_home(page: OpenPage) -> None:
    """It knew of no weak battery, and told the next time in the zone of the browser."""
    tables = {
        "home": {"name": "villa", "zone": "Pacific/Kiritimati"},
        "apps": {"nightly": {"class": "tests.peers.test_page:Nightly"}},
        "places": {"devices": {"lights/roomlights405": {"tags": ["dimmed"]}}},
    }
    async with page(tables=tables) as own:
        await own.open("#/system", shows="Nothing is wrong. To note:")
        await own.shows("HB405 without room:\nphilips165")
        await own.shows("→ homebot place DEVICE ROOM")
        await own.shows("run daily at 22:00, next ")
        await own.shows("22:00 GMT+14")
        await own.shows("Gateway mqtt is active and sends commands")
        await own.click(".entries a")
        await own.shows("What is known, and from where")
        assert own.problems() == []


async def test_a_gateway_is_started_again_on_the_system_view(page: OpenPage) -> None:
    async with page(token="hunter2") as own:
        await own.open("#/system", shows="a valid token is needed")
        await own.write("input[type=password]", "hunter2")
        await own.click("form button")
        await own.shows("Gateway mqtt is active")
        await own.click("section > .buttons > button")
        await own.shows("gateway mqtt starts again", "[role=alert]")
        await own.shows("Gateway mqtt is active")
        assert own.problems() == []


async def test_what_happens_is_in_the_journal_at_once_with_the_reason(page: OpenPage) -> None:
    async with page() as own:
        await own.open("#/device/lights%2Fphilips165", shows="Commands")
        await own.click("div[aria-label='on/off'] button")
        await own.shows("the client local asked for on", "ol")
        await own.open("#/journal", shows="the client local asked for on: confirmed after")
        await own.shows("confirmed after", "ol .quiet")
        await own.write("input[type=search]", "Philips165 CONFIRMED")
        await own.shows("confirmed after", "ol")
        await own.write("input[type=search]", " bedroom")
        await own.shows("has these words")
        await own.hides("confirmed after", "ol")
        assert own.problems() == []


async def test_lines_of_a_full_journal_are_not_drawn_anew_with_each_entry(page: OpenPage) -> None:
    """At 100 changes/s that left seven frames a second."""
    mark = "const lines = [...document.querySelectorAll('ol.log li')]; for (const line of lines) line.isOld = true"
    count = "return [...document.querySelectorAll('ol.log li')].filter((line) => line.isOld).length"
    async with page(World.of(*(SimulatedLamp(f"lamp{number}") for number in range(151)))) as own:
        command = partial(to_thread.run_sync, own.browser.execute_async_script, COMMAND)
        await own.open("#/journal", shows="Nothing has happened yet.")
        assert [await command("lights", word) for word in ("on", "off")] == ["confirmed"] * 2
        await own.open("#/home", shows="151 devices")
        await own.open("#/journal", shows="lamp150")
        await to_thread.run_sync(own.browser.execute_script, mark)
        assert await command("lamp7", "on") == "confirmed"
        await own.shows("asked for on: confirmed after", "ol.log li:first-child")
        assert await to_thread.run_sync(own.browser.execute_script, count) > 0


async def test_a_failed_command_is_red_in_the_journal(page: OpenPage) -> None:
    async with page(tables=ALWAYS_ASKING) as own:
        await own.open("#/device/lights%2Fphilips165", shows="Commands")
        await own.hold("div[aria-label='on/off'] .hold")
        await own.open("#/journal", shows="such a device needs a right")
        await own.shows("such a device needs a right", "ol .bad")


async def test_a_large_house_is_searched_by_words(page: OpenPage) -> None:
    async with page(World.of(*(SimulatedLamp(f"lamp{number}") for number in range(31)))) as own:
        await own.open(shows="31 devices")
        await own.write("input[type=search]", "LAMP7 light")
        await own.hides("lamp8")
        await own.shows("lamp7")
        await own.write("input[type=search]", "x")
        await own.shows("No device has these words")


async def test_a_name_with_markup_is_a_name(page: OpenPage) -> None:
    """Whoever names a device may not run a script at its owner's."""
    async with page(World.of(SimulatedLamp(MARKUP))) as own:
        await own.open(shows=MARKUP)
        assert own.browser.find_elements("css selector", "main img, main b") == []
        assert own.problems() == []


async def test_a_page_of_another_port_of_this_computer_neither_reads_nor_commands(page: OpenPage) -> None:
    async def serve(stream: SocketStream) -> None:
        async with stream:
            await stream.receive()
            await stream.send(b"HTTP/1.1 200 OK\r\nContent-Type: text/html\r\nConnection: close\r\n\r\n<p>game</p>")

    async with page() as own, await anyio.create_tcp_listener(local_host="127.0.0.1") as listener:
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(listener.serve, serve)
            port: int = listener.extra(SocketAttribute.local_port)  # noqa: S610 - of anyio
            door = own.door.port
            await to_thread.run_sync(own.browser.get, f"http://127.0.0.1:{port}/")
            assert await to_thread.run_sync(own.browser.execute_async_script, STRANGER, door) == []
            tasks.cancel_scope.cancel()
        await own.open("#/journal", shows="Nothing has happened yet.")
        # The same script as a part of the page is answered, so it asks rightly.
        answers = await to_thread.run_sync(own.browser.execute_async_script, STRANGER, door)
        assert "philips165" in answers[0]
        assert "confirmed" in answers[2]


async def test_a_page_that_is_not_looked_at_is_not_connected(page: OpenPage) -> None:
    def leave(browser: Any) -> str:
        looked_at: str = browser.current_window_handle
        browser.switch_to.new_window("tab")
        return looked_at

    def come_back(browser: Any, looked_at: str) -> None:
        browser.close()
        browser.switch_to.window(looked_at)

    async with page() as own:
        await own.open(shows="3 devices")
        await own.connected(1)
        looked_at = await to_thread.run_sync(leave, own.browser)
        await own.connected(0)
        await to_thread.run_sync(come_back, own.browser, looked_at)
        await own.connected(1)
        await own.shows("3 devices")


async def test_a_page_behind_a_cut_cable_says_so_and_is_live_again_afterwards(browser: Any, page: OpenPage) -> None:
    """Nothing closed its link, so that it showed old values for ever. Its time passes ten times as fast."""
    added = browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": FAST})
    async with page() as own, HangingLink(own.door.port).running() as cable:
        own.url = f"http://{cable.address.removeprefix('tcp/')}/"
        await own.open(shows="3 devices")
        cable.hang()
        await own.shows("homebot cannot be reached")
        cable.go_on()
        await own.shows("3 devices")
        await own.hides("homebot cannot be reached")
        await own.click(f"{SWITCH}[aria-checked=false]")
        await own.shows("confirmed after", "[role=alert]")
    browser.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", added)


async def test_a_door_with_a_token_shows_nothing_before_it_is_typed_in(page: OpenPage) -> None:
    async with page(token="hunter2") as own:
        text = await own.open(shows="a valid token is needed")
        assert "not logged in" in text
        assert "roomlights405" not in text
        for typed, shown in (("wrong", "a valid token is needed"), ("hunter2", "3 devices")):
            await own.write("input[type=password]", typed)
            await own.click("form button")
            await own.shows(shown)
        assert "hunter2" not in own.browser.current_url
        await own.open("#/system", shows="This screen")
        await own.click(".screen button")
        await own.shows("not logged in")
        await own.open("#token=hunter2", shows="3 devices")  # a link, where the page is open already
        assert "hunter2" not in own.browser.current_url


async def test_a_page_with_a_token_that_is_valid_no_more_goes_on_without_one(page: OpenPage, tmp_path: Path) -> None:
    """At this computer, where none is needed."""
    (tmp_path / "token").write_text("of-today")
    async with page(tokens={"panel": {"token_file": str(tmp_path / "token"), "scope": ["read"]}}) as own:
        await own.open("#token=of-yesterday", shows="a valid token is needed")
        await own.click("form button[type=button]")
        await own.shows("3 devices")


async def test_a_screen_that_may_only_look_is_told_which_right_it_lacks(page: OpenPage, tmp_path: Path) -> None:
    """Its sheets had no controls, and no word why."""
    (tmp_path / "token").write_text("of-the-wall")
    panel = {"panel": {"token_file": str(tmp_path / "token"), "scope": ["read"]}}
    scenes = [{"name": "Bright", "values": {"philips165": "on"}}]
    async with page(tables={"scenes": scenes}, token="hunter2", tokens=panel) as own:
        await own.open("#token=of-the-wall", shows="only to look at")
        await own.shows("This screen lacks the right act.", "main")
        await own.click("button[aria-label='more of philips165']")
        await own.shows("This screen lacks the right act.", ".sheet")
        await own.open("#/routines", shows="This screen lacks the right manage.")


async def test_an_address_with_a_mistake_and_a_narrow_window_show_the_page(page: OpenPage) -> None:
    async with page(tables={"home": {"name": "villa" * 20}}) as own:
        await own.open("#/device/100%", shows="There is no device 100%")
        for width in (320, 780, 800):
            own.resize(width, 800)
            for view, text in (("#/home", "Rooms"), ("#/graph", "/discovery")):
                await own.open(view, shows=text)
                assert own.overflow() == 0, f"{view} at {width} pixels"
        own.browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


async def test_a_device_that_can_hurt_is_approved_after_its_topics_were_shown(page: OpenPage) -> None:
    tables = {
        "gateways": {"mqtt": {"root": "home425"}, "real": {"class": "homebot.gateways.memory:MemoryGateway"}},
        "places": {"devices": {"lights/roomlights405": {"tags": ["always_ask"]}}},
    }
    async with page(tables=tables, token="hunter2") as own:
        await own.open("#/system", shows="a valid token is needed")
        await own.write("input[type=password]", "hunter2")
        await own.click("form button")
        await own.shows("Waiting for your approval")
        await own.open(LAMP, shows="not approved")
        await own.click(".title .pill")
        await own.click(".sheet .chief")
        await own.shows("refused (approval)", "[role=alert]")
        await own.click("[role=alert] button")
        await own.hides("refused (approval)")
        await own.open("#/system", shows="Waiting for your approval")
        await own.shows("HB206 note on control: 2 devices wait for approval")
        await own.click("button[aria-label='show what approving roomlights405 allows']")
        await own.shows("home425/lights/roomlights405", ".box")
        await own.click(".box button")
        await own.hides("roomlights405", "main section")
        await own.open(LAMP, shows="roomlights405")
        await own.click(".title .pill")
        await own.click(".sheet .chief")
        await own.shows("confirmed after", "[role=alert]")
        assert own.problems() == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1200, 390])
async def test_axe_finds_nothing(page: OpenPage, axe: str, scheme: str, width: int) -> None:
    found = []
    async with page() as own:
        own.prefer(scheme)
        own.resize(width, 800)
        for view, shown in dict(VIEWS).items():
            await own.open(view, shows=shown)
            found += await to_thread.run_sync(own.complaints, axe)
    async with page(tables={**ALWAYS_ASKING, "routines": ROUTINES}, token="hunter2") as own:
        await own.open("#token=hunter2", shows="philips165")
        await own.open("#/routines", shows="all lights off")
        await own.click(".choices button")
        await own.shows("what starts it", "form")
        found += await to_thread.run_sync(own.complaints, axe)
        await own.open("#/home", shows="philips165")
        await own.click(".scenes .new")
        await own.click("form summary")
        await own.shows("It keeps the present values of", "form")
        found += await to_thread.run_sync(own.complaints, axe)
        await own.click(SWITCH)
        await own.shows("Hold to turn on", ".asks")
        found += await to_thread.run_sync(own.complaints, axe)
        await own.click(".asks .no")
        await own.click("button[aria-label='more of philips165']")
        await own.click(".sheet summary")
        await own.shows("Tags", ".sheet")
        await own.hold(".sheet .hold")
        await own.shows("close", "[role=alert]")
        found += await to_thread.run_sync(own.complaints, axe)
        own.browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    assert found == []


async def test_an_error_covers_nothing_and_is_gone_in_the_next_view(page: OpenPage) -> None:
    """The last devices could not be reached below it, and it followed through all views."""
    async with page(tables=ALWAYS_ASKING) as own:
        own.resize(390, 500)
        await own.open("#/device/lights%2Fphilips165", shows="Commands")
        await own.hold("div[aria-label='on/off'] .hold")
        await own.shows("close", "[role=alert]")
        assert not await to_thread.run_sync(own.browser.execute_script, COVERED)
        await own.open("#/journal", shows="philips165")
        await own.shows("such a device needs a right", "ol")
        await own.hides("close", "[role=alert]")
        own.browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


@asynccontextmanager
async def keeping(messages: Mapping[str, str]) -> AsyncIterator[tuple[HostedBroker, MqttConnection]]:
    """Run a broker that keeps *messages*, and yield it with a connection to it."""
    async with MemoryBroker() as broker:
        options = MqttOptions.from_url(broker.url, client_id="keeper")
        async with MqttConnection(options, broker.make_client, status_topic=None) as connection:
            await connection.wait_connected()
            for topic, payload in messages.items():
                await connection.publish(topic, payload.encode(), qos=1, retain=True)
            yield HostedBroker.in_memory(broker), connection


async def test_an_alert_of_which_people_are_told_again_has_a_button_until_somebody_has_seen_it(page: OpenPage) -> None:
    """Only a call of a service ended it."""
    async with keeping(SMOKE) as (broker, _), page(tables={"notify": {}}, services=(broker,)) as own:
        await own.open(shows="Kitchen smoke")
        await own.shows("I have seen it")
        await own.click(".banner.alarm .seen")
        await own.shows("Nobody is told of it again.", "[role=alert].good")
        await own.hides("I have seen it")
        await own.shows("is there a fire?")
        assert own.problems() == []
    async with keeping(SMOKE) as (broker, _), page(services=(broker,)) as own:
        await own.open(shows="is there a fire?")
        await own.hides("I have seen it")  # nobody is told


async def test_an_alert_on_the_first_view_is_in_the_language_of_the_page_at_once(browser: Any, page: OpenPage) -> None:
    """Its texts are loaded with those of later views, after two seconds."""
    added = browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": NEVER_LATER})
    async with keeping(SMOKE) as (broker, _), page(services=(broker,)) as own:
        await own.open("?language", shows="Kitchen smoke")
        await to_thread.run_sync(browser.execute_script, "localStorage.setItem('homebot.language', 'de')")
        await own.open("?german", shows="Brennt es?")
        await own.shows("Rauch oder Hitze")
        assert own.problems() == []
        await to_thread.run_sync(browser.execute_script, "localStorage.clear()")
    browser.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", added)


async def test_a_view_that_is_there_before_its_place_is_drawn_is_shown(browser: Any, page: OpenPage) -> None:
    """The link to a room led to an empty page now and then, until the page was loaded anew."""
    added = browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": DRAWN_LATE})
    async with page() as own:
        await own.open("#/room/Room%20405", shows="roomlights405")
    browser.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", added)


async def test_a_device_that_a_link_opens_is_shown_although_the_list_of_devices_comes_later(
    browser: Any, page: OpenPage
) -> None:
    """It was said not to be there any more, for as long as it reported nothing."""
    added = browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": LISTED_LATE})
    async with page() as own:
        await own.open(LAMP, shows="What is known")
    browser.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", added)


async def test_the_first_plot_of_a_plug_is_its_power(page: OpenPage) -> None:
    """It was whether it is on, which the journal tells."""
    tables = {"history": {"enabled": True}}
    async with keeping(PLUG) as (broker, field), page(tables=tables, services=(broker,)) as own:
        await own.open("#/home", shows="Plug")
        await to_thread.run_sync(own.browser.execute_async_script, HISTORY)
        for topic, payload in {"plug/state": b"ON", "plug/power": b"43"}.items():
            await field.publish(topic, payload, qos=1)
        await own.shows("43 W", ".tile.on")
        await own.open("#/device/plug", shows="now 43 W")
        await own.shows("on/off", "select[aria-label=value]")
        plot = own.browser.find_element("css selector", "[role=img]").get_attribute("aria-label")
        assert plot.startswith("power over time")


async def test_a_kept_value_is_explained_once_and_a_panel_has_a_keypad_for_its_code(page: OpenPage) -> None:
    """It read "alarm armed_away unconfirmed", offered "arming", and had no way to give a code."""
    async with keeping(PANEL) as (broker, _), page(services=(broker,)) as own:
        text = await own.open(shows="Armed away")
        assert text.count("the device has not reported since homebot started") == 1
        assert "unconfirmed" not in text
        await own.open("#/security", shows="Armed night")
        await own.hides("arming", ".modes")
        await own.click(".modes .disarmed")
        for digit in (4, 3):
            await own.click(f".keypad button:nth-of-type({digit})")
        for key in ("2", "7", BACKSPACE, "1"):  # of a keyboard beside the screen
            await to_thread.run_sync(own.type, key)
        await own.shows("●●●●", ".keypad")
        await own.click(".keypad .hold")
        await own.shows("●●●●", ".keypad")  # it is held, as all that lets in
        await own.hold(".keypad .hold")
        await own.shows("panel: ", "[role=alert]")
        await own.hides("code for", ".securitygrid")
        assert "4321" not in await own.open("#/journal", shows="panel")


async def test_a_setting_is_called_as_its_device_calls_it_and_a_bell_tells_when_it_rang(page: OpenPage) -> None:
    """A heat pump had "option" and "text", and a bell "Its last event, which is no state:", and nothing after that."""
    async with keeping(RARE) as (broker, field), page(services=(broker,)) as own:
        await own.open("#/device/heat_pump", shows="Commands")
        await own.click(".title .pill")
        text = await own.shows("Display text", ".sheet")
        assert "Operating mode" in text
        assert "Eco · Hello" in text
        assert "option" not in text
        await own.open("#/device/bell_volume", shows="Commands")
        await own.shows("Bell volume", ".commands")
        await own.open("#/device/bell", shows="Why")
        await field.publish("bell/state", b'{"event_type": "ring"}', qos=1)
        await own.click(".title .pill")
        await own.shows("Its last event", ".sheet")
        await own.shows("ring", ".sheet .log")
        assert own.problems() == []


async def test_a_person_stands_once_on_home_and_not_again_for_what_they_carry(page: OpenPage) -> None:
    """Anna and her phone were two people."""
    people = {"people": {"Anna": {"trackers": ["Anna's phone"]}}}
    for tables, name in (({}, "Anna's phone is at home"), (people, "Anna is at home")):
        async with keeping(RARE) as (broker, _), page(tables=tables, services=(broker,)) as own:
            await own.open(shows="Favorites")
            text = await own.shows(name, ".people")
            assert text.count("is at home") == 1


async def test_a_field_has_the_value_in_the_steps_of_its_device(page: OpenPage, zigbee_lamp: World) -> None:
    """A lamp at 102 of 254 had 40.15748031496063, of which the field showed the half."""
    async with page(zigbee_lamp) as own:
        await own.open("#/device/lamp", shows="Commands")
        assert await to_thread.run_sync(own.browser.execute_async_script, COMMAND, "lamp", "40 %") == "confirmed"
        await own.shows("40 %")
        await own.open("#/home", shows="lamp")
        await own.open("#/device/lamp", shows="Commands")
        at_40 = "return document.querySelector('input[type=range]')?.value === '40'"
        await to_thread.run_sync(own.until, lambda: own.browser.execute_script(at_40))


async def test_a_way_to_a_device_is_none_of_homebots_own_addresses(page: OpenPage, zigbee_lamp: World) -> None:
    """It read "words:zigbee2mqtt:0x02…#light", twice."""
    async with page(zigbee_lamp) as own:
        await own.open("#/device/lamp", shows="mqtt: zigbee2mqtt:0x")
        await own.hides("words:", "main")


async def test_values_are_said_as_people_say_them() -> None:
    """A metering plug was "on · 1840 W · measurement 1850 · measurement 80", a picture of 2026-11-30T06:12:44+00:00."""
    readings = [{"capability": name, "value": value} for name, value in (("measurement", 1850), ("power", 1840))]
    script = f"""
        const {{ summary, valueText }} = await import("./words.js");
        const states = (all) => ({{ states: new Map(all.entries()) }});
        console.log(summary(states({readings})), "|", summary(states({readings[:1]})), "|",
            valueText("level", 40.157, "%", 100 / 254), valueText("fan_speed", 33.5, "%", 0.5), "|",
            valueText("value", "2024-11-30T06:12:44.5+01:00"));"""
    assert await printed_by(script) == "1840 | 1850 | 40\u00a0% 33.5\u00a0% | 30 Nov 05:12:44"


async def test_the_meter_of_the_house_counts_what_the_others_count_too(page: OpenPage) -> None:
    """The power of the house was the sum of all meters, that of the house among them."""
    other = {
        topic.replace("plug", "oven"): text.replace("plug", "oven").replace("Plug", "Oven")
        for topic, text in PLUG.items()
    }
    tables: dict[str, object] = {"places": {"devices": {"plug": {"tags": ["house meter"]}}}}
    async with (
        keeping(PLUG | other | {"oven/power": "30"}) as (broker, _),
        page(tables=tables, services=(broker,)) as own,
    ):
        await own.open("#/energy", shows="most by Oven")
        await own.shows("42", ".number b")


async def test_the_reason_of_a_refusal_is_said_in_the_language_of_the_page() -> None:
    held = {
        "outcome": "refused",
        "policy": "lease",
        "reason": "its member a is refused it: held at 5 % by b for 3 s more",
    }
    silent = {
        "outcome": "no_answer",
        "policy": "",
        "reason": "its gateway mqtt is unavailable: mqtt://a:1883: nothing is listening there (connection refused): "
        "start it, or correct the address",
    }
    undone = {"outcome": "contradicted", "policy": "", "reason": "", "saw": "on_off is on, level is 20"}
    limited = {
        "outcome": "refused",
        "policy": "rights",
        "reason": "client:b may not command c: it is not among what the client may command, and the scope of the client"
        " is act: lights; add 'act: plug' to that, in the table [door.tokens.b] of homebot.toml",
    }
    note = "Notlicht: lamp failed: not sent: it takes no commands"
    script = f"""
        const {{ choose, sayReason }} = await import("./language.js");
        const {{ outcomeText, vocabulary }} = await import("./words.js");
        await choose("de");
        vocabulary.value = {{ units: {{ level: "%" }}, flags: {{ on_off: ["off", "on"] }} }};
        for (const one of {json.dumps([held, silent, undone, limited])}) console.log(outcomeText(one));
        console.log(sayReason({json.dumps(note)}));"""
    assert (await printed_by(script)).split("\n") == [
        "abgelehnt (Belegung): das Mitglied a lehnt ab: noch 3 s auf 5 % gehalten von b",
        "nicht gesendet: sein Gateway mqtt ist nicht verfügbar: mqtt://a:1883: dort antwortet kein Programm: starte es,"
        " oder berichtige die Adresse",
        "widersprochen: an, Helligkeit 20\u00a0%",
        "abgelehnt (Rechte): client:b darf c nicht steuern: es gehört nicht zu dem, was der Zugang steuern darf, und"
        " der Zugang darf nur act: lights; ergänze 'act: plug' in [door.tokens.b] von homebot.toml",
        "Notlicht: lamp ging nicht: nicht gesendet: nimmt nicht: Befehle",
    ]


async def test_nothing_that_homebot_says_of_a_refusal_stays_english() -> None:
    """160 messages did: each has a row of reasons.json. Here a row is • and its values; other words are English."""
    script = f"""
        const {{ choose, sayReason }} = await import("./language.js");
        await choose("de");
        for (const one of {json.dumps(sorted(told_messages()))})
            if (/[a-z]{{2}}/.test(sayReason(one).replace("homebot pair", ""))) console.log(one, "|", sayReason(one));"""
    assert await printed_by(script, lambda text: " ".join(["•", *re.findall(r"\{\w+\}", text)])) == ""


async def printed_by(script: str, worded: Callable[[str], str] | None = None) -> str:
    """Return what a *script* prints that imports modules of the page, in whose tables German texts are as *worded*."""
    home = node_folder(SOURCE)
    shutil.copytree(SOURCE, home, dirs_exist_ok=True)
    if worded is not None:
        for table in TABLES:
            rows = json.loads((SOURCE / table).read_text())
            (home / table).write_text(json.dumps({text: [worded(text), *own[1:]] for text, own in rows.items()}))
    own = os.environ | {"TZ": "UTC", "FEATURES": str(SOURCE.parents[1] / "features")}
    run = partial(subprocess.run, cwd=home, env=own, check=True, capture_output=True, text=True)
    await to_thread.run_sync(run, ("node", "collect.js"))
    command = ("node", "--input-type=module", "--eval", BARE_BROWSER + script)
    return (await to_thread.run_sync(run, command)).stdout.strip()


async def test_the_committed_page_is_what_its_source_builds(tmp_path: Path) -> None:
    """`make page` was run after the last change."""
    home = node_folder(SOURCE)
    shutil.copytree(SOURCE, home, dirs_exist_ok=True)
    command = ("npm", "run", "--silent", "build", "--", f"--outdir={tmp_path}")
    own = os.environ | {"TZ": "UTC", "FEATURES": str(SOURCE.parents[1] / "features")}
    done = await to_thread.run_sync(
        partial(subprocess.run, command, cwd=home, env=own, check=False, capture_output=True)
    )
    assert done.returncode == 0, done.stderr[-2000:]
    built = {path.name for folder in (tmp_path, BUILT) for path in folder.glob("*.[jc]s*")}
    for name in sorted(built):
        assert (tmp_path / name).read_bytes() == (BUILT / name).read_bytes(), f"{name}: run make page"


async def test_the_question_of_a_program_is_answered_with_a_button(page: OpenPage, tmp_path: Path) -> None:
    (tmp_path / "token").write_text("of-the-agent")
    tokens = {"agent": {"token_file": str(tmp_path / "token"), "scope": ["read", "ask: light"]}}
    outcomes: list[str] = []
    async with page(tokens=tokens) as own, aiohttp.ClientSession() as session:

        async def ask(word: str) -> None:
            url, headers = f"http://127.0.0.1:{own.door.port}/api/command", {"Authorization": "Bearer of-the-agent"}
            async with session.post(url, headers=headers, json={"device": "philips165", "do": word}) as answer:
                outcomes.append((await answer.json())["outcome"])

        await own.open(shows="3 devices")
        for word, button, outcome in (("on", 1, "confirmed"), ("off", 2, "refused")):
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(ask, word)
                await own.shows(f"the client agent wants: lights/philips165 → {word}?", "[aria-label=question]")
                await (own.hold if button == 1 else own.click)(f"[aria-label=question] button:nth-of-type({button})")
                await own.hides("the client agent wants")
            assert outcomes[-1] == outcome
        assert own.problems() == []
