"""The device in view is identified, and everything is put back; in virtual time."""

from __future__ import annotations

import math
from datetime import time
from itertools import pairwise

import anyio
import pytest
from tests.control.conftest import Home, hold_request, ignore, obey_after
from tests.features.identify.conftest import Room

from homebot.devices.gateway_messages import Command
from homebot.devices.names import TAG_DEVICE, WHERE_IS_ROBOT
from homebot.devices.outcomes import Refused
from homebot.devices.places_messages import TagDevice, TagDeviceRequest
from homebot.devices.robot_messages import RobotPose, WhereIsRobot, WhereIsRobotResponse
from homebot.errors import RefusedError
from homebot.graph.actions import GoalState
from homebot.messages import Time

pytestmark = pytest.mark.virtual_time


async def test_the_lamp_in_view_is_found_and_all_are_as_before(room: Room) -> None:
    await room.lamps(5, 10, 60, 3)
    before = await room.is_on()
    found = await room.identify()
    assert (found.success, found.name, found.message) == (True, "Lamp2", "Lamp2 is in view")
    assert found.probability >= 0.99
    effect = found.candidates[2]
    assert abs(effect.effect - 60) < 3 * effect.deviation < 60
    assert await room.is_on() == before
    assert await room.home.leases() == ()
    assert room.store == {}
    assert room.feedback[-1].candidates == found.candidates


async def test_none_of_them_is_an_answer(room: Room) -> None:
    await room.lamps(2, 1, 2, 1)
    found = await room.identify()
    limit = found.message.split()[-1]
    assert 2 < float(limit) < 20
    assert (found.success, found.device, found.message) == (
        True,
        "",
        f"none of the candidates is in view: it does not change what is seen by {limit}",
    )
    assert found.none >= 0.99


async def test_one_device_is_verified(room: Room) -> None:
    await room.lamps(5, 60)
    assert (await room.identify(candidates="Lamp1")).name == "Lamp1"
    assert (await room.identify(candidates="Lamp0")).message.startswith("Lamp0 is not in view: ")


async def test_lamps_that_are_as_like_are_not_sure(room: Room) -> None:
    await room.lamps(60, 60)
    before = await room.is_on()
    found = await room.identify(seconds=20)
    assert not found.success
    assert found.message.startswith("not sure: ")
    assert await room.is_on() == before


async def test_a_lamp_that_does_not_obey_drops_out_and_the_rest_is_identified(room: Room) -> None:
    await room.lamps(5, 10, 60, 3)
    room.home.behaviours["lamp1"] = ignore
    before = await room.is_on()
    found = await room.identify()
    assert found.name == "Lamp2"
    assert "Lamp1 took no part to the end: no answer" in found.message
    assert await room.is_on() == before


async def test_lamps_that_refuse_are_named_and_not_put_back(room: Room) -> None:
    await room.lamps(60, 5)

    async def refuse(*_: object) -> None:
        raise RefusedError("a command", "the gateway only observes")

    room.home.behaviours |= {"lamp0": refuse, "lamp1": refuse}
    found = await room.identify()
    assert found.message.startswith("no candidate takes part any more: Lamp")
    assert "the gateway only observes" in found.message
    assert room.store == {}
    assert len(room.home.commands) == 1 + 1


async def test_slow_lamps_are_awaited(room: Room) -> None:
    await room.lamps(5, 10, 60, 3)
    for number in range(4):
        room.home.behaviours[f"lamp{number}"] = obey_after(2.0)
    assert (await room.identify()).name == "Lamp2"


async def test_a_lamp_that_a_person_switches_drops_out_and_stays_as_the_person_left_it(room: Room) -> None:
    await room.lamps(5, 10, 60, 3)
    goal = await room.begin()
    await anyio.sleep(5.0)
    is_on = (await room.is_on())["Lamp0"]
    await room.by_person("lamp0", is_on=not is_on)
    found = (await goal.result())[1]
    assert found.name == "Lamp2"
    assert "it was changed meanwhile" in found.candidates[0].problem
    assert await room.is_on() == {"Lamp0": not is_on, "Lamp1": True, "Lamp2": False, "Lamp3": True}


@pytest.mark.parametrize("wanted", [False, True])
async def test_a_lamp_that_a_person_commands_obeys_drops_out_and_stays_so(room: Room, *, wanted: bool) -> None:
    """Whether it is as the person wants just then or not."""
    await room.lamps(5, 10, 60, 3)
    goal = await room.begin()
    await anyio.sleep(5.0)
    assert (await room.command("lamp0", is_on=wanted)).succeeded
    found = (await goal.result())[1]
    assert found.name == "Lamp2"
    assert found.candidates[0].problem == "it was changed meanwhile: contradicted: a command by the client owner"
    assert await room.is_on() == {"Lamp0": wanted, "Lamp1": True, "Lamp2": False, "Lamp3": True}
    entries = [one for one in (await room.home.read()).entries if one.kind == "outranked"]
    assert [(one.device, one.issuer) for one in entries] == [("lamp0", "client:owner")]
    assert (room.store, await room.home.leases()) == ({}, ())


async def test_what_an_app_commands_by_itself_is_refused_while_it_blinks(room: Room) -> None:
    await room.lamps(5, 10, 60, 3)
    before, goal = await room.is_on(), await room.begin()
    await anyio.sleep(5.0)
    is_on = (await room.is_on())["Lamp0"]
    assert isinstance(await room.command("lamp0", is_on=not is_on, issuer="/app"), Refused)
    assert (await goal.result())[1].name == "Lamp2"
    assert await room.is_on() == before


async def test_a_cancelled_goal_leaves_everything_as_before(room: Room) -> None:
    await room.lamps(5, 10, 60, 3)
    before = await room.is_on()
    goal = await room.begin()
    await anyio.sleep(4.4)
    goal.request_cancel()
    state, found = await goal.result()
    assert (state, found.message) == (GoalState.CANCELED, "cancelled; everything is as before")
    assert await room.is_on() == before
    assert await room.home.leases() == ()


async def test_a_sensor_that_sees_nothing_is_an_error_before_anything_changes(room: Room) -> None:
    await room.lamps(5, 60)
    room.is_seeing = False
    found = await room.identify()
    assert found.message == "nothing was published on /rosie/light within 5 s; is its robot on?"
    assert room.home.commands == []


async def test_a_robot_that_does_not_exist_is_refused_before_anything_changes(room: Room) -> None:
    problem = "there is no robot 'rosy'; did you mean rosie?"
    answer = WhereIsRobotResponse(success=False, message=problem, is_mistake=True)
    room.home.app.create_service(WhereIsRobot, WHERE_IS_ROBOT, lambda _: answer)
    await room.lamps(5, 60)
    assert (await room.identify(robot="rosy", distance=2.0)).message == problem
    assert room.home.commands == []


async def test_a_sensor_that_does_not_exist_is_refused_with_those_that_do(room: Room) -> None:
    await room.lamps(5, 60)
    found = await room.identify(topic="Attic sensor")
    assert found.message.endswith("nor a device with a light sensor; there are /rosie/light")
    assert room.home.commands == []


@pytest.mark.parametrize("wrong", [math.nan, math.inf, -math.inf, 1e300])
async def test_what_is_no_number_is_not_seen(room: Room, wrong: float) -> None:
    await room.lamps(5, 10, 60, 3)
    room.seen = lambda value: wrong if room.random.random() < 0.3 else value
    assert (await room.identify()).name == "Lamp2"
    room.seen = lambda _: wrong
    found = await room.identify()
    assert found.message == f"nothing on /rosie/light can be read: {wrong:g} is no value of a sensor"


async def test_a_sensor_that_stops_in_the_middle_leaves_everything_as_before(room: Room) -> None:
    await room.lamps(5, 10, 60, 3)
    before = await room.is_on()
    goal = await room.begin()
    await anyio.sleep(6.0)
    room.is_seeing = False
    assert (await goal.result())[1].message.startswith("nothing was published on /rosie/light")
    assert await room.is_on() == before
    assert room.store == {}


async def test_a_sensor_that_jumps_and_flashes_is_believed_for_the_rest(room: Room) -> None:
    """The sun comes out, and a bulb flickers now and then."""
    await room.lamps(5, 10, 60, 3)
    goal = await room.begin()
    await anyio.sleep(4.5)
    room.seen = lambda value: value + 600 + (5000 if room.random.random() < 0.02 else 0)
    assert (await goal.result())[1].name == "Lamp2"


async def test_a_topic_that_is_not_there_is_an_error_with_the_nearest_name(room: Room) -> None:
    await room.lamps(60)
    found = await room.identify(topic="/rosie/ligth")
    assert found.message.endswith("did you mean /rosie/light?")


async def test_the_light_sensor_of_the_room_looks_if_none_is_named(room: Room) -> None:
    await room.lamp("lamp", 60)
    found = await room.identify(topic="")
    asked = "say what looks, with `topic` (`--with`), as 0 light sensors are in its room; there are /rosie/light"
    assert found.message == asked
    room.home.put("lux", "light_sensor", readable=("illuminance",), area="Hall")
    await room.home.report("lux", "illuminance", 100.0)

    async def obey_and_shine(home: Home, command: Command) -> None:
        await home.report(command.key, "on_off", command.value.flag)
        home.later(0.3, "lux", "illuminance", 160.0 if command.value.flag else 100.0)

    room.home.behaviours["lamp"] = obey_and_shine
    assert (await room.identify(topic="")).message == "Lamp is in view"


async def test_people_are_told_before_it_begins(room: Room) -> None:
    await room.lamps(60)
    goal = await room.begin()
    await anyio.sleep(2.2)  # it looks before
    assert room.home.commands == []
    assert room.told == ["Identify: identify by rosie: Lamp0 change for up to 60 s, and are put back"]
    await goal.result()


async def test_it_ends_and_everything_is_as_before_when_the_night_begins(room: Room) -> None:
    await room.lamps(5, 10, 60, 3)
    before, room.now = await room.is_on(), "21:59"
    goal = await room.begin()
    await anyio.sleep(6.0)
    room.now = "22:00"
    found = (await goal.result())[1]
    assert found.message.startswith("the identification was refused: it is 22:00, and people sleep")
    assert (await room.is_on(), room.store) == (before, {})


async def test_it_ends_and_everything_is_as_before_when_a_person_goes_to_bed(room: Room) -> None:
    await room.lamps(5, 10, 60, 3)
    room.home.put("bed", "occupancy_sensor", readable=("occupancy",), area="hall")
    await room.home.report("bed", "occupancy", False)
    await anyio.sleep(0.1)
    bed = next(one for one in await room.home.devices.find() if one.name == "Bed")
    await room.home.app.create_client(TagDevice, TAG_DEVICE).call(TagDeviceRequest(device=bed.id, tag="bed"))
    before, goal = await room.is_on(), await room.begin(at_night=True)
    await anyio.sleep(6.0)
    await room.home.report("bed", "occupancy", True)
    commands = len(room.home.commands)
    found = (await goal.result())[1]
    assert found.message == "the rest of the identification was refused: somebody sleeps in hall now"
    assert len(room.home.commands) <= commands + 4
    assert (await room.is_on(), room.store) == (before, {})


@pytest.mark.parametrize("now", ["22:00", "03:00", "06:59"])
async def test_nothing_is_changed_at_night_unless_asked(room: Room, now: str) -> None:
    await room.lamps(60)
    room.now = now
    found = await room.identify()
    assert found.message == (
        f"the identification was refused: it is {now}, and people sleep from 22:00 to 07:00; "
        "`at_night` (`--night`) allows it"
    )
    assert room.home.commands == []
    assert (await room.identify(at_night=True)).name == "Lamp0"


async def test_nothing_is_changed_in_quiet_hours_unless_asked(room: Room) -> None:
    await room.lamps(60)
    room.quiet = [(time(11), time(14))]
    assert "people sleep from 11:00 to 14:00" in (await room.identify()).message


async def test_what_may_not_change_is_left_out_with_the_reason(room: Room) -> None:
    home = room.home
    await room.lamp("lamp", 60)
    await room.lamp("cot", 60, area="nursery")
    home.put("bed", "occupancy_sensor", readable=("occupancy",), area="nursery")
    home.put("new", "light", "on_off", area="hall")
    home.put("oven", "plug", "on_off", area="hall", name="Oven")
    await home.report("oven", "on_off", True)
    await home.report("bed", "occupancy", True)
    await anyio.sleep(0.1)
    bed = next(one for one in await home.devices.find() if one.name == "Bed")
    await home.app.create_client(TagDevice, TAG_DEVICE).call(TagDeviceRequest(device=bed.id, tag="bed"))
    found = await room.identify(candidates="light or plug")
    assert found.name == "Lamp"
    assert {one.key: one.value for one in found.left_out} == {
        "Cot": "somebody sleeps in nursery",
        "New": "it has no two levels whose state is known",
        "Oven": "it always asks: the name 'Oven' says 'oven'",
    }


async def test_the_position_of_what_is_found_is_kept_from_the_pose_of_the_robot(room: Room) -> None:
    pose = RobotPose(
        robot="rosie",
        has_position=True,
        x=1.0,
        y=2.0,
        yaw=math.pi / 2,
        error=0.4,
        received_at=Time(sec=0, nanosec=0),
        limit=5.0,
    )
    answer = WhereIsRobotResponse(success=True, pose=(pose,))
    room.home.app.create_service(WhereIsRobot, WHERE_IS_ROBOT, lambda _: answer)
    await room.lamps(60)
    found = await room.identify(robot="rosie", bearing=math.pi / 2, distance=2.0)
    assert (found.message, found.at) == ("Lamp0 is in view", "-1.00,2.00 ±0.50 m")
    (lamp,) = await room.home.devices.find()
    assert [one.value for one in lamp.facts if one.name == "position"] == ["-1,2 ±0.5 m"]


async def test_a_robot_that_is_lost_keeps_no_position(room: Room) -> None:
    await room.lamps(60)
    found = await room.identify(robot="rosie", distance=2.0)
    assert found.success
    assert found.message.startswith("Lamp0 is in view; its position is not kept: ")
    assert found.at == ""


async def test_a_client_changes_nothing_that_it_may_not_command(room: Room) -> None:
    await room.lamps(60, 5)
    found = await room.identify(scope=("act: light in kitchen",))
    assert found.message.startswith("nothing of 'light in hall' can be identified; Lamp0: ")
    assert room.home.commands == []


async def test_a_lamp_that_is_gone_in_the_middle_drops_out(room: Room) -> None:
    await room.lamps(5, 10, 60, 3)
    goal = await room.begin()
    await anyio.sleep(4.5)
    room.home.gateway.devices.remove("lamp1", "the test says so")
    found = (await goal.result())[1]
    assert found.name == "Lamp2"
    assert await room.is_on() == {"Lamp0": False, "Lamp2": False, "Lamp3": True}


async def test_two_goals_run_one_after_the_other(room: Room) -> None:
    await room.lamps(5, 60)
    first, second = await room.begin(candidates="Lamp1"), await room.begin(candidates="Lamp0")
    assert (await first.result())[1].name == "Lamp1"
    assert (await second.result())[1].message.startswith("Lamp0 is not in view: ")


async def test_lamps_that_are_held_are_left_out_and_stay_as_they_are(room: Room) -> None:
    await room.lamps(5, 10, 60, 3)
    await room.home.hold(hold_request("lamp1", "on_off", True, ttl=600.0))
    found = await room.identify(issuer="client:other")
    assert found.name == "Lamp2"
    assert "held on by robot" in found.candidates[1].problem
    assert [one.device for one in await room.home.leases()] == ["lamp1"]


async def test_a_blind_is_told_by_its_slow_moves(room: Room) -> None:
    home = room.home

    async def move(home: Home, command: Command) -> None:
        start, wanted = room.values[command.key], command.value.number
        steps = [start + (wanted - start) * step / 10 for step in range(1, 11)]
        room.values[command.key] = wanted
        for number, value in enumerate(steps):
            home.later(number + 1.0, command.key, "position", value)

    for key, effect in (("blind", 60.0), ("shade", 5.0)):
        home.put(key, "window_covering", "position", area="hall")
        await home.report(key, "position", 40.0)
        room.effects[key], room.values[key], home.behaviours[key] = effect, 40.0, move
    found = await room.identify(candidates="window_covering in hall", seconds=300)
    assert (found.name, room.values) == ("Blind", {"blind": 40.0, "shade": 40.0}), found.message
    assert all(two.at - one.at > 11 for one, two in pairwise(found.looks) if one.levels != two.levels)


async def test_a_lamp_that_reports_its_fade_is_awaited(room: Room) -> None:
    await room.lamp("lamp", 60)
    home = room.home

    async def fade(home: Home, command: Command) -> None:
        await home.report(command.key, "on_off", command.value.plain())
        for step in range(1, 5):
            home.later(0.5 * step, command.key, "level", 25.0 * step if command.value.plain() else 100.0 - 25 * step)

    home.put("lamp", "light", "on_off", "level", area="hall")
    home.behaviours["lamp"] = fade
    found = await room.identify()
    assert found.name == "Lamp"
    fades = [two.at - one.at for one, two in pairwise(found.looks) if one.levels != two.levels]
    assert min(fades) > 1 + 2 + 0.7


@pytest.mark.parametrize(("fade", "longest"), [(2.0, 35.0), (4.0, 60.0)])
async def test_lamps_that_report_at_once_and_fade_on_are_told_apart(room: Room, fade: float, longest: float) -> None:
    await room.lamps(5, 10, 60, 3)
    room.fade = fade
    for target in (60.0, 5.0):
        room.effects["lamp2"] = target
        found = await room.identify(least_effect=25.0)
        assert (found.success, found.name) == (True, "Lamp2" if target > 25 else ""), found.message
        assert found.looks[-1].at < longest


async def test_lamps_are_told_to_change_in_a_moment_and_nothing_else_is(room: Room) -> None:
    await room.lamp("lamp", 60)
    room.home.put("fan", "fan", "on_off", area="hall")
    await room.home.report("fan", "on_off", False)
    await room.identify(candidates="light or fan")
    while_held = [one for one in room.home.commands if one.value.flag]
    assert {(one.key, one.transition) for one in while_held} == {("lamp", 0.1), ("fan", 0.0)}


async def test_a_dimmer_without_a_switch_changes_between_two_levels(room: Room) -> None:
    room.home.put("lamp", "light", "level", area="hall")
    await room.home.report("lamp", "level", 40.0)
    found = await room.identify(seconds=10)
    assert found.looks, found.message
    assert {one.value.plain() for one in room.home.commands} == {1.0, 100.0, 40.0}
    assert found.looks[1].levels == (1.0,)
