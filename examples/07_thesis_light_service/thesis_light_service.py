"""The light service of the thesis on raw messages: it answers each ``on`` of a lamp with ``off``."""

from functools import partial

from homebot import App, Device, Light, RawMessage


class ThesisLightService(App):
    async def run(self) -> None:
        for lamp in await self.devices.find(Light, on=True):
            await self.devices.tell(lamp.device, "off")
        async for change in self.devices.follow("lights"):
            if change.kind == "appeared":
                await self.devices.listen(change.device, partial(self.answer, change.device))

    async def answer(self, lamp: Device, message: RawMessage) -> None:
        if message.text() == "on":
            await self.devices.tell(lamp, "off")
        elif message.text() == "off":
            self.node.log.info("light_service.is_off", message=f"{lamp.id} is off")
