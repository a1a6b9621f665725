"""The habits of people on the page: looked for, proved, accepted and rejected."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import anyio
import pytest
from anyio import to_thread
from tests.peers.chromium import Page, axe_program, chromium

from homebot.clock import LoopClock
from homebot.config import parse_config
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions
from homebot.runtime import Runtime
from homebot.testing.virtual_house import parse_time

OWNER = "hunter2-and-some-more"
BEGIN = parse_time("2026-01-05").timestamp()
DAYS = 14
DAY = 86_400
LAMPS = ("hall lamp", "desk <b>lamp")
SWITCHED = ((7, LAMPS[0], "ON"), (9, LAMPS[0], "OFF"), (20, LAMPS[1], "ON"), (23, LAMPS[1], "OFF"))
"""The hour at which a person switches a lamp each day."""

CONFIG = '{{"unique_id": "{0}", "name": "{0}", "state_topic": "{0}/state", "command_topic": "{0}/set"}}'
TABLES = {
    "history": {"enabled": True},
    "home": {"name": "villa", "zone": "UTC"},
    "gateways": {"mqtt": {}},
}


@pytest.fixture
def browser() -> Iterator[Any]:
    with chromium() as driver:
        yield driver


async def live(lamps: MqttConnection) -> None:
    """Switch the lamps by hand, some minutes later each day."""
    for name in LAMPS:
        await lamps.publish(f"homeassistant/light/{name}/config", CONFIG.format(name).encode(), qos=1, retain=True)
    passed = 0.0
    for day in range(DAYS):
        for hour, name, word in SWITCHED:
            at = day * DAY + hour * 3600 + 120 * (day % 4)
            await anyio.sleep(at - passed)
            passed = at
            await lamps.publish(f"{name}/state", word.encode(), qos=1, retain=True)
    await anyio.sleep(DAYS * DAY - passed)


@pytest.mark.virtual_time
async def test_a_habit_is_proved_accepted_or_rejected_and_who_may_not_only_sees_it(
    browser: Any, tmp_path: Path
) -> None:
    axe = await to_thread.run_sync(axe_program)
    (tmp_path / "token").write_text(OWNER)
    token = {"token_file": str(tmp_path / "token"), "scope": ["read", "manage"]}
    tables = {**TABLES, "door": {"port": 0, "tokens": {"owner_s": token}}}
    config = await to_thread.run_sync(parse_config, tables, "test")
    clock = LoopClock(BEGIN)
    async with MemoryBroker(clock=clock) as broker:
        options = MqttOptions.from_url(broker.url, client_id="lamps")
        runtime = Runtime(config, clock=clock, services=(HostedBroker.in_memory(broker),))
        async with runtime, MqttConnection(options, broker.make_client, status_topic=None, clock=clock) as lamps:
            await lamps.wait_connected()
            await live(lamps)
            assert runtime.rosbridge is not None
            page = Page(browser, runtime.rosbridge)
            for step in (accept, reject, look):
                await to_thread.run_sync(step, page, axe)  # virtual time stands still while a thread works
                await anyio.sleep(10)


def proposals(page: Page, last: str) -> list[Any]:
    """Look for habits, and return the proposals."""
    page.opened("#/routines", "Your habits")
    page.clicked("p.choices:has(small) button")
    page.opened("#/routines", last)
    return list(page.browser.find_elements("css selector", "section:has(h3)"))


def accept(page: Page, axe: str) -> None:
    page.opened(f"#token={OWNER}", "hall lamp")
    found = proposals(page, "hall lamp on at 07:0")
    assert "of 7 times; a routine would be right" in found[0].text
    page.clicked("section:has(h3) summary")
    assert "you did it 1 min before" in found[0].text
    for width in (1280, 390):
        page.resize(width, 800)
        assert page.overflow() == 0
        assert page.complaints(axe) == []
    page.tabbed("section:has(h3) p button")


def reject(page: Page, _: str) -> None:
    page.opened("#/routines", "added hall lamp on at 07:0")
    page.opened("#/routines", "run now")
    page.clicked("section:has(h3) p button:last-child")


def look(page: Page, _: str) -> None:
    """Without a token there is nothing to decide."""
    page.opened("#/routines", "it is not proposed again")
    page.opened("#/more", "This screen")
    page.clicked(".screen button")
    page.opened("#/system", "Doctor")
    left = proposals(page, "desk <b>lamp off at 23:0")
    assert all(one.text.split(" at ")[0] in {"desk <b>lamp on", "desk <b>lamp off"} for one in left)
    assert page.browser.find_elements("css selector", "section button:enabled") == []
    assert page.problems() == []
