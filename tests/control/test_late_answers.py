"""Devices that answer after the time limit of a command; in virtual time."""

from functools import partial

import anyio
import pytest
from tests.control.conftest import Home, OpenHome, end_of_ramp, ignore, obey, obey_after
from tests.control.kept_store import KeptStore

from homebot.devices.handles import Light
from homebot.devices.outcomes import Confirmed, Contradicted, NoAnswer, Outcome
from homebot.journal.store import JournalNote

pytestmark = pytest.mark.virtual_time


async def switched(home: Home, times: int) -> list[tuple[type[Outcome], int]]:
    """Switch the lamp on and off, and return each outcome with the number of sendings."""
    lamp = await home.handle(Light)
    found: list[tuple[type[Outcome], int]] = []
    for number in range(times):
        before = len(home.commands)
        outcome = await (lamp.turn_off() if number % 2 else lamp.turn_on())
        found.append((type(outcome), len(home.commands) - before))
        await anyio.sleep(90)
    return found


@pytest.mark.parametrize("seconds", [11.0, 14.0, 25.0, 45.0])
async def test_a_lamp_that_is_slower_than_the_limit_fails_once(home: Home, seconds: float) -> None:
    home.put("lamp", "light", "on_off")
    home.behaviours["lamp"] = obey_after(seconds)
    found = await switched(home, 5)
    failed = [one for one, _ in found].count(NoAnswer)
    assert failed == (1 if seconds <= 31.0 else 2)  # told once, it is waited for as long as is usual at most
    assert found[-1] == (Confirmed, 1)


async def test_a_dimmer_with_a_long_ramp_fails_once(home: Home) -> None:
    """It reports the end alone, and each repetition begins the ramp anew."""
    home.put("lamp", "light", "on_off", "level")
    _, home.behaviours["lamp"] = end_of_ramp(15)
    assert await switched(home, 3) == [(NoAnswer, 3), (Confirmed, 1), (Confirmed, 1)]


async def test_a_slow_lamp_that_tells_meanwhile_that_it_is_off_fails_once(home: Home) -> None:
    lamp = await home.lamp("on_off", behaviour=obey_after(14.0))
    home.later(8.0, "lamp", "on_off", False)
    assert isinstance(await lamp.turn_on(), Contradicted)
    await anyio.sleep(30)
    assert isinstance(await lamp.turn_off(), Confirmed)


async def test_what_is_another_value_or_later_than_a_minute_is_no_late_answer(home: Home) -> None:
    lamp = await home.lamp("on_off", "level", behaviour=ignore)
    assert isinstance(await lamp.turn_on(), NoAnswer)
    home.later(30.0, "lamp", "on_off", False)
    home.later(61.0, "lamp", "on_off", True)
    await anyio.sleep(80)
    home.behaviours["lamp"] = obey_after(14.0)
    assert isinstance(await lamp.turn_off(), NoAnswer)


async def test_a_deaf_lamp_that_says_again_how_it_is_gives_no_late_answer(home: Home) -> None:
    """Else the next failure would be told of only after a minute."""
    lamp = await home.lamp("on_off", before={"on_off": False}, behaviour=ignore)
    for _ in range(3):
        for command in (lamp.turn_on, lamp.turn_off):
            began = anyio.current_time()
            assert isinstance(await command(), NoAnswer)
            assert anyio.current_time() - began <= 10.1
        home.later(30.0, "lamp", "on_off", False)
        await anyio.sleep(35)


async def test_a_deaf_lamp_that_is_wanted_as_it_says_that_it_is_gets_no_more_time(home: Home) -> None:
    lamp = await home.lamp("on_off", before={"on_off": False}, behaviour=ignore)
    for _ in range(3):
        began = anyio.current_time()
        assert isinstance(await lamp.turn_on(), NoAnswer)
        assert anyio.current_time() - began <= 10.1
        home.later(6.0, "lamp", "on_off", False)
        assert isinstance(await lamp.turn_off(), Confirmed)


async def test_a_newer_command_ends_the_wait_for_a_late_answer(home: Home) -> None:
    lamp = await home.lamp("on_off", behaviour=ignore)
    assert isinstance(await lamp.turn_on(), NoAnswer)
    assert isinstance(await lamp.turn_off(), NoAnswer)
    await home.report("lamp", "on_off", True)
    await anyio.sleep(30)
    home.behaviours["lamp"] = obey_after(14.0)
    assert not (await lamp.turn_off()).succeeded


class KilledStore(KeptStore):
    """A store that a killed homebot adds nothing more to."""

    is_killed = False

    def add(self, note: JournalNote) -> None:
        if not self.is_killed:
            super().add(note)


@pytest.mark.parametrize(
    ("after", "transition", "is_killed"),
    [(5.0, 0.0, False), (40.0, 0.0, False), (40.0, 60.0, True), (40.0, 0.0, True)],
    ids=["ended while open", "ended", "killed while open", "killed"],
)
async def test_a_lamp_that_hears_a_command_only_after_a_restart_obeys_that_command(
    open_home: OpenHome, after: float, transition: float, *, is_killed: bool
) -> None:
    store = KilledStore()
    async with open_home(store=store) as home:
        lamp = await home.lamp("on_off", before={"on_off": False}, behaviour=ignore)
        await anyio.sleep(1000)
        home.begin(partial(lamp.turn_on, transition=transition))
        await anyio.sleep(after)
        store.is_killed = is_killed
    store.is_killed = False
    async with open_home(store=store, clock=home.graph.clock) as home:
        home.put("lamp", "light", "on_off")
        await home.report("lamp", "on_off", False)
        await anyio.sleep(300)
        await home.report("lamp", "on_off", True)
        await anyio.sleep(1)
        assert await told(home) == [("reported", "command", "/app")]
        await anyio.sleep(60)
        await home.report("lamp", "on_off", False)
        await anyio.sleep(1)
        assert (await told(home))[-1][:2] == ("changed", "person")


async def test_a_doubt_ends_with_a_report_or_a_newer_command_and_is_known_to_a_command_after_a_restart(
    open_home: OpenHome,
) -> None:
    store = KeptStore()
    async with open_home(store=store) as home:
        for key in ("lamp", "again", "moved"):
            await home.new(Light, key, "on_off", before={"on_off": False}, behaviour=ignore)
            assert isinstance(await (await home.handle(Light, key)).turn_on(), NoAnswer)
        home.behaviours["again"] = obey
        assert isinstance(await (await home.handle(Light, "again")).turn_on(), Confirmed)
        await home.report("moved", "on_off", True)
        await anyio.sleep(60)
    async with open_home(store=store, clock=home.graph.clock) as home:
        sent = dict[str, int]()
        for key, value in (("lamp", False), ("again", True), ("moved", True)):
            lamp = await home.new(Light, key, "on_off", before={"on_off": value})
            outcome = await (lamp.turn_on() if value else lamp.turn_off())
            sent[key] = len(home.commands)
            assert outcome.succeeded
        assert sent == {"lamp": 1, "again": 1, "moved": 1}  # it may have obeyed unseen; the others are so already


async def told(home: Home) -> list[tuple[str, str, str]]:
    """Return the kind, cause and issuer of each change in the journal."""
    entries = (await home.read()).entries
    return [(one.kind, one.cause, one.issuer) for one in entries if one.kind in {"reported", "changed"}]
