from homebot import App, RawMessage, run


class WindowLight(App):
    async def run(self) -> None:
        async for change in self.devices.follow("windows"):
            if change.kind == "appeared":
                await self.devices.listen(change.device, self.window_says)

    async def window_says(self, message: RawMessage) -> None:
        for lamp in await self.devices.find("lights"):
            await self.devices.tell(lamp, "on" if message.text() == "open" else "off")


if __name__ == "__main__":
    run(WindowLight)
