"""Types that a client defines itself."""

from __future__ import annotations

from typing import Any

import pytest
from tests.bridges.conftest import House

from homebot.bridges.rosbridge.access import right_to_call
from homebot.devices.client_rights import Right
from homebot.devices.names import DEFINE_TYPE

ARM = 'float64[] joints\nstring<=8 mode "idle"\nlab/Tool tool\n' + "=" * 80 + "\nMSG: lab/Tool\nint8 kind\n"


async def defined(peer: Any, ros_type: str, definition: str) -> dict[str, Any]:
    await peer.send("call_service", service=DEFINE_TYPE, args={"type": ros_type, "definition": definition})
    answer: dict[str, Any] = (await peer.receive())["values"]
    return answer


async def test_a_client_defines_a_type_that_others_use_too(house: House) -> None:
    async with house.peer() as robot, house.peer() as other:
        answer = await defined(robot, "lab/msg/Arm", ARM)
        assert answer["success"]
        assert answer["type_hash"].startswith("RIHS01_")
        await other.tell("subscribe", topic="/arm", type="lab/Arm")
        await robot.send("advertise", topic="/arm", type="lab/msg/Arm")
        await robot.send("publish", topic="/arm", msg={"joints": [1, 2.5], "tool": {"kind": -1}})
        assert (await other.receive())["msg"] == {"joints": [1.0, 2.5], "mode": "idle", "tool": {"kind": -1}}
        again = await defined(other, "lab/msg/Arm", ARM)
        assert again == answer


@pytest.mark.parametrize(
    ("ros_type", "definition", "problem"),
    [
        ("lab/msg/Arm", "int33 x", "lab/msg/Arm: line 1: 'int33' is no type"),
        ("std_msgs/Header", "int8 x", "std_msgs/msg/Header is known with other fields"),
        ("../../etc/Passwd", "int8 x", "is no type; write package/msg/Name"),
        ("lab/msg/Large", "uint8[4000000000] x", "at most 100000"),
    ],
)
async def test_a_wrong_definition_is_answered_with_the_reason(
    house: House, ros_type: str, definition: str, problem: str
) -> None:
    async with house.peer() as robot:
        answer = await defined(robot, ros_type, definition)
        assert not answer["success"]
        assert problem in answer["message"]


def test_to_define_a_type_takes_the_right_to_act() -> None:
    assert right_to_call(DEFINE_TYPE) is Right.ACT
