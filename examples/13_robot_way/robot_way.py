"""A robot's way: hold the door, have the lamp of the next room on, drive in, release; a second robot waits."""

import asyncio
from collections import defaultdict

from homebot import App, Device, Light, RawMessage, WindowCovering

WAY = "kitchen"


class RobotWay(App):
    async def run(self) -> None:
        self.doorways = defaultdict[str, asyncio.Lock](asyncio.Lock)
        async with asyncio.TaskGroup() as tasks:
            async for change in self.devices.follow("robots"):
                if change.kind == "appeared":
                    tasks.create_task(self.drive(change.device, WAY))

    async def drive(self, robot: Device, room: str) -> None:
        arrived = asyncio.Event()

        def hear(message: RawMessage) -> None:
            if message.text() == room:
                arrived.set()

        await self.devices.listen(robot, hear)
        async with self.doorways[room]:  # a second robot waits here
            (door,) = await self.devices.find(WindowCovering, area=room)
            async with door.hold("open", by=robot.id) as hold:  # nobody closes it meanwhile
                if not hold.succeeded:
                    self.say(f"{robot.id} stays: {hold.outcome.text}")
                    return
                lamps = await self.devices.find(Light, area=room, on=False)
                for outcome in await self.each(Light.turn_on, lamps):
                    self.say(f"before {robot.id} drives: {outcome.text}")
                await self.devices.tell(robot, f"go {room}")
                await arrived.wait()
                self.say(f"{robot.id} is in the {room}")

    def say(self, text: str) -> None:
        self.node.log.info("robot_way", message=text)
