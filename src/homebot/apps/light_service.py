"""The light service: turns off every lamp that reports that it is on."""

from homebot.apps.base import App
from homebot.apps.rooms import per_handle
from homebot.devices.handles import HandleChange, Light


class LightService(App):
    """Turns off each lamp that reports that it is on, including lamps that appear later; a dimmed lamp is on."""

    async def run(self) -> None:
        """Turn off lamps that are on; and every five minutes those that did not obey, or that a policy kept on."""
        reports = self.devices.follow(Light), self.devices.messages(Light)
        self.on(reports, self._turn_off, mode="parallel", most=100, key=per_handle)
        self.every("5m", self._look_again, name="look again")

    async def _turn_off(self, change: HandleChange[Light]) -> None:
        lamp = change.handle
        if lamp.on and change.text in {"", "on"} and not lamp.is_gone:
            await lamp.turn_off()

    async def _look_again(self) -> None:
        await self.each(Light.turn_off, await self.devices.find(Light, on=True))
