"""The example of a robot's way, whose robots are gone before they arrive."""

from importlib import import_module
from pathlib import Path

import pytest

from homebot.devices.names import FORGET_DEVICE
from homebot.devices.services import ForgetDevice, ForgetDeviceRequest
from homebot.graph import Node
from homebot.house import World, family_world
from homebot.house.robot import Robot
from homebot.testing import virtual_house_of

pytestmark = [pytest.mark.slow, pytest.mark.virtual_time, pytest.mark.rooms("homeassistant")]

ROBOTS = ("robot", "rosie")


@pytest.fixture
def slow_world(monkeypatch: pytest.MonkeyPatch) -> World:
    """The family's house, whose robots do not arrive, for the example, which is read before the loop runs."""
    monkeypatch.syspath_prepend(Path(__file__).parents[2] / "examples/13_robot_way")
    import_module("robot_way")
    world = family_world()
    for name in ROBOTS:
        robot = world.device(name)
        assert isinstance(robot, Robot)
        robot.speed = 1e-6
    return world


async def test_a_robot_that_is_gone_lets_go_at_once_and_drives_anew_when_it_returns(slow_world: World) -> None:
    async with (
        virtual_house_of("robot_way:RobotWay", world=slow_world) as house,
        Node(house.runtime.graph, "owner") as owner,
    ):
        await house.run_for("90s")
        forget = owner.create_client(ForgetDevice, FORGET_DEVICE)
        for name in ROBOTS:
            assert (await forget.call(ForgetDeviceRequest(device=f"robots/{name}"))).success
        await house.run_for(5)
        told = [f"{event.who} {event.what}" for event in slow_world.event_log.since(0) if event.verb == "told"]
        assert max(told.count(f"{name} go kitchen") for name in ROBOTS) == 2
