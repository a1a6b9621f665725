import pytest

from homebot import Devices, Light
from homebot.house import family_world


def slow_world():
    world = family_world()
    for robot in ("rosie", "robot"):
        world.device(robot).speed = 1e-6  # type: ignore[attr-defined]
    return world


@pytest.mark.house("robot_way:RobotWay", world=family_world)
async def test_the_lamps_are_on_and_the_door_open_before_a_robot_drives_in_and_the_second_waits(house):
    await house.run_for("2m")
    happened = [f"{event.who} {event.verb} {event.what}" for event in house.world.event_log.since(0)]
    first, second = sorted(("rosie", "robot"), key=lambda robot: happened.index(f"{robot} told go kitchen"))
    steps = [
        "kitchen_door says open",
        "kitchen_lamp says on",
        f"{first} told go kitchen",
        f"{first} says kitchen",
        f"{second} told go kitchen",
        f"{second} says kitchen",
    ]
    places = [happened.index(step) for step in steps]
    assert places == sorted(places)
    assert places[2] > happened.index("worktop_lamp says on")


@pytest.mark.house("robot_way:RobotWay", world=slow_world)
async def test_no_lamp_goes_out_before_a_robot_that_drives_in_and_one_that_dies_lets_go(house):
    await house.run_for("1m")
    lamps = await Devices(house.runtime.app_host.running["robot_way"].node).find(Light, area="kitchen")
    assert [(await lamp.turn_off()).kind for lamp in lamps] == ["refused"] * len(lamps)
    await house.run_for("12m")  # both have had their time
    assert all([(await lamp.turn_off()).succeeded for lamp in lamps])


LIGHTS_OUT = {"apps": {"lights_out": {"quiet_after": 1}}}


@pytest.mark.house("robot_way:RobotWay", world=slow_world, config=LIGHTS_OUT)
async def test_lights_out_leaves_the_lamps_on_for_a_robot_that_drives_in_and_not_after_it_died(house):
    await house.run_for("9m")
    assert house.world.device("kitchen_lamp").state() != "off"
