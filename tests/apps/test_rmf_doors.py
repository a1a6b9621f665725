"""Open-RMF's doors: states, and holds by requester."""

from __future__ import annotations

from typing import Any

import pytest

from homebot.graph import Node
from homebot.house.description import parse_world
from homebot.messages.builtin_interfaces import Time
from homebot.messages.interfaces import find_message
from homebot.testing import virtual_house_of

pytestmark = pytest.mark.virtual_time

APP = "homebot.apps.rmf_doors:RmfDoors"
HOUSE = {
    "house": {"dialect": "homeassistant"},
    "rooms": {"hall": {"doors": ["kitchen"]}, "kitchen": {}},
    "devices": {"inner_door": {"kind": "lock", "room": "hall", "door": "kitchen"}},
}
PLACES = {
    "rooms": {"hall": {}, "kitchen": {}},
    "doors": {"Inner": {"rooms": ["hall", "kitchen"], "lock": "inner_door"}},
}
REQUEST: Any = find_message("rmf_door_msgs/msg/DoorRequest")
MODE: Any = find_message("rmf_door_msgs/msg/DoorMode")
STATE: Any = find_message("rmf_door_msgs/msg/DoorState")
CLOSED, OPEN = 0, 2


async def test_a_door_stays_open_until_the_last_requester_closes_it_or_falls_silent() -> None:
    async with (
        virtual_house_of(
            "homebot.apps.rmf_doors:RmfDoors", world=parse_world(HOUSE, "test"), config={"places": PLACES}
        ) as house,
        Node(house.runtime.graph, "fleet") as fleet,
    ):
        states: list[Any] = []
        fleet.create_subscription(STATE, "/door_states", states.append)
        requests = fleet.create_publisher(REQUEST, "/adapter_door_requests")

        def mode() -> int:
            assert states[-1].door_name == "Inner"
            value: int = states[-1].current_mode.value
            return value

        async def ask(requester: str, value: int) -> None:
            time = Time(sec=0, nanosec=0)
            wanted = MODE(value=value)
            requests.publish(
                REQUEST(request_time=time, requester_id=requester, door_name="Inner", requested_mode=wanted)
            )
            await house.run_for(10)

        await house.run_for(10)
        assert mode() == CLOSED
        await ask("rosie", OPEN)
        await ask("anna", OPEN)
        assert mode() == OPEN
        await ask("rosie", CLOSED)
        await ask("stranger", CLOSED)
        assert mode() == OPEN
        await ask("anna", CLOSED)
        assert mode() == CLOSED
        await ask("rosie", OPEN)
        assert mode() == OPEN
        await house.run_for(130)
        assert mode() == CLOSED
