"""A robot's way: hold the door open and the lamps of the next room on, drive in, release; a second robot waits."""

import asyncio
from contextlib import AsyncExitStack

import anyio

from homebot import App, Device, Light, WindowCovering

ROOM, MOST_S = "kitchen", 300.0  # a robot that has not arrived after these seconds lets go of the door and the lamps


class RobotWay(App):
    async def run(self) -> None:
        self.doorway = asyncio.Lock()
        drives: dict[str, asyncio.Task[None]] = {}
        async with asyncio.TaskGroup() as tasks:
            async for change in self.devices.follow("robots"):
                robot = change.device
                if change.kind == "appeared":
                    drives[robot.id] = tasks.create_task(self.drive(robot))
                elif change.kind == "removed" or robot.freshness == "stale" or robot.reachable.state == "no":
                    drives[robot.id].cancel()  # a dead robot lets go at once

    async def drive(self, robot: Device) -> None:
        door = (await anext(self.devices.follow(WindowCovering, area=ROOM))).handle
        async with self.doorway, AsyncExitStack() as held:  # a second robot waits here
            hold = await held.enter_async_context(door.hold("open", by=robot.id))
            if not hold.succeeded:
                self.node.log.info("robot_way", message=f"{robot.id} stays: {hold.outcome.text}")
                return
            for lamp in await self.devices.find(Light, area=ROOM):  # so that nobody turns one off meanwhile
                lit = await held.enter_async_context(lamp.hold("on", by=robot.id))
                self.node.log.info("robot_way", message=f"before {robot.id} drives: {lit.outcome.text}")
            arrived = asyncio.Event()
            await self.devices.listen(robot, lambda message: arrived.set() if message.text() == ROOM else None)
            await self.devices.tell(robot, f"go {ROOM}")
            with anyio.move_on_after(MOST_S):
                await arrived.wait()
            self.node.log.info("robot_way", message=f"{robot.id} {'is' if arrived.is_set() else 'not'} in the {ROOM}")
