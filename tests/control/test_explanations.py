"""Explanations of a device: its last change, late answers, and the states that it can have."""

import json
import sys

import anyio
import pytest
from tests.control.conftest import Home, OpenHome, ignore, obey, report
from tests.control.policies.houses import make_device
from tests.patience import PATIENCE

from homebot.bridges.rosapi import RosApi
from homebot.bridges.rosbridge import RosbridgeServer, RosbridgeSettings
from homebot.control.explanations import Explanations
from homebot.devices import Device
from homebot.devices.command_messages import Setting
from homebot.devices.gateway_messages import Command
from homebot.devices.handles import ContactSensor, Handle, Light, Plug, Thermostat
from homebot.devices.journal_messages import (
    EntryKind,
    ExplainDevice,
    ExplainDeviceRequest,
    ExplainDeviceResponse,
    ExplainMissingStateRequest,
    ExplainMissingStateResponse,
    JournalEntry,
    ReadJournalRequest,
    ReadJournalResponse,
)
from homebot.devices.names import EXPLAIN_DEVICE
from homebot.devices.outcomes import Contradicted, NoAnswer
from homebot.devices.trigger import NO_TRIGGER, Trigger
from homebot.devices.wording.journal_words import finding_text
from homebot.graph import Node
from homebot.journal.store import JournalNote, JournalStore
from homebot.messages import Time

virtual_time = pytest.mark.virtual_time

ROBOT = """
import json, sys, roslibpy

ros = roslibpy.Ros("127.0.0.1", int(sys.argv[1]), transport="asyncio")
ros.run(timeout=60)

def call(name, kind, **request):
    return dict(roslibpy.Service(ros, name, kind).call(roslibpy.ServiceRequest(request), timeout=60))

why = call("/control/why", "homebot/ExplainDevice", device="lamp")
why_not = call("/control/why_not", "homebot/ExplainMissingState", device="lamp", state="on")
print(json.dumps([why, why_not]))
ros.terminate()
"""


async def explain(home: Home, device: str) -> ExplainDeviceResponse:
    await anyio.sleep(1)  # the directory publishes changes together
    return await home.app.create_client(ExplainDevice, EXPLAIN_DEVICE).call(ExplainDeviceRequest(device=device))


def changes(entries: tuple[JournalEntry, ...]) -> list[tuple[str, str]]:
    return [(one.kind, one.cause) for one in entries if one.kind in {"reported", "changed"}]


async def lamp_in(home: Home) -> Light:
    home.put("lamp", "light", "on_off", "level")
    await home.report("lamp", "on_off", False)
    await home.report("lamp", "level", 20.0)
    await anyio.sleep(20)
    return await home.handle(Light)


@virtual_time
async def test_a_change_by_a_command_is_explained_by_its_entries(home: Home) -> None:
    lamp = await lamp_in(home)
    assert (await lamp.turn_on()).succeeded
    found = await explain(home, lamp.device.id)
    assert (found.finding, found.entries[0].kind, found.entries[0].issuer) == ("command", "requested", "/app")
    assert changes(found.entries) == [("reported", "command")]


@virtual_time
async def test_a_value_that_comes_along_a_moment_later_is_explained_by_the_command(home: Home) -> None:
    lamp = await lamp_in(home)

    async def brighten(home: Home, command: Command) -> None:
        await obey(home, command)
        home.later(2.0, "lamp", "level", 60.0)

    home.behaviours["lamp"] = brighten
    await lamp.turn_on()
    await anyio.sleep(5)
    found = await explain(home, lamp.device.id)
    assert (found.finding, found.entries[0].kind) == ("command", "requested")


@virtual_time
async def test_a_command_is_explained_by_the_very_report_that_an_app_answered(home: Home) -> None:
    lamp = await lamp_in(home)
    home.put("plug", "plug", "on_off")
    plug = await home.handle(Plug, "plug")

    async def follow() -> None:
        async for change in home.devices.follow(Light, on=True):
            if change.kind == "appeared":
                await anyio.sleep(30)
                await plug.turn_on()

    home.tasks.start_soon(follow)
    await anyio.sleep(1)
    await home.report("lamp", "on_off", True)
    told_at = home.graph.clock.now()
    await anyio.sleep(0.5)
    await home.report("lamp", "on_off", False)
    await home.report("lamp", "on_off", True)
    await anyio.sleep(40)
    found = await explain(home, plug.device.id)
    cause = found.entries[0]
    assert (cause.kind, cause.device, cause.cause) == ("changed", lamp.device.id, "person")
    assert cause.at == found.entries[1].trigger.at == Time.from_seconds(told_at)


@virtual_time
async def test_a_late_answer_is_explained_by_the_command_that_failed(home: Home) -> None:
    lamp = await lamp_in(home)
    home.behaviours["lamp"] = ignore
    assert isinstance(await lamp.turn_on(), NoAnswer)
    await anyio.sleep(20)
    await home.report("lamp", "on_off", True)
    found = await explain(home, lamp.device.id)
    assert (found.finding, changes(found.entries)) == ("command", [("reported", "command")])
    await home.report("lamp", "on_off", True)  # again, which is no change
    assert len((await explain(home, lamp.device.id)).entries) == len(found.entries)


@virtual_time
async def test_a_late_answer_that_is_the_first_live_report_is_explained_by_the_command(home: Home) -> None:
    """Of a lamp of which only a retained value was known."""
    home.put("lamp", "light", "on_off")
    await home.gateway.devices.report("lamp", {"on_off": False}, retained=True)
    await anyio.sleep(20)
    lamp = await home.handle(Light)
    home.behaviours["lamp"] = ignore
    assert isinstance(await lamp.turn_on(), NoAnswer)
    await home.report("lamp", "on_off", True)
    found = await explain(home, lamp.device.id)
    assert (found.finding, changes(found.entries)) == ("command", [("reported", "command")])


@virtual_time
@pytest.mark.parametrize(("seconds", "is_answer"), [(100.0, True), (880.0, True), (920.0, False)])
async def test_the_wanted_value_after_minutes_of_silence_is_the_answer(
    home: Home, seconds: float, *, is_answer: bool
) -> None:
    """A battery valve wakes up now and then."""
    lamp = await lamp_in(home)
    await home.report("lamp", "on_off", False)
    home.behaviours["lamp"] = ignore
    assert isinstance(await lamp.turn_on(), NoAnswer)
    await anyio.sleep(seconds)
    await home.report("lamp", "on_off", True)
    found = await explain(home, lamp.device.id)
    expected = ("command", [("reported", "command")]) if is_answer else ("change", [("changed", "person")])
    assert (found.finding, changes(found.entries)) == expected


@virtual_time
@pytest.mark.parametrize("before", ["a newer command", "a person"])
async def test_only_the_newest_unanswered_command_is_answered_late(home: Home, before: str) -> None:
    lamp = await lamp_in(home)
    await home.report("lamp", "on_off", True)
    await home.report("lamp", "level", 10.0)
    home.behaviours["lamp"] = ignore
    assert isinstance(await lamp.set_level(70), NoAnswer)
    await anyio.sleep(100)
    if before == "a person":
        await home.report("lamp", "level", 20.0)
        await anyio.sleep(100)
        await home.report("lamp", "level", 30.0)
    else:
        home.behaviours["lamp"] = obey
        assert (await lamp.set_level(30)).succeeded
    await anyio.sleep(100)
    await home.report("lamp", "level", 70.0)
    found = await explain(home, lamp.device.id)
    assert (found.finding, changes(found.entries)) == ("change", [("changed", "person")])


@virtual_time
async def test_a_value_near_the_wanted_one_minutes_later_is_no_answer(home: Home) -> None:
    valve = await home.new(Thermostat, "valve", "heating_setpoint", before={"heating_setpoint": 17.0}, behaviour=ignore)
    assert isinstance(await valve.heat_to(21.0), NoAnswer)
    await anyio.sleep(100)
    await home.report("valve", "heating_setpoint", 21.5)
    await anyio.sleep(100)
    await home.report("valve", "heating_setpoint", 21.0)
    found = await explain(home, valve.device.id)
    assert (found.finding, changes(found.entries)) == ("change", [("changed", "person")])


@virtual_time
async def test_another_value_in_answer_to_a_command_is_explained_by_it(home: Home) -> None:
    lamp = await lamp_in(home)
    await home.report("lamp", "on_off", True)
    await anyio.sleep(20)
    home.behaviours["lamp"] = report((0.1, 10.0))
    assert isinstance(await lamp.set_level(50), Contradicted)
    found = await explain(home, lamp.device.id)
    assert (found.finding, changes(found.entries)) == ("command", [("reported", "unknown")])


@virtual_time
async def test_an_unknown_device_is_named_in_the_answer(home: Home) -> None:
    found = await explain(home, "nowhere")
    assert (found.success, found.message) == (False, "there is no device with the id nowhere")


@pytest.mark.system
async def test_a_robot_asks_over_rosbridge(open_home: OpenHome) -> None:
    async with open_home() as home:
        RosApi(Node(home.graph, "rosapi"))
        door = RosbridgeServer(Node(home.graph, "rosbridge_websocket"), RosbridgeSettings(port=0))
        await home.tasks.start(door.run)
        lamp = await home.lamp("on_off")
        assert (await lamp.turn_on()).succeeded
        with anyio.fail_after(PATIENCE):
            done = await anyio.run_process([sys.executable, "-c", ROBOT, str(door.port)])
        why, why_not = json.loads(done.stdout)
    assert (why["finding"], why["entries"][0]["issuer"], why["names"][0]["value"]) == ("command", "/app", "Lamp")
    assert (why_not["is_so"], why_not["problem"], why_not["word"]) == (True, "", "on")


def blind(*settable: str, readable: tuple[str, ...] = ()) -> Device:
    values = dict.fromkeys(readable, True)
    return make_device("blind", "window_covering", settable=settable, values=values)


@virtual_time
async def test_a_sensor_changed_when_it_reported_that(home: Home) -> None:
    """It was said to have reported no change, as its changes are no entries of the journal."""
    window = await home.new(ContactSensor, "window", readable=("contact",), before={"contact": True})
    await anyio.sleep(20)
    changed_at = home.graph.clock.now()
    await home.report("window", "contact", False)
    found = await explain(home, window.device.id)
    assert (found.finding, found.entries) == ("change", ())
    assert found.changed_at.to_seconds() == pytest.approx(changed_at, abs=0.5)


@virtual_time
async def test_a_value_that_is_the_first_of_a_new_device_has_been_so_since_it_was_heard_of(home: Home) -> None:
    """However long after its announcement it came; of a device of an earlier run it is only the first report."""
    home.put("lamp", "light", "on_off")
    await anyio.sleep(60)
    await home.report("lamp", "on_off", True)
    lamp = await home.handle(Light)
    assert (await explain(home, lamp.device.id)).finding == "heard"
    await home.report("lamp", "on_off", False)
    assert (await explain(home, lamp.device.id)).finding == "change"


@virtual_time
async def test_a_press_explains_a_button_also_one_equal_to_the_one_before(home: Home) -> None:
    """It was said to have reported no change."""
    home.put("button", "generic_switch", readable=("press",))
    for _ in range(2):
        await anyio.sleep(20)
        pressed_at = home.graph.clock.now()
        await home.report("button", "press", "single")
        found = await explain(home, (await home.devices.find(Handle))[0].device.id)
        assert found.finding == "event"
        assert found.changed_at.to_seconds() == pytest.approx(pressed_at, abs=0.5)
        assert finding_text(found, {}, pressed_at).startswith("It reported press single just now")


@virtual_time
@pytest.mark.parametrize(("seconds", "finding"), [(0.2, "change"), (30.0, "event")])
async def test_a_press_explains_a_relay_only_if_the_relay_did_not_follow(
    home: Home, seconds: float, finding: str
) -> None:
    home.put("relay", "switch", "on_off", readable=("press",))
    await home.report("relay", "on_off", False)
    await anyio.sleep(20)
    await home.report("relay", "on_off", True)
    await anyio.sleep(seconds)
    await home.report("relay", "press", "single")
    found = await explain(home, (await home.devices.find(Handle))[0].device.id)
    assert found.finding == finding


async def test_a_report_that_was_on_its_way_while_the_command_was_given_does_not_end_the_chain() -> None:
    def note(kind: EntryKind, at: float, command: str, trigger: Trigger = NO_TRIGGER, *, value: bool = True) -> None:
        setting = Setting.of("on_off", value)
        store.add(JournalNote(kind, at, "lamp", "", command, trigger=trigger, settings=(setting,), cause="command"))

    def by_message(at: float) -> Trigger:
        return Trigger(kind="message", device="lamp", text="on", at=Time.from_seconds(at))

    store = JournalStore(100, 1000.0)
    note("requested", 10.0, "1")
    note("reported", 10.1, "1")
    note("reported", 10.2, "2")  # the lamp repeats itself, and is heard before the app asks for off
    note("requested", 10.3, "2", value=False, trigger=by_message(10.1))
    note("requested", 10.4, "3", value=False, trigger=by_message(10.2))
    note("reported", 10.5, "3", value=False)
    lamp = make_device("lamp", "light", settable=("on_off",), values={"on_off": False}, since=10.5)

    async def find(_: str) -> Device | None:
        return lamp

    found = await Explanations(store.read, find).explain(ExplainDeviceRequest(device="lamp"))
    assert [entry.command for entry in found.entries] == ["1", "1", "2", "2", "3", "3"]


async def missing(device: Device, state: str) -> ExplainMissingStateResponse:
    async def read(_: ReadJournalRequest) -> ReadJournalResponse:
        return ReadJournalResponse()

    async def find(_: str) -> Device | None:
        return device

    return await Explanations(read, find).explain_missing(ExplainMissingStateRequest(device="blind", state=state))


BLIND = blind("movement", "position")


@pytest.mark.parametrize("wanted", ["open", "Closed", "close", "stopped", "40", "position 40"])
async def test_a_state_of_the_vocabulary_is_possible(wanted: str) -> None:
    assert (await missing(BLIND, wanted)).problem == ""


@pytest.mark.parametrize(
    ("device", "wanted", "sentence"),
    [
        (BLIND, "sunny", "It has no state 'sunny'. It takes movement open, closed, stopped; position 0 to 100 %."),
        (blind(readable=("occupancy",)), "on", "It takes no commands; it only reports."),
        (BLIND.model_copy(update={"parts": ()}), "on", ""),
        (blind("x_fizz"), "lit", ""),
    ],
)
async def test_an_impossible_state_is_explained_by_the_possible_ones(
    device: Device, wanted: str, sentence: str
) -> None:
    assert (await missing(device, wanted)).problem == sentence


@pytest.mark.parametrize(
    ("wanted", "word"),
    [("closed", "close"), ("close", "close"), ("locked", "lock"), ("on", "on"), ("level 40", ""), ("lit", "")],
)
async def test_a_state_with_a_single_word_names_it(wanted: str, word: str) -> None:
    assert (await missing(BLIND, wanted)).word == word
