"""The light service: turns off every lamp that reports that it is on."""

from homebot.apps.base import App
from homebot.apps.rooms import per_handle
from homebot.devices.handles import HandleChange, Light

__all__ = ["LightService"]


class LightService(App):
    """Turns off each lamp that reports that it is on, including lamps that appear later; a dimmed lamp is on."""

    async def run(self) -> None:
        """React to each lamp that reports that it is on."""
        reports = self.devices.follow(Light), self.devices.messages(Light)
        self.on(reports, self._answer, mode="parallel", most=100, key=per_handle)
        self.every("5m", self._look_again, name="look again")  # for lamps that did not obey, or that a policy kept on

    async def _look_again(self) -> None:
        await self.each(Light.turn_off, await self.devices.find(Light, on=True))

    async def _answer(self, change: HandleChange[Light]) -> None:
        lamp = change.handle
        if lamp.is_gone or (change.message and change.text != "on"):
            return
        if lamp.on:
            await lamp.turn_off()
        elif lamp.on is False and not lamp.is_commanded:
            self.log_limited("light_service.is_off", f"{lamp.id} is off", device=lamp.device.id)
