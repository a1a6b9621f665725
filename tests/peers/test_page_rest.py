"""The page of a screen at a wall: its first view, its rest, and what wakes it."""

import json
from collections.abc import Iterator
from datetime import UTC, datetime
from typing import Any

import pytest
from anyio import to_thread
from tests.peers.chromium import Page, axe_program, chromium, opened_page

from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions

DEVICES: dict[str, tuple[dict[str, object], str]] = {
    "light/lamp": ({"command_topic": "lamp/set"}, "ON"),
    "binary_sensor/door": ({"device_class": "door"}, "ON"),
    "binary_sensor/motion": ({"device_class": "motion"}, "OFF"),
    "binary_sensor/smoke": ({"device_class": "smoke"}, "OFF"),
    "event/doorbell": ({"event_types": ["ring"]}, ""),
}
"""By component and name: what announces it, and its state."""

WAKING = {"motion": "ON", "doorbell": '{"event_type": "ring"}', "smoke": "ON"}
SKIP = """
const now = performance.now.bind(performance);
let skipped = 0;
performance.now = () => now() + skipped;
window.skip = (length) => (skipped += length);
"""
LOCKS = """
window.locks = [];
const request = navigator.wakeLock.request.bind(navigator.wakeLock);
navigator.wakeLock.request = async (kind) => {
  const lock = await request(kind);
  window.locks.push(lock);
  return lock;
};
"""
AWAKE = "return window.locks.filter((one) => !one.released).length"
BACK, REST = 121_000, 301_000  # ms


@pytest.fixture
def browser() -> Iterator[Any]:
    with chromium() as driver:
        yield driver


async def test_a_screen_goes_back_and_rests_until_a_touch_motion_the_doorbell_or_an_alert(browser: Any) -> None:
    axe = await to_thread.run_sync(axe_program)
    browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": SKIP})
    async with MemoryBroker() as broker:
        options = MqttOptions.from_url(broker.url, client_id="others")
        async with (
            MqttConnection(options, broker.make_client, status_topic=None) as connection,
            opened_page(browser, services=(HostedBroker.in_memory(broker),)) as own,
        ):
            await connection.wait_connected()
            for place, (config, state) in DEVICES.items():
                name = place.partition("/")[2]
                device = {"identifiers": [name], "name": name, "suggested_area": "porch"}
                found = {"unique_id": name, "device": device, "name": None, "state_topic": f"{name}/state", **config}
                text = json.dumps(found).encode()
                await connection.publish(f"homeassistant/{place}/config", text, qos=1, retain=True)
                if state:
                    await connection.publish(f"{name}/state", state.encode(), qos=1, retain=True)
            await own.open("?wall=porch#/journal", shows="Journal")
            browser.execute_script("skip(arguments[0])", BACK)
            await own.shows("Porch", "h1")
            assert browser.current_url.endswith("#/room/porch")
            await rest(own)
            shown = await own.shows("door open", ".wallclock")
            assert "2 on" in shown
            assert await to_thread.run_sync(own.complaints, axe) == []
            own.become_phone()
            await own.tap(".wallclock")
            await wakes(own)
            await to_thread.run_sync(own.settled)
            await own.shows("On", ".tile.lit")  # the touch did nothing else
            for name, event in WAKING.items():
                await rest(own)
                await connection.publish(f"{name}/state", event.encode(), qos=1)
                await wakes(own)
            browser.execute_script("skip(arguments[0])", REST)
            await to_thread.run_sync(own.pass_time, 1.5)
            await wakes(own)  # it burns
            own.become_computer()
            assert own.problems() == []


@pytest.mark.parametrize(("hour", "dimmed"), [(2, 1), (14, 0)])
async def test_a_screen_at_a_wall_is_dimmed_by_night_and_kept_awake_until_it_is_at_none(
    browser: Any, hour: int, dimmed: int
) -> None:
    ahead = (hour - datetime.now(UTC).hour + 12) % 24 - 12
    tables: dict[str, object] = {"home": {"name": "villa", "zone": f"Etc/GMT{-ahead:+d}"}}
    browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": LOCKS})
    async with opened_page(browser, tables=tables) as own:
        await own.open("?wall=home#/more", shows="After five minutes")
        await to_thread.run_sync(own.until, lambda: browser.execute_script(AWAKE) == 1)
        await to_thread.run_sync(own.until, lambda: len(browser.find_elements("css selector", ".night")) == dimmed)
        await own.click("[name=wall] option[value='']")
        await to_thread.run_sync(own.until, lambda: browser.execute_script(AWAKE) == 0)
        await own.lacks(".night")


async def rest(page: Page) -> None:
    page.browser.execute_script("skip(arguments[0])", REST)
    await to_thread.run_sync(page.until, lambda: page.browser.find_elements("css selector", ".wallclock"))


async def wakes(page: Page) -> None:
    await to_thread.run_sync(page.until, lambda: not page.browser.find_elements("css selector", ".wallclock"))
