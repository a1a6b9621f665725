"""What commands taught is known after a restart; in virtual time, with a store that outlives the control layer."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import anyio
import pytest
from structlog.testing import capture_logs
from tests.control.conftest import Home, OpenHome, obey, report
from tests.control.kept_store import KeptStore
from tests.control.witnesses.rooms import WITNESSED, room, shining, toggle

from homebot.clock import Clock, LoopClock
from homebot.control.journal.learnt_row import LearntRow
from homebot.devices.handles import Light
from homebot.devices.outcomes import Confirmed, Contradicted, Evidence

pytestmark = pytest.mark.virtual_time

ECHO = 0.005


async def learn_a_witness(open_home: OpenHome, store: KeptStore, clock: Clock | None = None) -> None:
    async with open_home(store=store, clock=clock) as home:
        await toggle(await room(home), 12)


async def lamp_after_restart(home: Home) -> Light:
    """Put the lamp and the sensor there as they were, and let control begin to watch."""
    home.put("lamp", "light", "on_off", area="Hall")
    home.put("lux", "light_sensor", readable=("illuminance",), area="Hall")
    home.behaviours["lamp"] = shining("lux", 150.0)
    await home.report("lamp", "on_off", False)
    await home.report("lux", "illuminance", 0.0)
    lamp = await home.handle(Light, "lamp")
    await toggle(lamp, 2)
    return lamp


async def test_a_witness_is_trusted_after_a_restart(open_home: OpenHome) -> None:
    store = KeptStore()
    await learn_a_witness(open_home, store)
    async with open_home(store=store) as home:
        lamp = await lamp_after_restart(home)
        assert await toggle(lamp, 1) == [("Lux", Evidence.WITNESSED)]


async def test_the_first_command_after_a_restart_has_its_witness(open_home: OpenHome, tmp_path: Path) -> None:
    """Where a journal is kept, the sensors are followed from the start."""
    path = tmp_path / "journal.sqlite"
    async with open_home(journal_file=path) as home:
        await toggle(await room(home), 12)
    async with open_home(journal_file=path) as home:
        home.put("lamp", "light", "on_off", area="Hall")
        home.put("lux", "light_sensor", readable=("illuminance",), area="Hall")
        home.behaviours["lamp"] = shining("lux", 150.0)
        await home.report("lamp", "on_off", False)
        await home.report("lux", "illuminance", 0.0)
        await anyio.sleep(10)
        assert await toggle(await home.handle(Light, "lamp"), 1) == [WITNESSED]


class LockedStore(KeptStore):
    """A store whose file another program keeps for five seconds."""

    async def learnt(self) -> tuple[LearntRow, ...]:
        await anyio.sleep(5)
        return await super().learnt()


async def test_a_file_that_another_program_keeps_holds_up_no_command(open_home: OpenHome) -> None:
    store = LockedStore()
    store.rows = {("profile", "habit"): LearntRow("profile", "habit", "nonsense", 0.0, "")}
    with capture_logs() as lines:
        async with open_home(store=store) as home:
            home.put("lamp", "light", "on_off")
            lamp = await home.handle(Light)
            began = home.graph.clock.monotonic()
            assert isinstance(await lamp.turn_on(), Confirmed)
            assert home.graph.clock.monotonic() - began < 1.5
            assert [one["log_level"] for one in lines if one["event"] == "control.learnt_late"] == ["warning"]
            began = home.graph.clock.monotonic()
            assert isinstance(await lamp.turn_off(), Confirmed)
            assert home.graph.clock.monotonic() - began < 0.5
            await anyio.sleep(5)
    assert not store.rows  # it was read when it could be
    assert len([one for one in lines if one["event"] == "control.learnt_late"]) == 1


@pytest.mark.parametrize("kind", ["disproof", "profile", "witness"])
async def test_the_presence_guard_drops_nothing_that_others_learnt(open_home: OpenHome, kind: str) -> None:
    """It reads what it has learnt itself at the start, before the first command."""
    store = KeptStore()
    store.rows = {(kind, "x"): LearntRow(kind, "x", "{}", 0.0, "")}
    async with open_home(store=store, presence_guard=True):
        await anyio.sleep(1)
    assert list(store.rows) == [(kind, "x")]


async def test_a_lie_is_contradicted_after_a_restart(open_home: OpenHome) -> None:
    """The sensor has shown before how finely it reports."""
    store, clock = KeptStore(), LoopClock()
    await learn_a_witness(open_home, store, clock)
    async with open_home(store=store, clock=clock) as home:
        lamp = await lamp_after_restart(home)
        await toggle(lamp, 1)

        async def tell_again() -> None:
            while True:
                await home.report("lux", "illuminance", 150.0)
                await anyio.sleep(2)

        home.behaviours["lamp"] = obey
        home.tasks.start_soon(tell_again)
        assert isinstance(await lamp.turn_off(), Contradicted)


async def test_each_row_says_when_and_from_which_command_it_was_learnt(open_home: OpenHome) -> None:
    store = KeptStore()
    async with open_home(store=store) as home:
        lamp = await room(home)
        await toggle(lamp, 11)
        outcome = await lamp.turn_off()
        await anyio.sleep(40)
        row = next(one for one in store.rows.values() if one.kind == "witness")
        assert row.command == outcome.command_id
        assert home.graph.clock.now() - row.at == pytest.approx(30, abs=1)


async def test_a_profile_is_known_after_a_restart(open_home: OpenHome) -> None:
    store = KeptStore()
    for expected in (Confirmed, Confirmed, Confirmed, Contradicted):
        async with open_home(store=store) as home:
            home.put("lamp", "light", "on_off")
            home.behaviours["lamp"] = report((ECHO, True), (1.5, False))
            assert isinstance(await (await home.handle(Light)).turn_on(), expected)
            await anyio.sleep(20)


BAD_ROWS: Mapping[str, LearntRow] = {
    "no JSON": LearntRow("witness", "attic by lux# illuminance", "nonsense", 0.0, ""),
    "another version": LearntRow("profile", "attic", '{"version": 0, "target": "attic"}', 0.0, ""),
    "another name": LearntRow("profile", "lock", '{"target": "attic"}', 0.0, ""),
    "not finite": LearntRow("profile", "attic", '{"target":"attic","times":{"on_off":[1e999]}}', 0.0, ""),
    "damaged": LearntRow("witness", "attic by lux# illuminance", "", 0.0, ""),
    "of a newer version": LearntRow("habit", "lamp", "{}", 0.0, ""),
}


@pytest.mark.parametrize("bad", BAD_ROWS.values(), ids=BAD_ROWS.keys())
async def test_a_row_that_cannot_be_read_is_dropped_and_the_others_are_used(
    open_home: OpenHome, bad: LearntRow
) -> None:
    store = KeptStore()
    await learn_a_witness(open_home, store)
    good = next(one for one in store.rows.values() if one.kind == "witness")
    store.rows = {(one.kind, one.name): one for one in (bad, good)}
    with capture_logs() as lines:
        async with open_home(store=store) as home:
            await toggle(await lamp_after_restart(home), 1)
    (line,) = [one for one in lines if one["event"] == "control.learnt_dropped"]
    assert line["log_level"] == "warning"
    assert f"{bad.kind} {bad.name!r}" in line["message"]
    assert (bad.kind, bad.name) not in store.rows
    (used,) = [one for one in lines if one["event"] == "control.learnt_loaded"]
    assert used["count"] == 1
