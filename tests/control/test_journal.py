"""What the journal has of commands, in virtual time."""

from typing import ClassVar

import anyio
import pytest
from tests.control.conftest import Home, OpenHome, ignore, obey_after, report

from homebot.control.command import IssuedCommand
from homebot.devices.command_messages import CommandRequest, Setting
from homebot.devices.handles import Light, OccupancySensor, WindowCovering
from homebot.devices.journal_messages import JournalEntry, ReadJournalRequest, ReadJournalResponse
from homebot.devices.names import JOURNAL_ENTRIES
from homebot.devices.outcomes import AlreadySo, Outcome
from homebot.devices.value import Value
from homebot.journal.store import JournalStore
from homebot.messages import Time

pytestmark = pytest.mark.virtual_time


class FailingOnce:
    """A rehearsal with a mistake."""

    is_live: ClassVar[bool] = False

    def __init__(self) -> None:
        self._given: list[str] = []

    def outcome(self, command: IssuedCommand) -> Outcome | None:
        """Return that the second command changes nothing."""
        self._given.append(command.id)
        return AlreadySo(command_id=self._given[1])


def kinds(response: ReadJournalResponse) -> list[str]:
    return [one.kind for one in response.entries]


async def stored(store: JournalStore) -> list[str]:
    return kinds(await store.read(ReadJournalRequest()))


async def test_a_confirmed_command_has_a_complete_chain(home: Home) -> None:
    lamp = await home.lamp("on_off", behaviour=obey_after(0.5))
    outcome = await lamp.turn_on()
    found = await home.read()
    assert kinds(found) == ["requested", "sent", "acknowledged", "reported", "outcome"]
    assert {one.command for one in found.entries} == {outcome.command_id}
    assert {one.issuer for one in found.entries} == {"/app"}
    assert [one.value.plain() for one in found.entries[0].settings] == [True]
    assert found.entries[-1].results[0].text == outcome.text
    assert [one.value for one in found.names] == ["Lamp"]
    times = [one.at.to_seconds() for one in found.entries]
    assert round(times[-1] - times[0], 2) == 0.5


async def test_each_try_is_an_entry_and_so_is_what_goes_back(home: Home) -> None:
    lamp = await home.lamp("on_off", behaviour=ignore)
    await lamp.turn_on()
    assert kinds(await home.read()) == ["requested", *["sent", "acknowledged"] * 3, "outcome"]
    home.behaviours["lamp"] = report((0.1, True), (3.0, False))
    outcome = await lamp.turn_on()
    await anyio.sleep(5)
    found = await home.read(command=outcome.command_id)
    assert kinds(found)[-2:] == ["outcome", "reverted"]
    assert "changed" not in kinds(await home.read())


async def test_a_command_of_an_app_names_the_report_that_led_to_it(home: Home) -> None:
    home.put("lamp", "light", "on_off")
    home.put("motion", "occupancy_sensor", readable=("occupancy",))
    lamp = await home.handle(Light, "lamp")

    async def follow() -> None:
        async for change in home.devices.follow(OccupancySensor, occupied=True):
            if change.kind == "appeared":
                await lamp.turn_on()

    home.tasks.start_soon(follow)
    await anyio.sleep(1)
    await home.report("motion", "occupancy", True)
    await anyio.sleep(1)
    requested = (await home.read()).entries[0]
    trigger = requested.trigger
    assert (requested.kind, trigger.kind) == ("requested", "report")
    assert trigger.device.endswith("motion")
    assert [(one.capability, one.value.plain()) for one in trigger.readings] == [("occupancy", True)]
    assert trigger.at.to_seconds() <= requested.at.to_seconds()


async def test_a_command_of_a_timer_says_so(home: Home) -> None:
    lamp = await home.lamp("on_off")

    async def turn_on() -> None:
        await lamp.turn_on()

    timer = home.app.create_timer(60.0, turn_on)
    await anyio.sleep(61)
    timer.cancel()
    trigger = (await home.read()).entries[0].trigger
    assert (trigger.kind, trigger.text) == ("timer", "every 60 s")


async def test_entries_are_published_as_they_come(home: Home) -> None:
    home.put("lamp", "light", "on_off")
    seen: list[JournalEntry] = []
    home.app.create_subscription(JournalEntry, JOURNAL_ENTRIES, seen.append, 100)
    await (await home.handle(Light)).turn_on()
    await anyio.sleep(0.1)
    assert tuple(seen) == (await home.read()).entries


async def test_it_is_read_by_device_and_time_and_bounded(home: Home) -> None:
    home.put("lamp", "light", "on_off")
    home.put("plug", "light", "on_off")
    for key in ("lamp", "plug"):
        await (await home.handle(Light, key)).turn_on()
        await anyio.sleep(60)
    lamp = (await home.handle(Light, "lamp")).device.id
    everything = await home.read()
    assert len(everything.entries) == 10
    assert (await home.read(device=lamp)).entries == everything.entries[:5]
    since = Time.from_seconds(everything.entries[5].at.to_seconds())
    assert (await home.read(since=since)).entries == everything.entries[5:]
    until = Time.from_seconds(everything.entries[4].at.to_seconds())
    assert (await home.read(until=until)).entries == everything.entries[:5]
    newest = await home.read(limit=2)
    assert (newest.entries, newest.complete) == (everything.entries[-2:], False)
    assert newest.begins == everything.entries[0].at


async def test_a_command_to_a_device_that_is_gone_is_in_it(home: Home) -> None:
    lamp = await home.lamp("on_off")
    home.gateway.devices.remove("lamp", "sold")
    await anyio.sleep(0.1)
    request = CommandRequest(
        device=lamp.device.id,
        part="",
        settings=(Setting(capability="on_off", value=Value.of(True)),),
        issuer="client:kitchen",
    )
    await home.control.perform(request)
    found = await home.read()
    assert kinds(found) == ["requested", "outcome"]
    assert found.entries[-1].results[0].outcome == "gone"


async def test_the_chain_of_a_replaced_command_ends_with_that_though_the_lamp_obeys_both(home: Home) -> None:
    lamp = await home.lamp("on_off", before={"on_off": True}, behaviour=obey_after(8.0))
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(lamp.turn_off)
        await anyio.sleep(0.1)
        assert (await lamp.turn_on()).succeeded
    entries = (await home.read()).entries
    (end,) = [one for one in entries if one.results and one.results[0].outcome == "superseded"]
    chain = [one.kind for one in entries if one.command == end.command]
    assert chain == ["requested", "sent", "acknowledged", "outcome"]


async def test_a_command_that_homebot_itself_fails_to_send_has_an_outcome_too(open_home: OpenHome) -> None:
    """Its part is free for the next one."""
    async with open_home(rehearsal=FailingOnce()) as home:
        lamp = await home.lamp("on_off")
        assert "IndexError" in (await lamp.turn_on()).text
        found = await home.read()
        assert kinds(found) == ["requested", "outcome"]
        (result,) = found.entries[-1].results
        assert result.text == "not sent: homebot failed: IndexError: list index out of range"
        assert (await lamp.turn_on()).succeeded


async def test_a_command_is_stored_at_its_outcome_and_read_before(open_home: OpenHome) -> None:
    store = JournalStore(1000, 86_400.0)
    async with open_home(store=store) as home:
        lamp = await home.lamp("on_off", behaviour=obey_after(2.5))
        home.tasks.start_soon(lamp.turn_on)
        await anyio.sleep(1)
        assert kinds(await home.read()) == ["requested", "sent", "acknowledged"]
        assert await stored(store) == []
        await anyio.sleep(2)
        assert await stored(store) == ["requested", "sent", "acknowledged", "reported", "outcome"]


async def test_a_crash_before_the_outcome_leaves_that_the_command_was_given(open_home: OpenHome) -> None:
    store = JournalStore(1000, 86_400.0)
    async with open_home(store=store) as home:
        home.put("blind", "window_covering", "position")
        blind = await home.handle(WindowCovering, "blind")
        home.behaviours["blind"] = report((10.0, 20.0), (25.0, 40.0), (50.0, 100.0))
        home.tasks.start_soon(blind.open)
        await anyio.sleep(31)
        assert await stored(store) == ["requested", "sent", "acknowledged", "reported"]
        await anyio.sleep(30)
        assert await stored(store) == kinds(await home.read())
        assert (await stored(store))[4:] == ["reported", "outcome"]
