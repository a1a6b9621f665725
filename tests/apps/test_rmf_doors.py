"""Open-RMF's doors: states, and holds by requester."""

import json
from typing import Any

import anyio
import pytest
from structlog.testing import capture_logs
from tests.robots.test_tracker import stamped

from homebot.graph import Node
from homebot.house.description import parse_world
from homebot.messages.builtin_interfaces import Time
from homebot.messages.geometry_msgs import PoseStamped
from homebot.messages.interfaces import find_message
from homebot.testing import VirtualHouse, virtual_house_of

pytestmark = [pytest.mark.virtual_time, pytest.mark.rooms("homeassistant")]

APP = "homebot.apps.rmf_doors:RmfDoors"
HOUSE = {
    "house": {"dialect": "homeassistant"},
    "rooms": {"hall": {"doors": ["kitchen"]}, "kitchen": {}},
    "devices": {"inner_door": {"kind": "lock", "room": "hall", "door": "kitchen"}},
}
PLACES = {
    "rooms": {"hall": {}, "kitchen": {}},
    "doors": [{"name": "Inner", "rooms": ["hall", "kitchen"], "lock": "inner_door"}],
}
REQUEST: Any = find_message("rmf_door_msgs/msg/DoorRequest")
MODE: Any = find_message("rmf_door_msgs/msg/DoorMode")
BEAT: Any = find_message("rmf_door_msgs/msg/SupervisorHeartbeat")
STATE: Any = find_message("rmf_door_msgs/msg/DoorState")
CLOSED, MOVING, OPEN, OFFLINE = range(4)
GARAGE = {
    "device_class": "garage",
    "name": "Garage",
    "unique_id": "garage",
    "state_topic": "garage/state",
    "command_topic": "garage/set",
    "availability_topic": "garage/online",
}


async def ask(requests: Any, requester: str, door: str, value: int, seconds: float = 1.0) -> None:
    """Publish the request of a robot, and let it act."""
    time, wanted = Time(sec=0, nanosec=0), MODE(value=value)
    requests.publish(REQUEST(request_time=time, requester_id=requester, door_name=door, requested_mode=wanted))
    await anyio.sleep(seconds)


@pytest.mark.parametrize("settings", [{}, {"supervised": True}])
async def test_a_door_closes_when_the_connection_of_its_last_requester_ends(settings: dict[str, Any]) -> None:
    config = {"places": PLACES, "apps": {"rmf_doors": settings}}
    topic = "/door_requests" if settings else "/adapter_door_requests"
    async with (
        virtual_house_of(world=parse_world(HOUSE, "test"), config=config) as house,
        Node(house.runtime.graph, "fleet") as fleet,
    ):
        modes: list[int] = []
        fleet.create_subscription(STATE, "/door_states", lambda state: modes.append(state.current_mode.value))
        await house.run_for(10)
        robots = {name: fleet.create_publisher(REQUEST, topic) for name in ("rosie", "anna")}
        for name, requests in robots.items():
            await ask(requests, name, "Inner", OPEN, 5.0)
        robots["rosie"].close()
        await house.run_for(30)
        assert modes[-1] == OPEN
        robots["anna"].close()
        with capture_logs() as lines:
            await house.run_for(10)
        assert "the hold of anna on Inner ends: its connection has ended" in [line.get("message") for line in lines]
        assert modes[-1] == CLOSED


async def test_a_door_closes_when_its_robot_is_gone_behind_a_fleet_adapter_that_lives_and_not_while_it_stands() -> None:
    config = {"places": PLACES, "apps": {"rmf_doors": {}}, "robots": {"rosie": {}}}
    async with (
        virtual_house_of(world=parse_world(HOUSE, "test"), config=config) as house,
        Node(house.runtime.graph, "fleet") as fleet,
        Node(house.runtime.graph, "rosie") as rosie,
    ):
        modes: list[int] = []
        fleet.create_subscription(STATE, "/door_states", lambda state: modes.append(state.current_mode.value))
        poses = rosie.create_publisher(PoseStamped, "/rosie/pose")
        await house.run_for(10)
        poses.publish(stamped(1, 1))
        requests = fleet.create_publisher(REQUEST, "/adapter_door_requests")
        for robot in ("rosie", "anna"):  # the house knows one of them
            await ask(requests, f"villa/{robot}", "Inner", OPEN, 5.0)
        await house.run_for(600)
        assert modes[-1] == OPEN
        await ask(requests, "villa/anna", "Inner", CLOSED)
        await house.run_for(10)
        assert modes[-1] == OPEN
        poses.close()
        await house.run_for(10)
        assert modes[-1] == CLOSED


async def test_a_request_with_another_mode_is_refused_in_words() -> None:
    config = {"places": PLACES, "apps": {"rmf_doors": {}}}
    async with (
        virtual_house_of(world=parse_world(HOUSE, "test"), config=config) as house,
        Node(house.runtime.graph, "fleet") as fleet,
    ):
        await house.run_for(10)
        requests = fleet.create_publisher(REQUEST, "/adapter_door_requests")
        with capture_logs() as lines:
            await ask(requests, "rosie", "Inner", 7)
        assert [line["message"] for line in lines] == [
            "a request of rosie for Inner was refused: its mode is 7, not 0 (closed) or 2 (open)"
        ]


async def announce(house: VirtualHouse, kind: str, config: dict[str, str]) -> None:
    name = config["unique_id"]
    await house.says(f"homeassistant/{kind}/{name}/config", json.dumps(config))
    await house.says(f"{name}/online", "online")


async def test_motors_and_sensors_of_doors_are_doors_and_windows_are_not() -> None:
    async with virtual_house_of(APP) as house, Node(house.runtime.graph, "fleet") as fleet:
        states: dict[str, int] = {}
        fleet.create_subscription(
            STATE, "/door_states", lambda state: states.update({state.door_name: state.current_mode.value})
        )
        requests = fleet.create_publisher(REQUEST, "/adapter_door_requests")
        await announce(house, "cover", GARAGE)
        for kind in ("door", "window"):
            own = {"device_class": kind, "name": f"My {kind}", "unique_id": kind, "state_topic": f"{kind}/state"}
            await announce(house, "binary_sensor", own | {"availability_topic": f"{kind}/online"})
            await house.says(f"{kind}/state", "ON")
        await house.says("garage/state", "closed")
        await house.run_for(10)
        assert states == {"Garage": CLOSED, "My door": OPEN}
        await ask(requests, "rosie", "garage", OPEN)
        assert await house.hears("garage/set") == "OPEN"
        await house.says("garage/state", "opening")
        await house.run_for(2)
        assert states["Garage"] == MOVING
        await house.says("garage/state", "open")
        await house.run_for(2)
        assert states["Garage"] == OPEN
        await ask(requests, "rosie", "My door", OPEN)
        await ask(requests, " ", "Garage", OPEN)
        await ask(requests, "rosie", "Garage", CLOSED)
        assert await house.hears("garage/set") == "CLOSE"
        await house.says("garage/online", "offline")
        await house.run_for(2)
        assert states["Garage"] == OFFLINE


@pytest.mark.parametrize("settings", [{}, {"held_for": 120.0, "supervised": True}])
async def test_a_door_stays_open_until_the_last_requester_closes_it_or_its_time_ends(settings: dict[str, Any]) -> None:
    config = {"places": PLACES, "apps": {"rmf_doors": settings}}
    is_supervised = bool(settings)
    async with (
        virtual_house_of(world=parse_world(HOUSE, "test"), config=config) as house,
        Node(house.runtime.graph, "fleet") as fleet,
    ):
        states: list[Any] = []
        fleet.create_subscription(STATE, "/door_states", states.append)
        beats: list[Any] = []
        fleet.create_subscription(BEAT, "/door_supervisor_heartbeat", beats.append)
        requests = fleet.create_publisher(REQUEST, "/door_requests" if is_supervised else "/adapter_door_requests")

        def holders() -> list[tuple[str, str]]:
            return [(door.door_name, one.requester_id) for door in beats[-1].all_sessions for one in door.sessions]

        def mode() -> int:
            assert states[-1].door_name == "Inner"
            value: int = states[-1].current_mode.value
            return value

        await house.run_for(10)
        assert mode() == CLOSED
        await ask(requests, "rosie", "Inner", OPEN, 10.0)
        await ask(requests, "anna", "Inner", OPEN, 10.0)
        assert is_supervised or holders() == [("Inner", "anna"), ("Inner", "rosie")]
        with capture_logs() as lines:
            await ask(requests, "anna", "Iner", OPEN)
        assert "'Iner' is not a door with a lock or motor; did you mean Inner?" in lines[0]["message"]
        assert mode() == OPEN
        await ask(requests, "rosie", "Inner", CLOSED, 10.0)
        await ask(requests, "stranger", "Inner", CLOSED, 10.0)
        assert mode() == OPEN
        await ask(requests, "anna", "Inner", CLOSED, 10.0)
        assert mode() == CLOSED
        await ask(requests, "rosie", "Inner", OPEN, 10.0)
        assert mode() == OPEN
        await house.run_for(1000)
        assert mode() == (CLOSED if is_supervised else OPEN)
        await ask(requests, "rosie", "Inner", CLOSED, 10.0)
        assert mode() == CLOSED
        assert not beats if is_supervised else holders() == []
