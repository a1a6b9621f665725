"""A robot's way: hold the door, have the lamp of the next room on, drive in, release; a second robot waits."""

import asyncio

from homebot import App, Device, Light, RawMessage, WindowCovering

ROOM = "kitchen"


class RobotWay(App):
    async def run(self) -> None:
        self.doorway = asyncio.Lock()
        async with asyncio.TaskGroup() as tasks:
            async for change in self.devices.follow("robots"):
                if change.kind == "appeared":
                    tasks.create_task(self.drive(change.device))

    async def drive(self, robot: Device) -> None:
        arrived = asyncio.Event()

        def hear(message: RawMessage) -> None:
            if message.text() == ROOM:
                arrived.set()

        await self.devices.listen(robot, hear)
        door = (await anext(self.devices.follow(WindowCovering, area=ROOM))).handle
        async with self.doorway, door.hold("open", by=robot.id) as hold:  # a second robot waits here
            if not hold.succeeded:
                self.say(f"{robot.id} stays: {hold.outcome.text}")
                return
            for outcome in await self.each(Light.turn_on, await self.devices.find(Light, area=ROOM, on=False)):
                self.say(f"before {robot.id} drives: {outcome.text}")
            arrived.clear()
            await self.devices.tell(robot, f"go {ROOM}")
            await arrived.wait()
            self.say(f"{robot.id} is in the {ROOM}")

    def say(self, text: str) -> None:
        self.node.log.info("robot_way", message=text)
