from homebot import App, Handle, HandleChange
from homebot.apps import AppSettings


class Settings(AppSettings):  # the keys of [apps.doorbell]
    button: str = "Doorbell"


class Doorbell(App[Settings]):
    async def run(self) -> None:
        button = self.devices.follow(Handle, name=self.settings.button)
        self.on(button.only("event"), self.ring)

    async def ring(self, press: HandleChange[Handle]) -> None:
        self.store["rings"] = rings = self.store.get("rings", 0) + 1
        await self.notify(f"{press.handle.name} rang, {rings} so far")
