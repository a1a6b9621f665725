"""Answers of homebot, read by attribute."""

from typing import cast

import pytest

from homebot.devices import Device
from homebot.devices.health import Count, HealthResponse
from homebot.devices.wording.json_message import JsonMessage, fields_of
from homebot.errors import WireError
from homebot.messages.json import message_to_json

HEALTH = HealthResponse(counts=(Count(name="late", count=2),), notes=("hot",))


def test_an_answer_reads_like_the_message_it_is_of() -> None:
    answer = cast("HealthResponse", JsonMessage(message_to_json(HEALTH)))

    assert [(one.name, one.count) for one in answer.counts] == [("late", 2)]
    assert tuple(answer.notes) == HEALTH.notes
    assert fields_of(answer) == message_to_json(HEALTH)


def test_a_missing_field_names_itself_and_a_likely_reason() -> None:
    device = cast("Device", JsonMessage({}))

    with pytest.raises(WireError, match="without the field area; is it of another version"):
        device.area  # noqa: B018 - reading is the test
