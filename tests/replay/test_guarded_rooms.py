"""The presence guard knows in a replay what it knew when the recording began."""

from __future__ import annotations

import asyncio

from tests.apps.houses import flat, lamp, motion
from tests.replay.recorded_days import APPS, diff_of, recorded_for_client, recording_of, texts

from homebot.devices.command_messages import CommandDevices, CommandDevicesRequest
from homebot.devices.names import COMMAND_DEVICES
from homebot.graph import Node
from homebot.recording.recording import Recording
from homebot.testing import virtual_house_of
from homebot.virtual_time import VirtualTimeLoop

CONFIG = {"apps": {"lights_out": APPS["lights_out"]}, "control": {"presence_guard": {}}}


def hour_after_somebody_left() -> Recording:
    """The sensor of the hall detected somebody before the recording, and nobody in it."""
    lines: list[str] = []
    world = flat(("08:00", "hall"), ("08:20", "outside"), hall_lamp=lamp("hall"), hall_motion=motion("hall"))

    async def live() -> None:
        async with virtual_house_of(world=world, config=CONFIG) as home, Node(home.runtime.graph, "person") as person:
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
