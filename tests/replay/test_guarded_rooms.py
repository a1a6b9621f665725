"""The presence guard knows in a replay what it knew when the recording began."""

import asyncio
import json

import pytest
from tests.apps.houses import flat, lamp, motion
from tests.replay.recorded_days import APPS, diff_of, recorded, recorded_for_client, recording_of, texts

from homebot.devices.command_messages import CommandDevices, CommandDevicesRequest
from homebot.devices.names import COMMAND_DEVICES
from homebot.graph import Node
from homebot.recording.recording import Recording
from homebot.support.virtual_time import VirtualTimeLoop
from homebot.testing import virtual_house_of

pytestmark = [pytest.mark.slow, pytest.mark.rooms("homeassistant", "recording")]

CONFIG = {"apps": {"lights_out": APPS["lights_out"]}, "control": {"presence_guard": {}}}


def hour_after_somebody_left() -> Recording:
    """The sensor of the hall detected somebody before the recording, and nobody in it."""
    lines: list[str] = []
    world = flat(("08:00", "hall"), ("08:20", "outside"), hall_lamp=lamp("hall"), hall_motion=motion("hall"))

    async def live() -> None:
        async with (
            virtual_house_of(world=world, config=CONFIG, start="2026-01-01 07:55") as home,
            Node(home.runtime.graph, "person") as person,
        ):
            await home.run_until("09:00")
            async with recorded_for_client(person, lines):
                request = CommandDevicesRequest(
                    target="hall_lamp", command="on", issuer="client:anna", scope=("act: all",)
                )
                assert (await person.create_client(CommandDevices, COMMAND_DEVICES).call(request)).success
                await home.run_until("10:00")

    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        runner.run(live())
    return recording_of(lines)


def test_a_sensor_that_had_detected_somebody_is_believed_in_the_replay_too() -> None:
    recording = hour_after_somebody_left()
    (sensor,) = recording.header.detected
    assert sensor.startswith("hall_motion#")
    assert [one.result.outcome for one in recording.commands if one.result] == ["confirmed", "confirmed"]
    assert texts(recording, diff_of(recording)) == []


def test_a_day_with_every_policy_is_replayed_under_the_same_policies() -> None:
    """Quiet hours, nearly all day in any time zone, refuse what lights_out asks for; the guard is told its commands."""
    table = {
        "presence_guard": {"absent_after": 60, "commands": ["turn off lights in hall"]},
        "quiet_hours": [{"start": "00:00", "end": "23:59", "commands": ["turn off lights"]}],
        "interlocks": [{"commands": ["heat"], "while": "open contact sensor", "where": "home"}],
        "rate_limit": False,
        "witnesses": {"light in hall": "Hall lux"},
    }
    world = flat(("01:00", "hall"), ("02:00", "outside"), hall_lamp=lamp("hall"), hall_motion=motion("hall"))
    recording = recorded(world, ["lights_out", "follow_me"], "4h", config={"control": table})
    refused = {one.result.policy for one in recording.commands if one.result}
    assert "quiet_hours" in refused
    assert json.loads(recording.header.control)["quiet_hours"][0]["commands"] == ["turn off lights"]
    assert texts(recording, diff_of(recording)) == []
