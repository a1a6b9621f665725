"""Lights out in a simulated flat in virtual time: never over somebody, never where nobody can know."""

import pytest
from structlog.testing import capture_logs
from tests.apps.houses import flat, hall, is_on, lamp, motion, warnings
from tests.robots.test_tracker import path, stamped

from homebot.devices.names import FORGET_DEVICE
from homebot.devices.services import ForgetDevice, ForgetDeviceRequest
from homebot.graph import Node
from homebot.messages.geometry_msgs import PoseStamped
from homebot.messages.nav_msgs import Path
from homebot.testing import virtual_house_of

pytestmark = [pytest.mark.slow, pytest.mark.virtual_time, pytest.mark.rooms("homeassistant")]


async def test_the_lamps_of_a_room_go_off_when_everybody_has_left_it_for_a_while() -> None:
    """21 minutes after the sensor became quiet, which is a minute after Anna left."""
    world = hall(("08:00", "study"), ("09:00", "outside"))
    async with virtual_house_of("lights_out", world=world) as house:
        await house.run_until("08:00:30")
        await house.press("hall_lamp", "on")
        await house.run_until("08:22")
        assert is_on(world, "hall_lamp")
        await house.run_until("08:23:30")
        assert not is_on(world, "hall_lamp")


async def test_the_time_can_be_set() -> None:
    world = hall()
    config = {"apps": {"lights_out": {"quiet_after": 120}}}
    async with virtual_house_of(world=world, config=config) as house:
        await house.run_for("1h")
        await house.press("hall_lamp", "on")
        await house.run_for(119)
        assert is_on(world, "hall_lamp")
        await house.run_for(2)
        assert not is_on(world, "hall_lamp")


@pytest.mark.parametrize("guards", [False, True], ids=["alone", "guarded"])
async def test_the_lamps_on_a_robot_s_way_stay_on_while_it_lives(*, guards: bool) -> None:
    """It stands in the study, plans its way to the hall, drives, and dies before it is there."""
    square = {"study": [[4, -1], [6, -1], [6, 1], [4, 1]], "hall": [[-1, -1], [4, -1], [4, 1], [-1, 1]]}
    rooms = {room: {"polygon": polygon} for room, polygon in square.items()}
    config = {"apps": {"lights_out": {"quiet_after": 120}}, "robots": {"rosie": {}}, "places": {"rooms": rooms}}
    if guards:
        config["control"] = {"presence_guard": {"absent_after": 60}}
    world = hall(("08:00", "hall"), ("08:01", "outside"))
    async with virtual_house_of(world=world, config=config) as house, Node(house.runtime.graph, "rosie") as rosie:
        poses = rosie.create_publisher(PoseStamped, "/rosie/pose")
        plans = rosie.create_publisher(Path, "/rosie/plan")
        await house.run_until("08:02")
        await house.press("hall_lamp", "on")
        plans.publish(path((5, 0), (0, 0)))
        for step in range(40):
            poses.publish(stamped(5 - step / 10, 0))
            await house.run_for(4)
        assert is_on(world, "hall_lamp")
        await house.run_for("10m")
        assert not is_on(world, "hall_lamp")


async def test_a_lamp_stays_on_while_somebody_moves_and_another_room_goes_dark() -> None:
    """Anna walks to and fro in the hall; the kitchen is empty."""
    to_and_fro = [(f"08:{minute:02}", "hall" if minute % 2 else "outside") for minute in range(1, 40)]
    world = hall(*to_and_fro, kitchen_lamp=lamp("kitchen"), kitchen_motion=motion("kitchen"))
    async with virtual_house_of("lights_out", world=world) as house:
        await house.run_until("08:01:30")
        await house.press("hall_lamp", "on")
        await house.press("kitchen_lamp", "on")
        await house.run_until("08:39")
        assert is_on(world, "hall_lamp")
        assert not is_on(world, "kitchen_lamp")


async def test_nothing_is_turned_off_in_a_room_without_a_motion_sensor() -> None:
    world = flat(hall_motion=motion("hall"), study_lamp=lamp("study"))
    async with virtual_house_of("lights_out", world=world) as house:
        await house.press("study_lamp", "on")
        await house.run_for("3h")
        assert is_on(world, "study_lamp")


async def test_nothing_is_turned_off_while_one_of_two_sensors_is_without_power() -> None:
    """What the other one says is not enough; when both tell again, the countdown begins anew."""
    world = hall(far_motion=motion("hall", faults={"unplugged": {"since": 3_600.0, "until": 10_800.0}}))
    async with virtual_house_of("lights_out", world=world) as house:
        await house.run_until("01:05")
        await house.press("hall_lamp", "on")
        await house.run_until("03:15")
        assert is_on(world, "hall_lamp")
        await house.run_until("03:25")
        assert not is_on(world, "hall_lamp")


async def test_what_the_guard_refused_is_tried_again_ever_more_seldom() -> None:
    """The sensor is quiet from 08:02 on, and the guard believes so five minutes later."""
    world = hall(("08:00", "hall"), ("08:01", "outside"))
    config = {"apps": {"lights_out": {"quiet_after": 60}}, "control": {"presence_guard": {"absent_after": 300}}}
    with capture_logs() as lines:
        async with virtual_house_of(world=world, config=config) as house:
            await house.run_until("08:00:30")
            await house.press("hall_lamp", "on")
            await house.run_until("08:06")
            assert is_on(world, "hall_lamp")
            await house.run_until("08:12")
            assert not is_on(world, "hall_lamp")
    refusals = warnings(lines)
    assert 1 < len(refusals) < 5
    assert all("refused (presence_guard)" in one for one in refusals)


async def test_a_lamp_that_the_guard_never_gives_free_is_tried_once_an_hour() -> None:
    """Nobody ever walked past the sensor, so the guard does not believe it."""
    world = hall()
    config = {"control": {"presence_guard": True}}
    with capture_logs() as lines:
        async with virtual_house_of("lights_out", world=world, config=config) as house:
            await house.press("hall_lamp", "on")
            await house.run_for("1d")
    refusals = [line for line in lines if line["event"] == "control.command"]
    assert 20 < len(refusals) < 30


@pytest.mark.parametrize(("unplugged", "forgotten", "off"), [("01:05", "01:06", "01:28"), ("01:00", "03:00", "04:30")])
async def test_the_room_is_looked_at_again_when_a_sensor_was_forgotten_that_is_without_power(
    unplugged: str, forgotten: str, off: str
) -> None:
    """Before the countdown is over, and long after it."""
    since = 3600.0 + 60 * int(unplugged[3:])
    world = hall(far_motion=motion("hall", faults={"unplugged": {"since": since, "until": 86_400.0}}))
    async with virtual_house_of("lights_out", world=world) as house, Node(house.runtime.graph, "owner") as owner:
        await house.run_until("01:04")
        await house.press("hall_lamp", "on")
        await house.run_until(forgotten)
        assert is_on(world, "hall_lamp")
        forget = owner.create_client(ForgetDevice, FORGET_DEVICE)
        assert (await forget.call(ForgetDeviceRequest(device="far_motion"))).success
        await house.run_until(off)
        assert not is_on(world, "hall_lamp")


async def test_a_deaf_lamp_is_told_about_with_what_became_of_the_command() -> None:
    world = hall(hall_lamp=lamp("hall", faults={"deaf": {}}), other_lamp=lamp("hall"))
    with capture_logs() as lines:
        async with virtual_house_of("lights_out", world=world) as house:
            await house.press("hall_lamp", "on")
            await house.press("other_lamp", "on")
            await house.run_for("30m")
            assert not is_on(world, "other_lamp")
    assert warnings(lines) == ["hall_lamp → off, by lights_out: no answer within 10 s"]


async def test_a_person_of_habits_sits_in_the_light_in_a_room_where_nothing_tells_of_them() -> None:
    """A day in which they switch their lamps by hand: in the hall a sensor sees them, in the kitchen none."""
    world = hall(
        ("07:00", "kitchen"),
        ("07:40", "outside"),
        ("17:00", "hall"),
        ("17:05", "kitchen"),
        ("17:30", "outside"),
        by_hand=True,
        kitchen_lamp=lamp("kitchen"),
    )
    async with virtual_house_of("lights_out", world=world) as house:
        await house.run_for("1d")
    assert " told off" not in world.event_log.text()
