from homebot import App, Closure, Light, run


class WindowLight(App):
    async def run(self) -> None:
        async for change in self.devices.follow(Closure, closed=False):
            if change.kind != "changed":
                for lamp in await self.devices.find(Light):
                    await (lamp.turn_on() if change.kind == "appeared" else lamp.turn_off())


if __name__ == "__main__":
    run(WindowLight)
