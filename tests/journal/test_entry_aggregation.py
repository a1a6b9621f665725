"""Folding of equal commands in the journal."""

import json
from pathlib import Path

import anyio
import pytest
from pydantic import ValidationError
from tests.control.conftest import Home, OpenHome
from tests.journal.test_journal_file import NOW, opened, read

from homebot import Light
from homebot.devices.command_messages import CommandRequest
from homebot.devices.journal_messages import JournalEntry, ReadJournalRequest
from homebot.devices.outcomes import AlreadySo, NoAnswer
from homebot.journal.entry_aggregation import IN_FULL, MAX_OF_ISSUER, EntryAggregation
from homebot.journal.store import JournalNote, JournalStore

FLOOD = 200


def command(
    number: int, outcome: str = "already_so", *, at: float = NOW, issuer: str = "client:a"
) -> list[JournalNote]:
    ended = NoAnswer(1.0) if outcome == "no_answer" else AlreadySo()
    return [
        JournalNote("requested", at, "lamp", "", f"{number}", issuer),
        JournalNote("sent", at, "lamp", "", f"{number}", issuer),
        JournalNote("outcome", at, "lamp", "", f"{number}", issuer, outcome=ended),
    ]


def stored(folding: EntryAggregation, notes: list[JournalNote]) -> list[tuple[str, str, int]]:
    return [(one.kind, one.command, one.folded) for one in folding.add(notes)]


def in_full(number: int, folded: int = 0) -> list[tuple[str, str, int]]:
    return [("requested", f"{number}", folded), ("sent", f"{number}", 0), ("outcome", f"{number}", 0)]


def test_equal_commands_of_a_minute_leave_the_newest_and_their_number() -> None:
    folding = EntryAggregation()
    for number in range(IN_FULL):
        assert stored(folding, command(number)) == in_full(number)
    for number in range(IN_FULL, FLOOD):
        assert stored(folding, command(number, at=NOW + 30)) == []
    assert [(one.kind, one.command) for one in folding.waiting()] == [(kind, name) for kind, name, _ in in_full(199)]
    assert stored(folding, command(FLOOD, at=NOW + 60)) == in_full(199, FLOOD - IN_FULL - 1) + in_full(FLOOD)
    assert folding.waiting() == []


def test_another_outcome_in_the_same_minute_is_kept() -> None:
    folding = EntryAggregation()
    for number in range(FLOOD):
        stored(folding, command(number))
    assert stored(folding, command(FLOOD, "no_answer")) == in_full(FLOOD)
    assert stored(folding, command(FLOOD + 1, "no_answer")) == []


def test_others_and_what_has_no_issuer_pass() -> None:
    folding = EntryAggregation()
    for number in range(FLOOD):
        stored(folding, command(number))
    assert stored(folding, command(FLOOD, issuer="/app")) == in_full(FLOOD)
    changed = JournalNote("changed", NOW, "lamp")
    assert list(folding.add([changed])) == [changed]


def test_a_flood_of_leases_is_folded_too() -> None:
    folding = EntryAggregation()
    notes = [JournalNote("held", NOW, "lamp", issuer="client:a") for _ in range(FLOOD)]
    assert sum(len(stored(folding, [note])) for note in notes) == IN_FULL
    assert [one.folded for one in folding.waiting()] == [FLOOD - IN_FULL - 1]


def test_a_command_that_is_filed_before_its_outcome_leaves_no_more_than_another() -> None:
    folding = EntryAggregation()
    begun = [command(number)[:2] for number in range(FLOOD)]
    ended = [command(number)[2:] for number in range(FLOOD)]
    assert sum(len(stored(folding, notes)) for notes in (*begun, *ended)) == 2 * IN_FULL + 1


@pytest.mark.virtual_time
async def test_the_newest_command_is_read_at_once_and_kept_when_the_minute_is_over(open_home: OpenHome) -> None:
    async with open_home(rate_limit=False) as home:
        lamp = await home.lamp("on_off", before={"on_off": False})
        for _ in range(20):
            await lamp.turn_on()
            await lamp.turn_off()
        before = await outcomes(home)
        await anyio.sleep(61)
        await lamp.turn_on()
        after = await outcomes(home)
    assert [one.command for one in after[:-1]] == [one.command for one in before]
    assert (len(before), before[-1].command.partition("-")[2]) == (IN_FULL + 1, "40")


@pytest.mark.virtual_time
async def test_folded_commands_are_read_at_their_time_and_not_at_that_of_their_storing(open_home: OpenHome) -> None:
    async with open_home(rate_limit=False) as home:
        lamp = await home.lamp("on_off", before={"on_off": False})
        plug = await home.new(Light, "plug", "on_off", before={"on_off": False})
        for _ in range(20):
            await lamp.turn_on()
            await lamp.turn_off()
        await anyio.sleep(30)
        await plug.turn_on()
        await anyio.sleep(31)
        await lamp.turn_on()
        found = await outcomes(home)
    assert [one.device for one in found[-2:]] == [plug.id, lamp.id]
    assert found == sorted(found, key=lambda one: one.at.to_seconds())


def test_a_flood_of_commands_to_ever_new_devices_is_folded_too() -> None:
    folding = EntryAggregation()
    commands = [[note._replace(device=f"d{number}") for note in command(number)] for number in range(5000)]
    assert sum(len(stored(folding, notes)) for notes in commands) == 3 * (MAX_OF_ISSUER + IN_FULL)
    assert stored(folding, command(9999, issuer="/app")) == in_full(9999)
    assert {one.device: one.folded for one in folding.waiting() if one.kind == "requested"} == {
        "d4999": 5000 - MAX_OF_ISSUER - IN_FULL - 1
    }


@pytest.mark.parametrize("field", ["device", "part", "capability", "trigger"])
def test_a_command_names_nothing_in_a_text_without_end(field: str) -> None:
    fields = {"device": "lamp", "settings": [{"capability": "on_off", "value": True}], "issuer": "client:a"}
    CommandRequest.model_validate_json(json.dumps(fields))
    long = "x" * 100_000
    more: dict[str, dict[str, object]] = {"capability": {"settings": [{"capability": long, "value": True}]}}
    more["trigger"] = {"trigger": {"kind": "timer", "text": long}}
    with pytest.raises(ValidationError, match="at most 1000 characters"):
        CommandRequest.model_validate_json(json.dumps(fields | more.get(field, {field: long})))


async def outcomes(home: Home) -> list[JournalEntry]:
    return [one for one in (await home.read()).entries if one.kind == "outcome"]


async def test_a_full_journal_drops_the_entries_of_the_issuer_with_the_most(tmp_path: Path) -> None:
    honest = [note for number in range(20) for note in command(number, issuer="/lights_out")]
    greedy = [note for number in range(3000) for note in command(number, issuer="client:greedy")]
    memory = JournalStore(1000, 1e9)
    for note in (*honest, *greedy):
        memory.add(note)
    in_memory = (await memory.read(ReadJournalRequest())).entries
    assert sum(one.issuer == "/lights_out" for one in in_memory) == len(honest)
    async with opened(tmp_path / "journal.sqlite", most_bytes=100_000) as store:
        for note in (*honest, *greedy):
            store.add(note)
        in_file = await read(store)
        assert store.dropped
    assert [one for one in in_file if one.issuer == "/lights_out"] == [one.entry() for one in honest]
