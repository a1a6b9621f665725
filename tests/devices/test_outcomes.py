"""Each outcome of a command on its way: over the wire, into the journal, and out of it again, for clients."""

from dataclasses import fields
from pathlib import Path
from typing import Any, cast

import pytest
from pydantic import ValidationError

from homebot.cli.journal_client import chain_json
from homebot.devices.command_messages import CommandDevicesResponse, CommandResult
from homebot.devices.journal_messages import ReadJournalRequest
from homebot.devices.outcomes import OUTCOMES, Confirmed, Evidence, Outcome, has_succeeded, worst
from homebot.devices.wording.journal_words import result_text
from homebot.devices.wording.json_message import JsonMessage
from homebot.journal.journal_file import JournalFile
from homebot.journal.store import JournalNote

_VALUES = {
    "float": 6.5,
    "str": "a-9",
    "bool": True,
    "Evidence": Evidence.REPORTED,
    "Mapping[str, PlainValue]": {"level": 40.0},
}
EXAMPLES = tuple(
    kind(**{one.name: _VALUES[str(one.type)] for one in fields(kind)})  # type: ignore[arg-type]
    for kind in OUTCOMES.values()
)
"""One of each outcome, with a value in each field."""

EACH = pytest.mark.parametrize("outcome", EXAMPLES, ids=tuple(OUTCOMES))


def test_all_classes_of_outcomes_are_registered() -> None:
    assert {kind.__name__ for kind in Outcome.__subclasses__()} == {kind.__name__ for kind in OUTCOMES.values()}


@EACH
def test_an_outcome_is_the_same_after_the_wire(outcome: Outcome) -> None:
    result = CommandResult.of(outcome)
    assert (result.outcome, result.text, result.command_id) == (outcome.kind, outcome.text, outcome.command_id)
    for received in (result, CommandResult.model_validate_json(result.model_dump_json())):
        assert received.to_outcome() == outcome
        assert received.to_outcome().reported == outcome.reported
    assert CommandDevicesResponse(success=outcome.succeeded, outcome=result.outcome).outcome == outcome.kind


@EACH
def test_an_outcome_is_the_same_in_the_journal_and_in_words_to_clients(tmp_path: Path, outcome: Outcome) -> None:
    note = JournalNote("outcome", 1_800_000_000.0, "lamp", command=outcome.command_id, outcome=outcome)
    file = JournalFile(tmp_path / "journal.db")
    file.open(1_800_000_000.0)
    file.write([note], (), oldest=0.0, most_bytes=1e9)
    (entry,) = file.read_entries(ReadJournalRequest()).entries
    file.close()
    assert entry.results[0].to_outcome() == outcome
    over_the_door = cast("Any", JsonMessage(entry.model_dump(mode="json")))
    assert result_text([over_the_door], now=1_800_000_001.0) == outcome.text
    (step,) = cast("Any", chain_json([over_the_door], {}))
    assert (step["outcome"]["outcome"], step["outcome"]["text"]) == (outcome.kind, outcome.text)


@EACH
def test_an_outcome_without_success_is_worse_than_one_with(outcome: Outcome) -> None:
    confirmed = Confirmed(1.0, Evidence.REPORTED)
    assert has_succeeded(outcome.kind) is outcome.succeeded
    assert worst((confirmed, outcome)).succeeded is outcome.succeeded
    assert not (outcome.succeeded and outcome.is_failure)


def test_the_schemas_have_the_words_and_others_are_refused_at_the_border() -> None:
    schema = CommandDevicesResponse.model_json_schema()["properties"]["outcome"]
    assert (schema["type"], schema["enum"]) == ("string", ["", *OUTCOMES])
    for message, given in (
        (CommandResult, {"command_id": "c", "text": ""}),
        (CommandDevicesResponse, {"success": True}),
    ):
        with pytest.raises(ValidationError, match=r"must be one of already_so, confirmed.*got 'shadowed'"):
            message.model_validate(given | {"outcome": "shadowed"})


def test_a_word_of_a_newer_homebot_is_no_success() -> None:
    assert not has_succeeded("shadowed")
