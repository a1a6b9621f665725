"""A robot drives through doors."""

from __future__ import annotations

import math

import pytest

from homebot.house.robot import Robot
from homebot.house.rooms import Room, Rooms
from homebot.places.rigid import MapPose

PLAN = Rooms(
    {"hall": Room(), "living": Room(x=4.0), "kitchen": Room(x=4.0, y=2.0), "loft": Room()},
    [("hall", "living"), ("living", "kitchen")],
)


def test_a_robot_says_each_room_on_its_way() -> None:
    """Its pose is between them at its speed."""
    robot = Robot("robot", PLAN, "hall", speed=0.5)
    assert robot.handle_command("go kitchen", 0.0) == ("moving",)
    assert robot.advance(4.0) == ()
    assert robot.pose() == MapPose(2.0, 0.0, 0.0)
    assert robot.advance(8.0) == ("living",)
    assert robot.advance(12.0) == ("kitchen",)
    assert robot.pose() == MapPose(4.0, 2.0, math.pi / 2)
    assert (robot.state(), robot.next_event()) == ("kitchen", None)


def test_a_stopped_robot_stays_and_drives_on_from_there() -> None:
    """First back to the middle of the room it left."""
    robot = Robot("robot", PLAN, "hall", speed=0.5)
    robot.handle_command("go living", 0.0)
    assert robot.handle_command("stop", 4.0) == ("hall",)
    assert robot.advance(100.0) == ()
    assert robot.pose() == MapPose(2.0, 0.0, 0.0)
    robot.handle_command("go hall", 100.0)
    assert robot.advance(104.0) == ("hall",)
    assert (robot.pose().x, robot.pose().y) == (0.0, 0.0)


def test_a_robot_that_is_there_says_so() -> None:
    """It does not move."""
    assert Robot("robot", PLAN, "hall").handle_command("go hall", 0.0) == ("hall",)


@pytest.mark.parametrize("command", ["go loft", "go moon", "dance"])
def test_a_robot_ignores_unknown_commands(command: str) -> None:
    """No way, no room, no such command."""
    assert Robot("robot", PLAN, "hall").handle_command(command, 0.0) == ()
