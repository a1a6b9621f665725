"""What is near a robot: by ways through doors, with each term explained; in virtual time."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Any

import anyio
import anyio.lowlevel
import pytest
from tests.busy_clock import BusyClock
from tests.discovery.announcements import announce, part_of, tell

from homebot.bridges.rosbridge.services import parse_queries
from homebot.clock import Clock, LoopClock
from homebot.devices import FIND_DEVICES, QUERY_DEVICES, Devices, FindDevices, QueryDevices, Sighting
from homebot.devices.command_messages import CommandResult
from homebot.devices.gateway_messages import REACHABLE, Report
from homebot.devices.handles import Light
from homebot.devices.house_view import HouseView
from homebot.devices.journal_messages import JournalEntry, ReadJournal, ReadJournalRequest, ReadJournalResponse
from homebot.devices.names import JOURNAL_ENTRIES, LIST_DEVICES, READ_JOURNAL, ROBOT_POSES, WHERE_IS_ROBOT, GatewayNames
from homebot.devices.query.term_messages import QueryTerm, query_terms
from homebot.devices.robot_messages import RobotPose, WhereIsRobot, WhereIsRobotRequest, WhereIsRobotResponse
from homebot.devices.services import ListDevices, QueryDevicesResponse
from homebot.discovery import Directory, DirectorySettings
from homebot.discovery.owner_facts import OwnerFacts
from homebot.errors import RefusedError, ServiceFailedError
from homebot.graph import DurabilityPolicy, Graph, Node, Publisher, QoSProfile
from homebot.messages import Time
from homebot.places import HouseDoor, HouseRoom, OwnerFact, Places
from homebot.words.queries import parse_query

pytestmark = pytest.mark.virtual_time


HALL = HouseRoom("Hall", polygons=((((0, 0), (4, 0), (4, 5), (0, 5)),),))
KITCHEN = HouseRoom("Kitchen", polygons=((((4, 0), (8, 0), (8, 5), (4, 5)),),))
DOOR = HouseDoor("Hall-Kitchen", ("Hall", "Kitchen"), ((4.0, 4.5),), contact="Kitchen door", lock="Kitchen lock")
POSITIONS = {"kitchen_lamp": "4.5,1 ±0", "hall_lamp": "1,1 ±0"}


class RobotPoses:
    """The one robot of the house, as the tracker of robots tells of it.

    Args:
        node: Its node.
    """

    def __init__(self, node: Node) -> None:
        kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._poses = node.create_publisher(RobotPose, ROBOT_POSES, kept)
        self._clock = node.graph.clock
        self._node = node
        self._last: RobotPose | None = None

    def publish(self, pose: RobotPose) -> None:
        if self._last is None:
            self._node.create_service(WhereIsRobot, WHERE_IS_ROBOT, self._where)
        self._last = pose
        self._poses.publish(pose)

    def _where(self, request: WhereIsRobotRequest) -> WhereIsRobotResponse:
        pose = self._last
        assert pose is not None
        if request.robot not in {"robi", "robot"}:
            message = f"there is no robot {request.robot!r}; did you mean robi?"
            return WhereIsRobotResponse(success=False, message=message, is_mistake=True)
        age = self._clock.now() - pose.received_at.to_seconds()
        problem = "" if pose.counts else f"robi's pose is {age:.0f} s old (limit {pose.limit:g} s)"
        return WhereIsRobotResponse(success=pose.counts, message=problem, pose=(pose,), age=age)


@dataclass
class House:
    """The golden house of two rooms, a robot, and an app."""

    sightings: Publisher[Sighting]
    readings: Publisher[Report]
    poses: RobotPoses
    outcomes: Publisher[JournalEntry]
    app: Node

    async def hears(self, *messages: Sighting | Report) -> None:
        for one in messages:
            self.sightings.publish(one) if isinstance(one, Sighting) else self.readings.publish(one)
        await anyio.sleep(0.001)

    async def robot_at(self, x: float, y: float, *, room: str = "Hall", counts: bool = True) -> None:
        at = Time.from_seconds(self.app.graph.clock.now())
        self.poses.publish(
            RobotPose(
                robot="robi", room=room, has_position=True, x=x, y=y, error=0.1, source="/tf", received_at=at,
                limit=2.0, counts=counts,
            )
        )  # fmt: skip
        await anyio.sleep(0.001)

    async def find(self, text: str, limit: int = 0) -> QueryDevicesResponse:
        client = self.app.create_client(QueryDevices, QUERY_DEVICES)
        return await client.call(QueryDevices.Request(query=query_terms(parse_query(text)), limit=limit))

    async def why(self, text: str) -> dict[str, str]:
        answer = await self.find(text)
        assert answer.success, answer.message
        return {one.device.id: one.reasons[0] for one in answer.results}


@asynccontextmanager
async def golden(
    closed_door: float = 3.0, clock: Clock | None = None, rooms: tuple[HouseRoom, ...] = (HALL, KITCHEN)
) -> AsyncIterator[House]:
    graph, names = Graph(clock or LoopClock(0.0)), GatewayNames("mqtt")
    kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    devices: dict[tuple[str, ...], tuple[OwnerFact, ...]] = {
        (name,): (OwnerFact("position", at, "configuration", 0.0),) for name, at in POSITIONS.items()
    }
    owner = OwnerFacts("Home", Places(rooms, devices, (DOOR,), closed_door))
    async with (
        Node(graph, "mqtt", namespace="/gateway") as gateway,
        Node(graph, "discovery") as node,
        Node(graph, "robots") as robots,
        Node(graph, "control") as control,
        Node(graph, "app") as app,
    ):
        sightings = gateway.create_publisher(Sighting, names.received_topics, kept)
        directory = Directory(node, DirectorySettings(), owner=owner)
        node.create_task(directory.serve)
        await anyio.sleep(0.001)
        house = House(
            sightings,
            gateway.create_publisher(Report, names.readings, kept),
            RobotPoses(robots),
            control.create_publisher(JournalEntry, JOURNAL_ENTRIES, 10),
            app,
        )
        for name, room in (("Kitchen lamp", "Kitchen"), ("Hall lamp", "Hall")):
            lamp = part_of("light", "on_off", id="l", writes=(f"{name}/set",))
            await house.hears(announce(name, lamp, ids=(f"id:{name}",), name=name, area=room, confirmed=True))
        for name, kind, capability in (
            ("Kitchen door", "contact_sensor", "contact"),
            ("Kitchen lock", "door_lock", "lock"),
        ):
            sensor = part_of(kind, capability, id="s")
            await house.hears(announce(name, sensor, ids=(f"id:{name}",), name=name, confirmed=True))
        yield house


def door(value: str, at: float) -> Report:
    named, capability = ("Kitchen lock", "lock") if value.endswith("locked") else ("Kitchen door", "contact")
    return tell(announce(named), capability, value if capability == "lock" else value == "open", part="s", at=at)


async def test_the_lamp_behind_the_wall_is_farther_and_a_door_changes_that_with_one_message() -> None:
    """Golden. Through the air the lamp in the kitchen is 1 m away, and that in the hall 2.5 m."""
    async with golden() as house:
        await house.robot_at(3.5, 1.0)
        assert await house.why("lamps near robi") == {
            "hall_lamp": "2.5 m = 2.5 path",
            "kitchen_lamp": "7.1 m = 7.1 path by Hall-Kitchen (assumed open)",
        }
        now = house.app.graph.clock.now()
        await house.hears(door("closed", now - 4))
        assert await house.why("lamps near robi") == {
            "hall_lamp": "2.5 m = 2.5 path",
            "kitchen_lamp": "10.1 m = 7.1 path by Hall-Kitchen + 3.0 that door is closed (contact, 4 s ago)",
        }
        assert list(await house.why("lamps within 7.5 m of robi")) == [
            "hall_lamp",
            "kitchen_lamp",
        ]  # closed, it is a way
        assert list(await house.why("lamps within 7m of the robi")) == ["hall_lamp"]
        await house.hears(door("locked", now))
        answer = await house.find("lamps near robi")
        assert [one.device.id for one in answer.results] == ["hall_lamp"]
        assert [(one.key, one.value) for one in answer.left_out] == [
            ("kitchen_lamp", "no way leads to Kitchen: Hall-Kitchen is locked")
        ]
        await house.hears(door("unlocked", now), door("open", now))
        assert (await house.why("lamps near robi"))["kitchen_lamp"] == "7.1 m = 7.1 path by Hall-Kitchen"


async def test_a_locked_door_is_named_only_if_it_is_in_the_way() -> None:
    async with golden(rooms=(HALL, KITCHEN, HouseRoom("Shed"))) as house:
        await house.hears(door("locked", house.app.graph.clock.now()))
        await house.robot_at(3.5, 1.0, room="Shed")
        answer = await house.find("lamps near robi")
        assert [one.value for one in answer.left_out] == ["no way leads to Hall", "no way leads to Kitchen"]


async def test_the_metres_of_a_closed_door_are_a_setting() -> None:
    async with golden(closed_door=7.5) as house:
        await house.robot_at(3.5, 1.0)
        await house.hears(door("closed", house.app.graph.clock.now()))
        assert (await house.why("lamps near robi"))["kitchen_lamp"].startswith(
            "14.6 m = 7.1 path by Hall-Kitchen + 7.5"
        )


async def test_on_one_of_several_floors_a_robot_has_to_say_which() -> None:
    async with golden(rooms=(HALL._replace(floor="Ground"), KITCHEN._replace(floor="Top"))) as house:
        await house.robot_at(3.5, 1.0, room="")
        answer = await house.find("lamp near robi")
        assert answer.message == "the house has several floors; state its floor in [robots.robi]"


async def test_a_list_for_agents_has_the_nearest_first_and_says_why_there_is_none() -> None:
    """By id the hall lamp stood first, and was all that an agent with the limit 1 saw."""
    async with golden() as house:
        await house.robot_at(4.5, 1.5, room="Kitchen")
        client = house.app.create_client(ListDevices, LIST_DEVICES)
        request = ListDevices.Request(query=query_terms(parse_query("lamp near robi")), limit=1)
        answer = await client.call(request)
        assert ([one.id for one in answer.devices], answer.total) == (["kitchen_lamp"], 2)
        await house.robot_at(4.5, 1.5, counts=False)
        assert (await client.call(request)).message == "robi's pose is 0 s old (limit 2 s)"


@pytest.mark.parametrize("words", ["lamp near robi", "lamp"])
async def test_a_query_in_words_is_the_one_that_they_say(words: str) -> None:
    """ROS 2 nodes have no other way to send text."""
    async with golden() as house:
        await house.robot_at(4.5, 1.5, room="Kitchen")
        request = FindDevices.Request(query=(QueryTerm(kind="words", text=words),))
        same = FindDevices.Request(query=query_terms(parse_query(words)))
        client = house.app.create_client(FindDevices, FIND_DEVICES)
        assert await client.call(request) == await client.call(same)
        wrong = QueryDevices.Request(query=(QueryTerm(kind="words", text="(lamp"),))
        answer = await house.app.create_client(QueryDevices, QUERY_DEVICES).call(wrong)
        assert answer.is_mistake


async def test_from_the_kitchen_the_other_lamp_is_the_nearest_and_the_answer_says_how_old_the_pose_is() -> None:
    async with golden() as house:
        await house.robot_at(3.5, 1.0)
        await house.find("lamp near robot")
        await house.robot_at(4.5, 1.5, room="Kitchen")
        await anyio.sleep(1.2)

        answer = await house.find("lamp near robot", limit=1)

        assert [one.device.id for one in answer.results] == ["kitchen_lamp"]
        assert answer.total == 2
        assert answer.pose_age == pytest.approx(1.2, abs=0.01)
        assert answer.message == "robi was in Kitchen at 4.5, 1.5 ±0.1 m 1 s ago (/tf)"


async def test_an_expired_pose_is_said_and_an_unknown_robot_is_a_mistake() -> None:
    async with golden() as house:
        before = await house.find("lamp near robi")
        assert (before.success, before.is_mistake) == (False, False)
        assert before.message.startswith("no robot has said where it is")
        await house.robot_at(3.5, 1.0)
        await anyio.sleep(14)
        at = Time.from_seconds(house.app.graph.clock.now() - 14)
        house.poses.publish(RobotPose(robot="robi", room="Hall", received_at=at, limit=2.0, counts=False))

        devices = Devices(house.app)
        with pytest.raises(RefusedError, match=r"robi's pose is 14 s old \(limit 2 s\)"):
            await devices.find(Light, near="robi")
        assert await devices.find(Light, near="robbi") == ()
        with anyio.move_on_after(1):
            await anext(devices.follow(Light, near="robbi"))
        for call, problem in zip(("find", "follow"), await HouseView.of(house.app).names.mistakes(), strict=True):
            assert problem == f"{call}(Light, near='robbi'): there is no robot 'robbi'; did you mean robi?"


async def test_a_room_that_the_house_does_not_have_is_said_instead_of_what_is_near_it() -> None:
    async with golden() as house:
        at = Time.from_seconds(house.app.graph.clock.now())
        house.poses.publish(RobotPose(robot="robi", room="Cellar", received_at=at, limit=600.0, counts=True))
        answer = await house.find("lamp near robi")
        assert not answer.success
        assert answer.message.endswith(
            "no device is in 'cellar', and [places] has no such room; rooms are Hall, Kitchen"
        )


async def test_apps_find_the_nearest_first_and_by_values() -> None:
    async with golden() as house:
        await house.robot_at(3.5, 1.0)
        for name in ("Kitchen lamp", "Hall lamp"):
            await house.hears(tell(announce(name), "on_off", False, part="l"))
        devices = Devices(house.app)

        async def found(**filters: Any) -> list[str]:
            return [one.device.id for one in await devices.find(Light, **filters)]

        assert await found(near="robi", on=False) == ["hall_lamp", "kitchen_lamp"]
        assert await found(near="robi", within=5, on=False) == ["hall_lamp"]
        assert await found(near="robi", area="Kitchen") == ["kitchen_lamp"]
        assert await found(near="robi", on=True) == []
        answer = await house.app.create_client(FindDevices, FIND_DEVICES).call(
            FindDevices.Request(query=query_terms(parse_query("lamp within 5 m of robi")))
        )
        assert [one.id for one in answer.devices] == ["hall_lamp"]


async def test_a_live_query_yields_only_what_came_near_and_what_left() -> None:
    """Moves of less than 0.1 m ask nothing; a door asks at once, a move at most twice a second."""
    async with golden() as house:
        await house.robot_at(3.5, 1.0)
        changes: list[tuple[float, str, str]] = []
        clock = house.app.graph.clock

        async def follow() -> None:
            query = Devices(house.app).follow(Light, near="robi", within=8.0)
            while True:
                one = await anext(query)
                changes.append((clock.monotonic(), one.kind, one.handle.device.id))

        async with anyio.create_task_group() as tasks:
            tasks.start_soon(follow)
            await anyio.sleep(1)
            assert sorted(one[1:] for one in changes) == [("appeared", "hall_lamp"), ("appeared", "kitchen_lamp")]
            changes.clear()
            begin = clock.monotonic()
            await house.hears(door("locked", clock.now()))
            await anyio.sleep(0.1)
            assert [one[1:] for one in changes] == [("removed", "kitchen_lamp")]
            assert changes[0][0] - begin < 0.05
            changes.clear()
            for step in range(100):
                await house.robot_at(3.5 + step * 0.0005, 1.0)
                await anyio.sleep(0.01)
            assert changes == []
            await house.robot_at(4.5, 1.0, room="Kitchen")
            await anyio.sleep(0.6)
            assert [one[1:] for one in sorted(changes, key=lambda one: one[2])] == [
                ("removed", "hall_lamp"),
                ("appeared", "kitchen_lamp"),
            ]
            tasks.cancel_scope.cancel()


async def test_the_first_question_lets_others_have_their_turn() -> None:
    """It spots all devices."""
    async with golden(clock=BusyClock()) as house:
        lamp = part_of("light", "on_off", id="l", writes=("x/set",))
        for number in range(50):
            await house.hears(announce(f"lamp {number}", lamp, ids=(f"id:{number}",), area="Hall", confirmed=True))
        await house.robot_at(3.5, 1.0)
        turns = 0

        async def count_turns() -> None:
            nonlocal turns
            while True:
                turns += 1
                await anyio.lowlevel.checkpoint()

        counts = []
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(count_turns)
            for _ in range(2):
                begin = turns
                assert (await house.find("lamp near robi")).total == 52
                counts.append(turns - begin)
            tasks.cancel_scope.cancel()
        assert counts[0] >= counts[1] + 15


async def test_what_is_stale_or_offline_or_only_has_a_lamp_is_farther_and_the_answer_says_so() -> None:
    async with golden() as house:
        await house.robot_at(3.5, 1.0)
        await house.hears(tell(announce("Hall lamp"), REACHABLE, False))
        assert await house.why("lamp near robi") == {
            "hall_lamp": "4.5 m = 2.5 path + 2.0 it is offline",
            "kitchen_lamp": "7.1 m = 7.1 path by Hall-Kitchen (assumed open)",
        }
        await anyio.sleep(4000)
        await house.robot_at(3.5, 1.0)
        assert (await house.why("lamp near robi"))["hall_lamp"] == (
            "9.5 m = 2.5 path + 5.0 it is stale: it has been silent for too long + 2.0 it is offline"
        )


async def test_a_device_that_fits_in_part_is_farther() -> None:
    async with golden() as house:
        await house.robot_at(3.5, 1.0)
        plug = part_of("plug", "on_off", id="p", writes=("Fan/set",))
        light = part_of("light", "on_off", id="l", writes=("Fan/light/set",))
        await house.hears(announce("Fan", plug, light, ids=("id:Fan",), name="Fan", area="Hall", confirmed=True))
        assert await house.why("plug near robi") == {
            "fan": "about 5.8 m = 2.1 path + 3.2 only its room is known + 0.5 it was announced as plug"
        }


async def test_what_waits_for_approval_is_left_out_and_named() -> None:
    async with golden() as house:
        lock = part_of("door_lock", "lock", id="k", writes=("Safe/set",))
        await house.hears(announce("Safe", lock, ids=("id:Safe",), name="Safe", area="Hall", confirmed=True))
        await house.robot_at(3.5, 1.0)

        answer = await house.find("lock near robi")

        assert "safe" not in [one.device.id for one in answer.results]
        assert ("safe", "it waits for the owner's approval") in [(one.key, one.value) for one in answer.left_out]
        assert "safe" in [one.device.id for one in (await house.find("unapproved lock near robi")).results]


async def test_failed_commands_count_metres() -> None:
    """Five of five failed: 2.4 m, and 0.6 m for one of which nothing is known; a week later half of it counts."""
    async with golden() as house:
        past = [_outcome("hall_lamp", house.app.graph.clock.now(), "no_answer") for _ in range(4)]
        async with Node(house.app.graph, "journal") as journal:

            def read(_: ReadJournalRequest) -> ReadJournalResponse:
                return ReadJournalResponse(entries=tuple(past))

            journal.create_service(ReadJournal, READ_JOURNAL, read)
            await house.robot_at(3.5, 1.0)
            await house.find("lamp near robi")
            await anyio.sleep(0.01)
            house.outcomes.publish(_outcome("hall_lamp", house.app.graph.clock.now(), "no_answer"))
            await anyio.sleep(0.01)
            assert await house.why("lamp near robi") == {
                "hall_lamp": "4.9 m = 2.5 path + 2.4 5 of 5 commands failed lately",
                "kitchen_lamp": "7.7 m = 7.1 path by Hall-Kitchen (assumed open) + 0.6 no command was tried lately",
            }


@pytest.mark.parametrize("cause", ["person", "program"])
async def test_a_device_is_not_farther_as_somebody_else_undid_its_command(cause: str) -> None:
    async with golden() as house:
        done = _outcome("hall_lamp", house.app.graph.clock.now(), "confirmed")
        undone = _outcome("hall_lamp", house.app.graph.clock.now(), "reverted")
        past = [*[done] * 4, undone.model_copy(update={"kind": "reverted", "cause": cause})]
        async with Node(house.app.graph, "journal") as journal:

            def read(_: ReadJournalRequest) -> ReadJournalResponse:
                return ReadJournalResponse(entries=tuple(past))

            journal.create_service(ReadJournal, READ_JOURNAL, read)
            await house.robot_at(3.5, 1.0)
            await house.find("lamp near robi")
            await anyio.sleep(0.01)
            assert "0 of 4 commands failed" in (await house.why("lamp near robi"))["hall_lamp"]


def _outcome(device: str, at: float, outcome: str) -> JournalEntry:
    result = CommandResult(command_id="c", outcome=outcome, text="")
    return JournalEntry(kind="outcome", at=Time.from_seconds(at), device=device, results=(result,))


@pytest.mark.parametrize("ask", ["find", "follow"])
@pytest.mark.parametrize(
    ("filters", "problem"),
    [
        ({"area": "Hal"}, "no device is in 'hal'; did you mean Hall?"),
        ({"area": "Garage"}, "no device is in 'garage', and [places] has no such room; rooms are Hall, Kitchen"),
        ({"name": "Hal lamp"}, "nothing is called 'hal lamp'; did you mean hall lamp?"),
    ],
)
async def test_a_name_that_nothing_has_is_reported(ask: str, filters: dict[str, Any], problem: str) -> None:
    async with golden() as house:
        devices = Devices(house.app)
        assert await devices.find(Light, area="outside") == ()  # a room of the plan, as yet without devices
        assert await devices.find(Light, name="Porch lamp") == ()  # it may yet be announced
        with anyio.move_on_after(1):
            await (devices.find(Light, **filters) if ask == "find" else anext(devices.follow(Light, **filters)))
        mistakes = await HouseView.of(house.app).names.mistakes()
        (mistake,) = [told for told in mistakes if problem in told]
        assert mistake.startswith(f"{ask}(Light, ")


async def test_the_service_for_devices_refuses_a_misspelt_room_where_it_is_asked_to() -> None:
    """The door asks it to for each query as text."""
    async with golden() as house:
        find = house.app.create_client(FindDevices, FIND_DEVICES)
        wanted = query_terms(parse_query("lamp in Hal"))
        assert (await find.call(FindDevices.Request(query=wanted))).devices == ()
        with pytest.raises(ServiceFailedError, match="no device is in 'hal'; did you mean Hall"):
            await find.call(FindDevices.Request(query=wanted, is_checked=True))
        values, _ = parse_queries(FindDevices.Request, {"query": "lamp in Hal"})
        assert values["is_checked"] is True
