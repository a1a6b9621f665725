"""What the journal has of requests that the door refused, and how many of them; in virtual time."""

from collections.abc import Mapping

import anyio
import pytest
from tests.control.conftest import Home, OpenHome

from homebot.control.journal.denied_requests import MAX_CLIENTS, MAX_ENTRIES
from homebot.devices.access_messages import AccessRefused
from homebot.devices.handles import DoorLock
from homebot.devices.journal_messages import JournalEntry
from homebot.devices.names import ACCESS_REFUSALS, COMMAND_DEVICES
from homebot.messages import Time

pytestmark = pytest.mark.virtual_time

REASON = "the right act is missing; the token tv has: read. To give it, write …"


async def refuse(home: Home, *requests: Mapping[str, object]) -> list[JournalEntry]:
    """Let the door refuse requests, and return what the journal has."""
    publisher = home.app.create_publisher(AccessRefused, ACCESS_REFUSALS, 1000)
    for fields in requests:
        refused = {
            "issuer": "client:tv",
            "address": "127.0.0.1:4",
            "operation": "call_service",
            "target": "/devices/command",
            "right": "act",
            "reason": REASON,
            "refused_at": Time.from_seconds(home.graph.clock.now()),
            **fields,
        }
        publisher.publish(AccessRefused.model_validate(refused))
    await anyio.sleep(1)
    return [one for one in (await home.read()).entries if one.kind == "denied"]


def count_of(entry: JournalEntry) -> object:
    return {one.name: one.value.plain() for one in entry.verdicts[0].facts}["count"]


async def test_a_denied_request_is_an_entry_with_its_issuer_its_aim_and_the_reason(open_home: OpenHome) -> None:
    async with open_home() as home:
        (entry,) = await refuse(home, {"target": "/gateway/memory/readings", "operation": "publish", "right": "raw"})
    (verdict,) = entry.verdicts
    facts = {one.name: one.value.plain() for one in verdict.facts}
    assert (entry.issuer, entry.device, entry.command, entry.text) == ("client:tv", "", "", "")
    assert (verdict.policy, verdict.allowed, verdict.reason) == ("rights", False, REASON)
    assert facts == {
        "operation": "publish",
        "target": "/gateway/memory/readings",
        "right": "raw",
        "address": "127.0.0.1:4",
        "count": 1.0,
    }


async def test_it_names_the_device_that_the_command_was_for(open_home: OpenHome) -> None:
    async with open_home() as home:
        home.put("front", "door_lock", "lock", name="Front door")
        for key in ("back", "side"):
            home.put(key, "door_lock", "lock", name="Cellar")
        await anyio.sleep(0.01)
        locks = await home.devices.find(DoorLock)
        front = next(one.device for one in locks if one.name == "Front door")
        address = front.endpoints[0].command_address
        entries = await refuse(
            home,
            {"subject": "Front door", "wanted": "unlock"},
            {"subject": front.id, "target": "devices/command"},
            {"subject": address, "target": "/gateway/memory/out", "operation": "publish"},
            {"subject": "Cellar"},
            {"subject": "Front door", "target": "/app/go"},
            {"subject": "Nobody"},
        )
    assert [one.device for one in entries] == [front.id] * 3 + [""] * 3
    assert entries[0].text == "unlock"


async def test_a_flood_is_some_entries_in_an_hour_and_a_count(home: Home) -> None:
    same = [{"target": COMMAND_DEVICES}] * 500
    others = [{"target": f"/app/{number}"} for number in range(300)]
    entries = await refuse(home, *same, *others, {"target": "/app/0", "held_back": 99})
    assert len(entries) == MAX_ENTRIES
    await anyio.sleep(3600)
    *_, last = (await home.read()).entries
    assert count_of(last) == 500 + 300 + 100 - MAX_ENTRIES
    assert last.verdicts[0].facts[1].value.plain() == "/app/0"
    await anyio.sleep(3600)
    again = await refuse(home, {})
    assert len(again) == MAX_ENTRIES + 2
    assert sum(float(str(count_of(one))) for one in again) == 901


async def test_clients_are_told_apart_up_to_a_number(home: Home) -> None:
    clients = [{"issuer": f"client:{number}"} for number in range(MAX_CLIENTS * 2)]
    entries = await refuse(home, *clients)
    assert [one.issuer for one in entries] == [f"client:{number}" for number in range(MAX_CLIENTS + 1)]
    await anyio.sleep(3600)
    assert count_of((await home.read()).entries[-1]) == MAX_CLIENTS - 1
