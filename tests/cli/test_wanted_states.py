"""What ``homebot why-not`` says of a state that somebody misses at a device."""

from __future__ import annotations

from typing import cast

import pytest

from homebot.cli.records import CapabilityRecord, DeviceRecord
from homebot.cli.wanted_states import command_for, unknown_state


def device(*capabilities: CapabilityRecord) -> DeviceRecord:
    return cast("DeviceRecord", {"parts": [{"part": {"capabilities": list(capabilities)}}] if capabilities else []})


def can(name: str, *options: str, settable: bool = True) -> CapabilityRecord:
    return {"name": name, "readable": True, "settable": settable, "unit": "", "bounds": [], "options": list(options)}


BLIND = device(can("movement"), can("position"))


@pytest.mark.parametrize("wanted", ["open", "Closed", "close", "stopped", "40", "position 40"])
def test_a_state_of_the_vocabulary_may_be_asked_for(wanted: str) -> None:
    assert unknown_state(BLIND, wanted) == ""


@pytest.mark.parametrize(
    ("of", "wanted", "sentence"),
    [
        (
            BLIND,
            "sunny",
            "It has no state 'sunny'. It takes movement open, closed, opening, closing, stopped; position 0 to 100 %.",
        ),
        (device(can("occupancy", settable=False)), "on", "It takes no commands, it only reports."),
        (device(), "on", ""),
        (device(can("x_fizz")), "lit", ""),
    ],
)
def test_a_state_that_the_device_does_not_have_is_told_with_those_that_it_has(
    of: DeviceRecord, wanted: str, sentence: str
) -> None:
    """Of what is not in the vocabulary nothing is claimed."""
    assert unknown_state(of, wanted) == sentence


@pytest.mark.parametrize(
    ("wanted", "word"),
    [("closed", "close"), ("close", "close"), ("locked", "lock"), ("on", "on"), ("level 40", ""), ("lit", "")],
)
def test_the_word_that_asks_for_a_state_is_known_where_one_is_enough(wanted: str, word: str) -> None:
    assert command_for(BLIND, wanted) == word
