"""People, and what the owner stated, are in a replay as they were on the day."""

from __future__ import annotations

import asyncio

from tests.apps.houses import flat, lamp, motion
from tests.replay.recorded_days import APPS, MemorySink, diff_of, recording_of, replayed, texts

from homebot.devices.command_messages import CommandDevices, CommandDevicesRequest
from homebot.devices.names import COMMAND_DEVICES
from homebot.graph import Node
from homebot.recording.recording import Recording
from homebot.testing import virtual_house_of
from homebot.virtual_time import VirtualTimeLoop


def evening_with_a_person() -> Recording:
    """The lamp of the study is placed in the hall by its owner, and turned on by a client of the door."""
    sink = MemorySink()
    world = flat(("08:00", "hall"), ("09:00", "outside"), study_lamp=lamp("study"), hall_motion=motion("hall"))

    async def live() -> None:
        config = {
            "apps": {"lights_out": APPS["lights_out"]},
            "places": {"rooms": {"hall": {}}, "devices": {"study_lamp": {"room": "hall"}}},
        }
        async with virtual_house_of(world=world, config=config, record_into=sink) as home:
            async with Node(home.runtime.graph, "person") as node:
                await home.run_until("08:30")
                command = node.create_client(CommandDevices, COMMAND_DEVICES)
                request = CommandDevicesRequest(
                    target="study_lamp", command="on", issuer="client:anna", scope=("act: all",)
                )
                assert (await command.call(request)).success
            await home.run_until("10:00")

    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        runner.run(live())
    return recording_of(sink.lines)


def test_a_command_of_a_person_is_recorded_and_given_again() -> None:
    recording = evening_with_a_person()
    assert [one.command.issuer for one in recording.commands] == ["client:anna", "/lights_out"]
    assert [one.result.outcome for one in recording.commands if one.result] == ["confirmed", "confirmed"]
    assert texts(recording, diff_of(recording)) == []


def test_only_commands_of_apps_are_the_result_of_a_replay() -> None:
    found = replayed(evening_with_a_person())
    assert {one.command.issuer for one in found.commands} == {"/lights_out"}
    assert [one.area for one in found.devices if one.id == "study_lamp"] == ["hall"]
