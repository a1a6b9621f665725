"""The processor time of a question for what is near a robot, among 10,000 devices in houses of three sizes.

Rooms of 4 m in rows, each with a door to each neighbour, some of them with a contact; the robot is somewhere else for
each question, and now and then a door opens or closes.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Coroutine
from random import Random

import anyio.lowlevel

from directory import report, sighting
from homebot.cli.serve import short_collections
from homebot.clock import LoopClock
from homebot.devices import QUERY_DEVICES, QueryDevices, Sighting
from homebot.devices.gateway_messages import Report as DeviceReport
from homebot.devices.names import WHERE_IS_ROBOT
from homebot.devices.part import Capability, Part
from homebot.devices.query.term_messages import query_terms
from homebot.devices.robot_messages import RobotPose, WhereIsRobot, WhereIsRobotRequest, WhereIsRobotResponse
from homebot.devices.services import QueryDevicesRequest, QueryDevicesResponse
from homebot.devices.value import Reading, Value
from homebot.discovery import DeviceIndex, Directory, DirectorySettings
from homebot.discovery.owner_facts import OwnerFacts
from homebot.graph import Client, Graph, Node
from homebot.messages import Time
from homebot.places import HouseDoor, HouseRoom, OwnerFact, Places
from homebot.words.queries import parse_query
from plan import Plan
from report import Report, milliseconds, verdict
from rounds import median

__all__ = ["run"]

HEADINGS = ("rooms", "doors", "query", "median", "aim", "", "slowest", "longest turn of the first question")
AIM = 5e-3
DEVICES = 10_000
SIZES = (12, 100, 1000)
QUERIES = ("off light near robot", "light within 5 m of robot", "'thing 1242' near robot")
LIMIT = 5
QUESTIONS = 50
SIDE = 4.0
COLUMNS = 32
CONTACT = 10
"""Of so many doors one has a contact."""

OFTEN = 5
"""After so many questions a door opens or closes."""


def run(plan: Plan) -> Report:
    devices = plan.count(DEVICES)
    rows: list[tuple[str, ...]] = [HEADINGS]
    with short_collections():
        for size in SIZES:
            rows += asyncio.run(_rows(size, devices, plan.count(QUESTIONS)))
    return Report(f"Near: milliseconds of the processor for the best {LIMIT} of {devices:,} devices", (), (), rows)


async def _rows(size: int, devices: int, questions: int) -> list[tuple[str, ...]]:
    graph, random = Graph(LoopClock(0.0)), Random(size)
    places = _places(size, devices, random)
    async with Node(graph, "discovery") as node, Node(graph, "robots") as robots, Node(graph, "app") as app:
        directory = Directory(node, DirectorySettings(persist=False), owner=OwnerFacts("Home", places))
        _announce_all(directory.index, devices, places, graph.clock.monotonic(), random)
        node.create_task(directory.serve)
        house = _House(directory.index, size, [door.contact for door in places.doors if door.contact], random, robots)
        client = app.create_client(QueryDevices, QUERY_DEVICES)
        await client.wait_for_service()
        longest = await _longest_turn(_asked(house, client, QUERIES[0], 1))
        rows: list[tuple[str, ...]] = []
        for text in QUERIES:
            times = await _asked(house, client, text, questions)
            middle = median(times)
            figures = milliseconds(middle), f"<= {milliseconds(AIM)}", verdict(middle <= AIM), milliseconds(max(times))
            rows.append((str(size), str(len(places.doors)), text, *figures, milliseconds(longest)))
        return rows


class _House:
    """The robot and the doors of a house.

    Args:
        index: The index of its devices.
        size: The number of rooms.
        contacts: The contacts of its doors.
        random: Where the robot goes.
        robots: The node of robots.
    """

    def __init__(self, index: DeviceIndex, size: int, contacts: list[str], random: Random, robots: Node) -> None:
        self._index = index
        self._size = size
        self._contacts = contacts
        self._random = random
        self._clock = robots.graph.clock
        self._moves = 0
        robots.create_service(WhereIsRobot, WHERE_IS_ROBOT, self._where)

    def change(self) -> None:
        self._moves += 1
        if self._moves % OFTEN == 0:
            reading = Reading(part="main", capability="contact", value=Value.of(self._random.random() < 0.5))
            name, now = self._random.choice(self._contacts), Time.from_seconds(self._clock.now())
            told = DeviceReport(
                gateway="mqtt", key=name, readings=(reading,), address=name, retained=False, received_at=now
            )
            self._index.report(told, self._clock.monotonic())
            self._index.pop_changes()

    def _where(self, _: WhereIsRobotRequest) -> WhereIsRobotResponse:
        x, y = _point(self._size, self._random)
        pose = RobotPose(
            robot="robi",
            room=f"Room {int(y // SIDE) * COLUMNS + int(x // SIDE)}",
            has_position=True,
            x=x,
            y=y,
            error=0.1,
            source="/tf",
            received_at=Time.from_seconds(self._clock.now()),
            limit=2.0,
        )
        return WhereIsRobotResponse(success=True, pose=(pose,))


async def _asked(
    house: _House, client: Client[QueryDevicesRequest, QueryDevicesResponse], text: str, times: int
) -> list[float]:
    """Return the seconds of the processor that each of *times* questions took."""
    request = QueryDevices.Request(query=query_terms(parse_query(text)), limit=LIMIT)
    found = []
    for _ in range(times):
        house.change()
        await anyio.lowlevel.checkpoint()
        started = time.process_time()
        answer = await client.call(request, 60.0)
        found.append(time.process_time() - started)
        assert answer.success, answer.message
    return found


async def _longest_turn(work: Coroutine[object, object, object]) -> float:
    """Return the longest processor time between two turns of another task while *work* is done."""
    longest, last = 0.0, time.process_time()
    task = asyncio.create_task(work)
    while not task.done():
        await asyncio.sleep(0)
        now = time.process_time()
        longest, last = max(longest, now - last), now
    await task
    return longest


def _announce_all(index: DeviceIndex, devices: int, places: Places, now: float, random: Random) -> None:
    for number in range(devices):
        announced = sighting(number, 0.0, confirmed=True).model_copy(update={"area": ""})
        index.observe(announced, now)
        index.report(report(announced, number, random), now)
    for name in (door.contact for door in places.doors if door.contact):
        index.observe(_contact(name), now)
    index.pop_changes()
    index.sort()


def _places(size: int, devices: int, random: Random) -> Places:
    doors: list[HouseDoor] = []
    for index in range(size):
        x, y = index % COLUMNS * SIDE, index // COLUMNS * SIDE
        for other, point in ((index + 1, (x + SIDE, y + SIDE / 2)), (index + COLUMNS, (x + SIDE / 2, y + SIDE))):
            if other < size and (other != index + 1 or other % COLUMNS):
                number = len(doors)
                contact = f"contact {number}" if number % CONTACT == 0 else ""
                doors.append(HouseDoor(f"Door {number}", (f"Room {index}", f"Room {other}"), (point,), contact=contact))
    positions = ("{:.2f},{:.2f} ±0.1".format(*_point(size, random)) for _ in range(devices))
    facts: dict[tuple[str, ...], tuple[OwnerFact, ...]] = {
        (f"eui64:{number:016x}",): (OwnerFact("position", position, "configuration", 0.0),)
        for number, position in enumerate(positions)
    }
    return Places(tuple(map(_room, range(size))), facts, tuple(doors))


def _room(index: int) -> HouseRoom:
    x, y = index % COLUMNS * SIDE, index // COLUMNS * SIDE
    return HouseRoom(f"Room {index}", polygons=((((x, y), (x + SIDE, y), (x + SIDE, y + SIDE), (x, y + SIDE)),),))


def _point(size: int, random: Random) -> tuple[float, float]:
    index = random.randrange(size)
    return (index % COLUMNS + random.random()) * SIDE, (index // COLUMNS + random.random()) * SIDE


def _contact(name: str) -> Sighting:
    part = Part(id="main", service_type="contact_sensor", capabilities=(Capability(name="contact"),), reads=(name,))
    change: dict[str, object] = {
        "key": name,
        "name": name,
        "service_type": "contact_sensor",
        "identifiers": (f"id:{name}",),
    }
    change |= {"parts": (part,), "area": "", "announced_on": f"x/{name}"}
    return sighting(0, 0.0, confirmed=True).model_copy(update=change)
