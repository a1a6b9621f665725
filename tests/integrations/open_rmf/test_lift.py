"""A lift for Open-RMF: its state, and sessions of robots in order; in virtual time."""

import json
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from typing import Any

import anyio
import pytest
from structlog.testing import capture_logs

from homebot.devices import Devices
from homebot.devices.handles.handle import Handle
from homebot.errors import ConfigError
from homebot.graph import Node
from homebot.messages.builtin_interfaces import Time
from homebot.messages.interfaces import find_message
from homebot.testing import VirtualHouse, virtual_house_of

pytestmark = [pytest.mark.virtual_time, pytest.mark.rooms("homeassistant")]

REQUEST: Any = find_message("rmf_lift_msgs/msg/LiftRequest")
STATE: Any = find_message("rmf_lift_msgs/msg/LiftState")
END, AGV, HUMAN = range(3)
CLOSED, MOVING, OPEN = range(3)
STOPPED, UP, DOWN, UNKNOWN = range(4)
BY_PERSONS, BY_ROBOT, OFFLINE = 1, 2, 4
FLOORS = ["Ground", "First", "Attic"]
TRAVEL_S = 10.0


class Lift:
    """A lift at the broker, a choice of floors and a door, each of which takes its time; and the robots that ask."""

    def __init__(self, house: VirtualHouse, fleet: Node, requests: str) -> None:
        self.house = house
        self.states: list[Any] = []
        self.moves: list[str] = []
        self.is_stuck = False
        self._requests = fleet.create_publisher(REQUEST, requests)
        fleet.create_subscription(STATE, "/lift_states", self.states.append)

    async def announce(self) -> None:
        about = {"identifiers": ["lift"], "name": "Lift"}
        for kind, own in (("select", {"options": FLOORS}), ("cover", {"device_class": "door"})):
            name = {"select": "floor", "cover": "door"}[kind]
            topics = {"state_topic": f"lift/{name}", "command_topic": f"lift/{name}/set"}
            config = {"name": name.title(), "unique_id": f"lift_{name}", "device": about, **topics, **own}
            await self.house.says(f"homeassistant/{kind}/lift_{name}/config", json.dumps(config))
        await self.house.says("lift/floor", "Ground")
        await self.house.says("lift/door", "closed")

    async def move(self) -> None:
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._obey, "floor", TRAVEL_S)
            tasks.start_soon(self._obey, "door", 2.0)

    async def _obey(self, name: str, seconds: float) -> None:
        while True:
            wanted = await self.house.hears(f"lift/{name}/set", within="1d")
            said = {"OPEN": "open", "CLOSE": "closed"}.get(wanted, wanted)
            self.moves.append(said)
            if name == "door":
                await self.house.says("lift/door", "opening" if said == "open" else "closing")
            await anyio.sleep(seconds)
            if not self.is_stuck:
                await self.house.says(f"lift/{name}", said)

    async def ask(self, robot: str, floor: str = "", kind: int = AGV, door: int = OPEN, lift: str = "Main") -> None:
        time = Time(sec=0, nanosec=0)
        fields = {"session_id": robot, "request_type": kind, "destination_floor": floor, "door_state": door}
        self._requests.publish(REQUEST(lift_name=lift, request_time=time, **fields))
        await anyio.sleep(1)

    def leave(self) -> None:
        """End the connection of the robots."""
        self._requests.close()

    def now(self) -> tuple[str, str, int, int, str]:
        """Return where the lift is, where it goes, its door, its motion, and who has it."""
        state = self.states[-1]
        return (
            state.current_floor,
            state.destination_floor,
            state.door_state,
            state.motion_state,
            state.session_id,
        )


@asynccontextmanager
async def lift_of(**table: Any) -> AsyncIterator[Lift]:
    lifts = {"rmf_lift": {"name": "Main", "floor": "Lift", **table}}
    requests = "/lift_requests" if table.get("supervised") else "/adapter_lift_requests"
    async with (
        virtual_house_of(config={"apps": lifts}) as house,
        Node(house.runtime.graph, "fleet") as fleet,
        anyio.create_task_group() as tasks,
    ):
        lift = Lift(house, fleet, requests)
        await lift.announce()
        tasks.start_soon(lift.move)
        await house.run_for(15)
        yield lift
        tasks.cancel_scope.cancel()


@pytest.mark.parametrize("table", [{}, {"supervised": True}])
async def test_robots_have_the_lift_one_after_the_other_and_the_door_is_open_where_it_stands(table: Any) -> None:
    async with lift_of(**table) as lift:
        assert lift.now() == ("Ground", "Ground", CLOSED, STOPPED, "")
        state = lift.states[-1]
        assert (state.lift_name, list(state.available_floors), state.current_mode) == ("Main", FLOORS, BY_PERSONS)
        await lift.ask("rosie", "Ground")
        await lift.ask("anna", "Attic")
        await lift.house.run_for(5)
        assert lift.now() == ("Ground", "Ground", OPEN, STOPPED, "rosie")
        assert lift.states[-1].current_mode == BY_ROBOT
        await lift.ask("rosie", "first")
        await lift.house.run_for(6)
        assert lift.now() == ("Ground", "First", CLOSED, UP, "rosie")
        await lift.house.run_for(12)
        assert lift.now() == ("First", "First", OPEN, STOPPED, "rosie")
        assert lift.moves == ["open", "closed", "First", "open"]
        await lift.ask("rosie", kind=END)
        await lift.house.run_for(6)
        assert lift.now() == ("First", "Attic", CLOSED, UP, "anna")
        await lift.house.run_for(12)
        assert lift.now() == ("Attic", "Attic", OPEN, STOPPED, "anna")
        await lift.ask("anna", kind=END)
        await lift.house.run_for(6)
        assert lift.now() == ("Attic", "Attic", CLOSED, STOPPED, "")


async def test_a_robot_that_is_not_heard_any_more_loses_the_lift_and_the_next_one_gets_it() -> None:
    async with lift_of(held_for=60) as lift:
        began = anyio.current_time()
        await lift.ask("rosie", "First")
        await lift.house.run_for(20)
        assert lift.now() == ("First", "First", OPEN, STOPPED, "rosie")
        for _ in range(6):
            assert lift.now()[-1] == ("rosie" if anyio.current_time() < began + 60 else "anna")
            await lift.ask("anna", "Ground")
            await lift.house.run_for(9)
        assert lift.now() == ("Ground", "Ground", OPEN, STOPPED, "anna")
        await lift.house.run_for(70)
        assert lift.now() == ("Ground", "Ground", CLOSED, STOPPED, "")


async def test_a_robot_whose_connection_ends_loses_the_lift_and_the_next_one_gets_it() -> None:
    async with lift_of() as lift, Node(lift.house.runtime.graph, "other_fleet") as other:
        await lift.ask("anna", "First")
        await Lift(lift.house, other, "/adapter_lift_requests").ask("rosie", "Attic")
        await lift.house.run_for(20)
        assert lift.now() == ("First", "First", OPEN, STOPPED, "anna")
        lift.leave()
        await lift.house.run_for(20)
        assert lift.now() == ("Attic", "Attic", OPEN, STOPPED, "rosie")


async def test_others_cannot_send_the_lift_away_while_a_robot_has_it() -> None:
    async with lift_of() as lift:
        await lift.ask("rosie", "First")
        await lift.house.run_for(20)
        devices = Devices(lift.house.runtime.app_host.running["rmf_lift"].node)
        (floor,) = await devices.find(Handle, name="Floor")
        outcome = await floor.command("option", "Ground")
        assert "rosie" in outcome.text
        assert lift.now() == ("First", "First", OPEN, STOPPED, "rosie")


async def test_a_display_says_where_the_lift_is_if_its_choice_is_only_where_it_was_sent() -> None:
    async with lift_of(at="Display") as lift:
        display = {"name": "Display", "unique_id": "display", "state_topic": "lift/at"}
        await lift.house.says("homeassistant/sensor/display/config", json.dumps(display))
        await lift.house.run_for(5)
        await lift.house.says("lift/at", "Ground")
        await lift.ask("rosie", "First")
        await lift.house.run_for(20)
        assert lift.moves == ["First"]
        assert lift.now() == ("Ground", "First", CLOSED, UP, "rosie")
        await lift.house.says("lift/at", "First")
        await lift.house.run_for(5)
        assert lift.now() == ("First", "First", OPEN, STOPPED, "rosie")


async def test_in_human_mode_the_door_does_what_is_asked() -> None:
    async with lift_of() as lift:
        await lift.ask("rosie", "Ground", HUMAN, CLOSED)
        await lift.house.run_for(5)
        assert lift.now() == ("Ground", "Ground", CLOSED, STOPPED, "rosie")
        await lift.ask("rosie", "Ground", HUMAN, OPEN)
        await lift.house.run_for(5)
        assert lift.now() == ("Ground", "Ground", OPEN, STOPPED, "rosie")
        await lift.ask("rosie", "Ground", HUMAN, CLOSED)
        await lift.house.run_for(5)
        assert lift.now() == ("Ground", "Ground", CLOSED, STOPPED, "rosie")


async def test_a_lift_that_stays_away_is_sent_again_and_goes_nowhere_with_an_open_door() -> None:
    async with lift_of() as lift:
        await lift.house.says("lift/door", "open")
        lift.is_stuck = True
        await lift.ask("rosie", "First")
        await lift.house.run_for(20)
        assert (set(lift.moves), lift.now()[3]) == ({"closed"}, UP)
        lift.is_stuck = False
        await lift.house.says("lift/door", "closed")
        await lift.house.run_for(20)
        assert lift.now() == ("First", "First", OPEN, STOPPED, "rosie")
        await lift.house.says("lift/floor", "Attic")  # somebody pressed a button in it
        await lift.house.run_for(30)
        assert lift.now() == ("First", "First", OPEN, STOPPED, "rosie")


@pytest.mark.parametrize(("position", "state"), [("", MOVING), ("100", OPEN), ("40", MOVING)])
async def test_a_lift_goes_nowhere_before_a_door_that_tells_its_position_is_closed(position: str, state: int) -> None:
    async with lift_of(door="Gate") as lift:
        topics = {"position_topic": "gate/position", "set_position_topic": "gate/set"}
        config = {"name": "Gate", "unique_id": "gate", "device_class": "gate", **topics}
        await lift.house.says("homeassistant/cover/gate/config", json.dumps(config))
        await lift.house.run_for(5)
        if position:
            await lift.house.says("gate/position", position)
        await lift.house.run_for(2)
        assert lift.now()[2] == state
        await lift.ask("rosie", "First")
        await lift.house.run_for(30)
        assert lift.moves == []
        await lift.house.says("gate/position", "0")
        await lift.house.run_for(30)
        assert lift.moves == ["First"]


async def test_a_wrong_request_is_refused_with_its_reason() -> None:
    async with lift_of() as lift:
        with capture_logs() as lines:
            await lift.ask("rosie", "Atic")
            await lift.ask(" ", "Attic")
            await lift.ask("rosie", "Attic", kind=7)
            await lift.ask("rosie", "Attic", HUMAN, 7)
            await lift.ask("rosie", "Attic", lift="Other")
            await lift.ask("rosie", kind=END)
        assert [line["message"] for line in lines] == [
            "Main: a request of rosie was refused: 'Atic' is no floor; did you mean Attic?",
            "Main: a request was refused: no session is stated",
            "Main: a request of rosie was refused: its request_type is 7, not 0, 1 or 2",
            "Main: a request of rosie was refused: its door_state is 7, not 0 or 2",
        ]
        assert lift.now()[4] == ""


async def test_a_lift_of_two_ends_has_the_floors_that_are_named() -> None:
    """A stair lift, or one in a garage, is often a motor that opens and closes."""
    config = {"apps": {"rmf_lift": {"name": "Stair lift", "floor": "Stairs", "floors": ["Hall", "Bedroom"]}}}
    async with virtual_house_of(config=config) as house, Node(house.runtime.graph, "fleet") as fleet:
        lift = Lift(house, fleet, "/adapter_lift_requests")
        motor = {"name": "Stairs", "unique_id": "stairs", "state_topic": "stairs", "command_topic": "stairs/set"}
        await house.says("homeassistant/cover/stairs/config", json.dumps(motor))
        await house.run_for(5)
        await house.says("stairs", "closed")
        await house.run_for(5)
        assert lift.now() == ("Hall", "Hall", OPEN, STOPPED, "")
        await lift.ask("rosie", "Bedroom", lift="Stair lift")
        assert await house.hears("stairs/set") == "OPEN"
        await house.says("stairs", "opening")
        await house.run_for(5)
        assert lift.now() == ("Hall", "Bedroom", CLOSED, UP, "rosie")
        await house.says("stairs", "open")
        await house.run_for(5)
        assert lift.now() == ("Bedroom", "Bedroom", OPEN, STOPPED, "rosie")
        await lift.ask("rosie", "Hall", lift="Stair lift")
        assert await house.hears("stairs/set") == "CLOSE"


async def test_a_lift_without_its_devices_is_offline() -> None:
    async with virtual_house_of(config={"apps": {"rmf_lift": {"floor": "Lift"}}}) as house:
        states: list[Any] = []
        async with Node(house.runtime.graph, "fleet") as fleet:
            fleet.create_subscription(STATE, "/lift_states", states.append)
            await house.run_for(5)
        assert (states[-1].current_mode, states[-1].motion_state) == (OFFLINE, UNKNOWN)


@pytest.mark.parametrize(
    ("lifts", "problem"),
    [
        ({"rmf_lift": {}}, "apps.rmf_lift.floor: is missing"),
        ({"rmf_lift": {"floor": "x", "floors": ["a"]}}, "floors are at least two, each once"),
        (
            {"rmf_lift": {"floor": "x", "floors": ["a", "b"], "doors": {"c": "y"}}},
            "doors has 'c', which is none of floors",
        ),
    ],
)
async def test_a_wrong_table_is_refused(lifts: object, problem: str) -> None:
    with pytest.raises(ConfigError, match=problem):
        async with virtual_house_of(config={"apps": lifts}):
            pass


async def describe(house: VirtualHouse) -> None:
    """Announce a lift of three floors with a door without a motor, which says who has it."""
    properties: dict[str, Any] = {
        "floor": {"enum": FLOORS, "forms": [{"op": "writeproperty", "mqv:topic": "car/floor/set"}]},
        "door": {"enum": ["open", "closed", "opening", "closing"], "forms": []},
        "session": {"forms": []},
    }
    for name, one in properties.items():
        forms = [*one["forms"], {"op": "observeproperty", "mqv:topic": f"car/{name}"}]
        one |= {"type": "string", "forms": [{"href": "mqtt://broker", **form} for form in forms]}
    security = {"security": "none", "securityDefinitions": {"none": {"scheme": "nosec"}}}
    context = {"@context": "https://www.w3.org/2022/wot/td/v1.1", "title": "Car", "@type": "Lift"}
    await house.says("homebot/things/car/td", json.dumps({**context, **security, "properties": properties}))
    await house.run_for(5)


@asynccontextmanager
async def described_lift(config: Mapping[str, Any] | None = None) -> AsyncIterator[tuple[VirtualHouse, Handle, Lift]]:
    async with virtual_house_of(config=config or {}) as house, Node(house.runtime.graph, "person") as person:
        lift = Lift(house, person, "/adapter_lift_requests")
        await describe(house)
        (handle,) = await Devices(person).find(Handle, name="Car")
        yield house, handle, lift


@pytest.mark.rooms("things")
@pytest.mark.parametrize("door", ["", "open", "closing"])
async def test_a_lift_is_sent_nowhere_while_its_door_may_be_open(door: str) -> None:
    async with described_lift() as (house, lift, _):
        await house.says("car/floor", '"Ground"')
        if door:
            await house.says("car/door", json.dumps(door))
        await house.run_for(2)
        outcome = await lift.command("floor", "Attic")
        assert outcome.text == "refused (lift): its door may be open"
        assert (await lift.command("floor", "Ground")).succeeded  # it is there
        await house.says("car/door", '"closed"')
        await house.run_for(2)
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(ride, house)
            outcome = await lift.command("floor", "Attic")
        assert outcome.succeeded


async def ride(house: VirtualHouse) -> None:
    assert await house.hears("car/floor/set") == '"Attic"'
    for floor in FLOORS:
        await anyio.sleep(TRAVEL_S)
        await house.says("car/floor", json.dumps(floor))


@pytest.mark.rooms("things")
async def test_a_lift_that_somebody_else_has_is_not_sent_and_a_robot_waits_for_it() -> None:
    async with described_lift({"apps": {"rmf_lift": {"name": "Main", "floor": "Car"}}}) as (house, lift, robots):
        for name, value in {"floor": "Ground", "door": "closed", "session": "anna"}.items():
            await house.says(f"car/{name}", json.dumps(value))
        await house.run_for(5)
        assert (await lift.command("floor", "First")).text == "refused (lift): anna has the lift"
        assert robots.now() == ("Ground", "Ground", CLOSED, STOPPED, "anna")
        assert list(robots.states[-1].available_floors) == FLOORS
        await robots.ask("rosie", "First")
        await house.run_for(90)
        assert robots.now() == ("Ground", "First", CLOSED, UP, "rosie")
        await house.says("car/session", '""')
        assert await house.hears("car/floor/set", within="5s") == '"First"'
        await house.says("car/floor", '"First"')
        await house.says("car/door", '"open"')
        await house.run_for(5)
        assert robots.now() == ("First", "First", OPEN, STOPPED, "rosie")
