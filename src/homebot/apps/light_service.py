"""The light service: it turns off every lamp that reports that it is on."""

from __future__ import annotations

from homebot.apps.base import App
from homebot.devices.handles import HandleChange, Light

__all__ = ["LightService"]


def _report(change: HandleChange[Light]) -> tuple[Light, float]:
    """Return lamp and time of a report, which comes as a change and as a message."""
    at = change.handle.told_at if change.message is None else change.message.received_at.to_seconds()
    return change.handle, at


class LightService(App):
    """Turns off each lamp that reports that it is on, those that appear later too; a dimmed lamp is on."""

    async def run(self) -> None:
        """Answer each lamp that reports that it is on."""
        reports = self.devices.follow(Light), self.devices.messages(Light)
        self.on(reports, self._answer, most=100, key=_report)
        self.node.create_timer(300.0, self._look_again)  # as it did not obey, or a policy kept it on

    async def _look_again(self) -> None:
        await self.each(Light.turn_off, await self.devices.find(Light, on=True))

    async def _answer(self, change: HandleChange[Light]) -> None:
        lamp, is_repeated = change.handle, change.message is not None
        if lamp.on and not lamp.is_gone and (not is_repeated or change.text == "on"):
            if (await lamp.turn_off()).succeeded:
                self.log_limited("light_service.turned_off", f"{lamp.id} is on: turned it off", device=lamp.device.id)
        elif lamp.on is False and not (is_repeated or lamp.is_gone or lamp.is_commanded):
            self.log_limited("light_service.is_off", f"{lamp.id} is off", device=lamp.device.id)
