"""What commands taught is known after a restart; in virtual time, with a store that outlives the control layer."""

from collections.abc import Mapping

import anyio
import pytest
from structlog.testing import capture_logs
from tests.control.conftest import OpenHome, report
from tests.control.kept_store import KeptStore

from homebot.devices.outcomes import Confirmed, Contradicted
from homebot.journal.store import LearntRow

pytestmark = pytest.mark.virtual_time

ECHO = 0.005


async def learn_a_profile(open_home: OpenHome, store: KeptStore) -> LearntRow:
    """Let a lamp go back by itself once; return the row of its profile."""
    async with open_home(store=store) as home:
        lamp = await home.lamp("on_off", behaviour=report((ECHO, True), (1.5, False)))
        assert isinstance(await lamp.turn_on(), Confirmed)
        await anyio.sleep(20)
    (row,) = store.rows.values()
    return row


class LockedStore(KeptStore):
    """A store whose file another program keeps for five seconds."""

    async def learnt(self) -> tuple[LearntRow, ...]:
        await anyio.sleep(5)
        return await super().learnt()


async def test_a_file_that_another_program_keeps_holds_up_no_command(open_home: OpenHome) -> None:
    store = LockedStore()
    store.rows = {("profile", "habit"): LearntRow("profile", "habit", "nonsense", 0.0)}
    with capture_logs() as lines:
        async with open_home(store=store) as home:
            lamp = await home.lamp("on_off")
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


async def test_each_row_says_when_it_was_learnt(open_home: OpenHome) -> None:
    store = KeptStore()
    row = await learn_a_profile(open_home, store)
    assert (row.kind, row.name, row.at > 0.0) == ("profile", "lamp", True)


async def test_rows_of_older_versions_are_dropped(open_home: OpenHome) -> None:
    store = KeptStore()
    store.rows = {(kind, "x"): LearntRow(kind, "x", "{}", 0.0) for kind in ("disproof", "echo", "witness")}
    async with open_home(store=store) as home:
        lamp = await home.lamp("on_off")
        await lamp.turn_on()
    assert not any(kind in store.rows for kind in [("disproof", "x"), ("echo", "x"), ("witness", "x")])


async def test_a_profile_is_known_after_a_restart(open_home: OpenHome) -> None:
    store = KeptStore()
    for expected in (Confirmed, Confirmed, Confirmed, Contradicted):
        async with open_home(store=store) as home:
            lamp = await home.lamp("on_off", behaviour=report((ECHO, True), (1.5, False)))
            assert isinstance(await lamp.turn_on(), expected)
            await anyio.sleep(20)


BAD_ROWS: Mapping[str, LearntRow] = {
    "no JSON": LearntRow("profile", "attic", "nonsense", 0.0),
    "another version": LearntRow("profile", "attic", '{"version": 0, "target": "attic"}', 0.0),
    "another name": LearntRow("profile", "lock", '{"target": "attic"}', 0.0),
    "not finite": LearntRow("profile", "attic", '{"target":"attic","times":{"on_off":[1e999]}}', 0.0),
    "damaged": LearntRow("profile", "attic", "", 0.0),
    "of a newer version": LearntRow("habit", "lamp", "{}", 0.0),
}


@pytest.mark.parametrize("bad", BAD_ROWS.values(), ids=BAD_ROWS.keys())
async def test_a_row_that_cannot_be_read_is_dropped_and_the_others_are_used(
    open_home: OpenHome, bad: LearntRow
) -> None:
    store = KeptStore()
    good = await learn_a_profile(open_home, store)
    store.rows = {(one.kind, one.name): one for one in (bad, good)}
    with capture_logs() as lines:
        async with open_home(store=store) as home:
            lamp = await home.lamp("on_off")
            await lamp.turn_on()
    (line,) = [one for one in lines if one["event"] == "control.learnt_dropped"]
    assert line["log_level"] == "warning"
    assert f"{bad.kind} {bad.name!r}" in line["message"]
    assert (bad.kind, bad.name) not in store.rows
    (used,) = [one for one in lines if one["event"] == "control.learnt_loaded"]
    assert used["count"] == 1
