"""A trial of routines by the history of a house, where nothing was recorded."""

import asyncio
import json

import pytest
from tests.apps.houses import hall
from tests.recorded_house import HOUSE
from tests.replay.recorded_days import history_of

from homebot.config import parse_config
from homebot.devices.gateway_messages import Report
from homebot.devices.history_messages import HistorySeries
from homebot.devices.journal_messages import ReadJournal, ReadJournalRequest
from homebot.devices.names import ALIAS_DEVICE, READ_JOURNAL, TAG_DEVICE
from homebot.devices.places_messages import AliasDevice, TagDevice
from homebot.features.routines.history_recording import history_recording
from homebot.features.routines.trial import trial_config, tried
from homebot.graph import Node
from homebot.recording.recording import Recording
from homebot.replay.replay import Replayed, replay
from homebot.testing import VirtualTimeLoop, virtual_house_of

pytestmark = [pytest.mark.slow, pytest.mark.rooms("homeassistant")]

ROUTINES = {
    "home": {"zone": "UTC"},
    "routines": [
        {"name": "Light", "when": ["hall motion occupied"], "do": ["my lamps on", "wait 4m", "undo"]},
        {"name": "Pressed", "when": ["hall button press"], "do": ["notify It was pressed"]},
        {"name": "Held", "when": ["hall button press hold"], "do": ["notify It was held"]},
        {"name": "Told", "when": ["hall lamp on for 2m"], "if": ["hall motion clear"], "do": ["notify It is on"]},
    ],
}


async def lived() -> Recording:
    """Half an hour in which Anna comes twice; the owner has tagged the lamp, and turns it on and off by hand.

    Nothing follows the presses of a button.
    """
    world = hall(("08:05", "hall"), ("08:06", "outside"), ("08:20", "hall"))
    config = {"history": {"enabled": True}}
    async with (
        virtual_house_of(world=world, start="2026-01-01 08:00", config=config) as house,
        Node(house.runtime.graph, "owner") as owner,
    ):
        button = {"name": "hall button", "unique_id": "b", "state_topic": "button", "event_types": ["single", "hold"]}
        await house.says("homeassistant/event/button/config", json.dumps(button))
        await house.run_until("08:01")
        tag = TagDevice.Request(device="hall_lamp", tag="my lamps")
        assert (await owner.create_client(TagDevice, TAG_DEVICE).call(tag)).success
        name = AliasDevice.Request(device="hall_button", alias="Doorbell")
        assert (await owner.create_client(AliasDevice, ALIAS_DEVICE).call(name)).success
        await house.run_until("08:12")
        await house.press("hall_lamp", "on")
        await house.run_until("08:16")
        await house.press("hall_lamp", "off")
        for press in ("single", "hold", "hold"):
            await house.run_for("3m")
            await house.says("button", json.dumps({"event_type": press}))
        await house.run_until("08:30")
        journal = await owner.create_client(ReadJournal, READ_JOURNAL).call(ReadJournalRequest())
        return await history_of(house, house.now.timestamp() - 29.5 * 60, journal.entries, lambda _: True)


@pytest.fixture(scope="module")
def replayed() -> Replayed:
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        recording = runner.run(lived())
    config = trial_config(recording, parse_config(ROUTINES, "new.toml"))
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        loop = runner.get_loop()
        assert isinstance(loop, VirtualTimeLoop)
        found = runner.run(replay(recording, config, loop.settled))
    assert [one.change for one in tried(recording, found)] == ["on", ""]  # by hand, within ten minutes
    return found


def told(replayed: Replayed, text: str) -> list[str]:
    return [f"{one.time:%H:%M}" for one in replayed.notifications if one.message == text]


def test_commands_come_when_the_history_has_their_triggers(replayed: Replayed) -> None:
    assert replayed.crashes == {}
    given = [(one.command.device, int(one.at / 60)) for one in replayed.commands]
    assert given == [("hall_lamp", 4), ("hall_lamp", 19)]


def test_a_state_that_lasted_starts_a_routine_too(replayed: Replayed) -> None:
    assert told(replayed, "It is on") == ["08:14"]


def test_each_press_starts_a_routine_though_nothing_followed_it_then(replayed: Replayed) -> None:
    assert told(replayed, "It was pressed") == ["08:19", "08:22", "08:25"]
    assert told(replayed, "It was held") == ["08:22", "08:25"]


def test_names_and_tags_of_the_owner_count(replayed: Replayed) -> None:
    assert dict(replayed.hints) == {}


def test_a_device_is_called_as_in_the_house(replayed: Replayed) -> None:
    assert {one.id: one.name for one in replayed.devices}["hall_button"] == "Doorbell"


def test_the_mean_of_a_setpoint_that_was_changed_meanwhile_is_none_that_somebody_set() -> None:
    means = HistorySeries(
        device="bath_heating",
        name="",
        part="",
        capability="heating_setpoint",
        width=300.0,
        times=(0.0, 300.0, 600.0),
        values=(20.0, 17.6, 16.0),
        lows=(20.0, 16.0, 16.0),
        highs=(20.0, 20.0, 16.0),
    )
    recording = history_recording("home425", HOUSE, [means], [], 0.0, 1000.0)
    reports = [one for one in recording.before if isinstance(one, Report)]
    reports += [one.message for one in recording.events if isinstance(one.message, Report)]
    known = [(one.received_at.sec, one.readings[0].value.plain()) for one in reports]
    assert known == [(0, 20.0), (900, 16.0)]
