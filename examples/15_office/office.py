"""Robots in an office of two floors: through a door, by the lift, through another door, as clients of Open-RMF do."""

import asyncio
from collections.abc import Callable
from typing import Any

from homebot import App, Device, RawMessage
from homebot.messages import Time
from homebot.messages.interfaces import find_message

Door: Any = find_message("rmf_door_msgs/msg/DoorRequest")
Mode: Any = find_message("rmf_door_msgs/msg/DoorMode")
DoorState: Any = find_message("rmf_door_msgs/msg/DoorState")
Lift: Any = find_message("rmf_lift_msgs/msg/LiftRequest")
LiftState: Any = find_message("rmf_lift_msgs/msg/LiftState")
CLOSED, OPEN = 0, 2
END, AGV = 0, 1
NOW = Time(sec=0, nanosec=0)
DIES = "bob"


class Office(App):
    async def run(self) -> None:
        self.doors: dict[str, Any] = {}
        self.lift: Any = None
        self.ask_door = self.node.create_publisher(Door, "/adapter_door_requests", 10)
        self.ask_lift = self.node.create_publisher(Lift, "/adapter_lift_requests", 10)
        self.node.create_subscription(
            DoorState, "/door_states", lambda state: self.doors.update({state.door_name: state})
        )
        self.node.create_subscription(LiftState, "/lift_states", lambda state: setattr(self, "lift", state))
        async with asyncio.TaskGroup() as tasks:
            async for change in self.devices.follow("robots"):
                if change.kind == "appeared":
                    tasks.create_task(self.ride(change.device, change.device.name))

    async def ride(self, robot: Device, name: str) -> None:
        if name == DIES:
            await asyncio.sleep(90)
        await self.through(robot, name, "workshop_door", "lobby")
        await self.until(lambda: self.has_lift(name, "ground"), lambda: self.request(name, "ground"))
        await self.go(robot, "lift")
        if name == DIES:
            self.say(f"{name} dies in the lift")
            return
        await self.until(lambda: self.has_lift(name, "upper"), lambda: self.request(name, "upper"))
        await self.go(robot, "landing")
        self.request(name, "upper", END)
        await self.through(robot, name, "lab_door", "lab")

    async def through(self, robot: Device, name: str, door: str, room: str) -> None:
        await self.until(lambda: self.is_open(door), lambda: self.open(name, door, OPEN))
        await self.go(robot, room)
        self.open(name, door, CLOSED)

    async def until(self, is_so: Callable[[], bool], ask: Callable[[], None]) -> None:
        while not is_so():
            ask()
            await asyncio.sleep(1)

    async def go(self, robot: Device, room: str) -> None:
        arrived = asyncio.Event()
        await self.devices.listen(robot, lambda message: hears(message, room, arrived))
        await self.devices.tell(robot, f"go {room}")
        await arrived.wait()
        self.say(f"{robot.name} is in the {room}")

    def is_open(self, door: str) -> bool:
        return door in self.doors and self.doors[door].current_mode.value == OPEN

    def has_lift(self, name: str, floor: str) -> bool:
        lift = self.lift
        return lift and (lift.session_id, lift.current_floor, lift.door_state) == (name, floor, OPEN)

    def open(self, name: str, door: str, mode: int) -> None:
        self.ask_door.publish(
            Door(requester_id=name, door_name=door, requested_mode=Mode(value=mode), request_time=NOW)
        )

    def request(self, name: str, floor: str, kind: int = AGV) -> None:
        wanted = {"session_id": name, "destination_floor": floor, "request_type": kind, "door_state": OPEN}
        self.ask_lift.publish(Lift(lift_name="main", request_time=NOW, **wanted))

    def say(self, text: str) -> None:
        self.node.log.info("office", message=text)


def hears(message: RawMessage, room: str, arrived: asyncio.Event) -> None:
    if message.text() == room:
        arrived.set()
