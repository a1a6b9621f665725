"""People, and what the owner stated, are in a replay as they were on the day."""

import asyncio
import json

import anyio
import pytest
from tests.apps.houses import flat, lamp, motion
from tests.replay.recorded_days import APPS, MemorySink, diff_of, recording_of, replayed, texts

from homebot.devices.always_ask import is_approved
from homebot.devices.approval_messages import ApproveDeviceRequest
from homebot.devices.command_messages import CommandDevices, CommandDevicesRequest, Setting
from homebot.devices.lease_messages import EndLeasesRequest, HolderRequest, HoldRequest
from homebot.devices.names import (
    ALIAS_DEVICE,
    APPROVE_DEVICE,
    COMMAND_DEVICES,
    END_LEASES,
    HOLD_PART,
    IMPORT_PLACES,
    PLACE_DEVICE,
    RELEASE_LEASE,
    RENEW_LEASE,
    TAG_DEVICE,
    TEACH_PLACE,
)
from homebot.devices.places_messages import (
    AliasDeviceRequest,
    ImportPlacesRequest,
    OwnerRequest,
    PlaceDeviceRequest,
    TagDeviceRequest,
    TeachPlaceRequest,
)
from homebot.devices.value import Value
from homebot.graph import Node
from homebot.messages import Message
from homebot.recording.recording import Recording
from homebot.support.virtual_time import VirtualTimeLoop
from homebot.testing import virtual_house_of

pytestmark = [pytest.mark.slow, pytest.mark.rooms("homeassistant", "recording", "zigbee2mqtt")]

LIGHTS_OUT = {**APPS["lights_out"], "quiet_after": 600.0}
START = "2026-01-01 07:55"


def evening_with_a_person() -> Recording:
    """The lamp of the study is placed in the hall by its owner, and turned on by a client of the door."""
    sink = MemorySink()
    world = flat(("08:00", "hall"), ("09:00", "outside"), study_lamp=lamp("study"), hall_motion=motion("hall"))

    async def live() -> None:
        config = {
            "apps": {"lights_out": LIGHTS_OUT},
            "places": {"rooms": {"hall": {}}, "devices": {"study_lamp": {"room": "hall"}}},
        }
        async with virtual_house_of(world=world, config=config, start=START, observers=sink.observers()) as home:
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


def turn_on(device: str) -> CommandDevicesRequest:
    return CommandDevicesRequest(target=device, command="on", issuer="client:anna", scope=("act: all",))


STATED = (
    ("08:10", PLACE_DEVICE, PlaceDeviceRequest(device="study_lamp", room="hall")),
    ("08:15", COMMAND_DEVICES, turn_on("study_lamp")),
    ("08:20", ALIAS_DEVICE, AliasDeviceRequest(device="study_lamp", alias="Reading lamp")),
    ("08:30", TAG_DEVICE, TagDeviceRequest(device="study_lamp", tag="cosy")),
    ("08:40", APPROVE_DEVICE, ApproveDeviceRequest(device="study_lamp")),
    ("08:50", TEACH_PLACE, TeachPlaceRequest(device="kitchen_lamp", gateway="nfc", room="hall")),
    ("09:40", PLACE_DEVICE, PlaceDeviceRequest(device="study_lamp", room="study")),
    ("09:41", PLACE_DEVICE, PlaceDeviceRequest(device="nobody", room="hall")),
    ("09:50", COMMAND_DEVICES, turn_on("study_lamp")),
)


def recorded_with(*doings: tuple[str, str, Message]) -> Recording:
    """A morning in which somebody is in the hall twice, and people call services; no lamp announces its room."""
    sink = MemorySink()
    world = flat(
        ("08:00", "hall"),
        ("09:00", "outside"),
        ("10:00", "hall"),
        ("10:10", "outside"),
        study_lamp=lamp("study", dialect="zigbee2mqtt"),
        kitchen_lamp=lamp("kitchen", dialect="zigbee2mqtt"),
        hall_motion=motion("hall"),
    )

    async def live() -> None:
        rooms: dict[str, object] = {"hall": {}, "kitchen": {}, "study": {}}  # where the lamps are is not stated
        tables = {"apps": {"lights_out": LIGHTS_OUT}, "places": {"rooms": rooms}}
        async with (
            virtual_house_of(world=world, config=tables, start=START, observers=sink.observers()) as home,
            Node(home.runtime.graph, "person") as node,
            anyio.create_task_group() as calls,
        ):
            for at, name, request in doings:
                await home.run_until(at)
                service = home.runtime.graph.get_service_type(name)
                assert service is not None
                calls.start_soon(node.create_client(service, name).call, request)
            await home.run_until("11:00")
            calls.cancel_scope.cancel()

    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        runner.run(live())
    return recording_of(sink.lines)


def test_what_the_owner_states_on_the_day_is_stated_at_its_time() -> None:
    """The lamp of the study is turned off with those of the hall while it is placed there, and not before or after."""
    recording = recorded_with(*STATED)
    assert [(one.command.issuer, round(475 + one.at / 60)) for one in recording.commands] == [
        ("client:anna", 495),
        ("/lights_out", 551),
        ("client:anna", 590),
    ]
    asked = [one.message for one in recording.events if isinstance(one.message, OwnerRequest)]
    assert [one.service for one in asked] == [name for _, name, _ in STATED if name != COMMAND_DEVICES]
    found = replayed(recording)
    (one,) = (one for one in found.devices if one.id == "study_lamp")
    assert (one.name, one.area, one.tags) == ("Reading lamp", "study", ("cosy",))
    assert is_approved(one)
    assert [one.area for one in found.devices if one.id == "kitchen_lamp"] == ["hall"]
    diff = diff_of(recording)
    assert (diff.different, diff.same) == ((), 1)


def test_an_imported_file_is_imported_again_and_no_other_file_is_recorded() -> None:
    """A configuration that somebody imports by mistake may hold passwords."""
    rooms = '[places.devices.study_lamp]\nroom = "hall"'
    mistake = '[gateways.mqtt]\npassword = "geheim"'
    imports = (("08:10", mistake), ("08:11", rooms))
    recording = recorded_with(*((at, IMPORT_PLACES, ImportPlacesRequest(text=text)) for at, text in imports))
    (one,) = (one.message for one in recording.events if isinstance(one.message, OwnerRequest))
    assert json.loads(one.request)["text"] == rooms
    assert [one.area for one in replayed(recording).devices if one.id == "study_lamp"] == ["hall"]


def hold() -> HoldRequest:
    setting = Setting(capability="on_off", value=Value.of(True))
    return HoldRequest(
        device="study_lamp",
        part="light",
        setting=setting,
        lease="1",
        by="anna",
        ttl=3600.0,
        issuer="client:anna",
        scope=("act: all",),
    )


PLACED = (STATED[0], ("08:15", HOLD_PART, hold()))
RELEASED = ("09:05", RELEASE_LEASE, HolderRequest(lease="1", by="anna", issuer="client:anna"))
ENDED = ("09:05", END_LEASES, EndLeasesRequest(device="study_lamp", issuer="client:owner"))


@pytest.mark.parametrize(
    ("doings", "outcomes"),
    [
        ((*PLACED, RELEASED), ["confirmed", "confirmed"]),
        ((*PLACED, ENDED), ["confirmed", "confirmed"]),
        (PLACED, ["confirmed", "refused", "confirmed"]),  # it dies; its time is over at 09:15
        (
            (*PLACED, *((at, RENEW_LEASE, RELEASED[2]) for at in ("09:00", "09:50"))),
            ["confirmed", "refused", "refused", "refused", "refused"],
        ),
    ],
)
def test_what_a_person_held_is_held_again_for_as_long(
    doings: tuple[tuple[str, str, Message], ...], outcomes: list[str]
) -> None:
    """The app wants the lamp off at 09:11 and at 10:21, and tries again after 20 and 40 minutes."""
    recording = recorded_with(*doings)
    assert [one.result.outcome for one in recording.commands if one.result] == outcomes
    assert texts(recording, diff_of(recording)) == []
    assert [one.result.outcome for one in replayed(recording).commands if one.result] == outcomes[1:]


def test_only_commands_of_apps_are_the_result_of_a_replay() -> None:
    found = replayed(evening_with_a_person())
    assert {one.command.issuer for one in found.commands} == {"/lights_out"}
    assert [one.area for one in found.devices if one.id == "study_lamp"] == ["hall"]
