"""The light service of the thesis: it answers a lamp's ``on`` with ``off``."""

from __future__ import annotations

from pydantic import BaseModel

from homebot.apps.base import App
from homebot.devices import Device, RawMessage
from homebot.errors import HomebotError, WireError
from homebot.graph import Node
from homebot.log import LogLimit

__all__ = ["LightService"]

TOLD_OFF = "light_service.told_off"
IS_OFF = "light_service.is_off"
NOT_UNDERSTOOD = "light_service.not_understood"
NO_MESSAGES = "light_service.no_messages"

SERVICE_TYPE = "lights"


class LightService(App):
    """Follows every lamp, those that appear later too, and switches off whichever says that it is on."""

    def __init__(self, node: Node, settings: BaseModel) -> None:
        super().__init__(node, settings)
        self._noted_off: set[str] = set()

    async def run(self) -> None:
        """Listen to each lamp from when it appears."""
        limit = LogLimit(self.node.graph.clock)
        async for change in self.devices.follow(SERVICE_TYPE):
            if change.kind == "removed":
                self._noted_off.discard(change.device.id)
            elif change.kind in {"appeared", "changed"}:
                await self._listen(change.device, limit)

    async def _listen(self, lamp: Device, limit: LogLimit) -> None:
        async def answer(message: RawMessage) -> None:
            try:
                await self._answer(lamp, message)
            except WireError as exc:
                if limit.allows(lamp.id) is not None:
                    self.node.log.warning(NOT_UNDERSTOOD, message=f"{lamp.id}: {exc}", device=lamp.id)

        try:
            await self.devices.listen(lamp, answer)
        except HomebotError as exc:
            self.node.log.error(NO_MESSAGES, message=str(exc), device=lamp.id)

    async def _answer(self, lamp: Device, message: RawMessage) -> None:
        """Answer ``on`` with ``off``; note ``off``.

        Raises:
            WireError: The lamp said something else.
        """
        state = message.text()
        if state == "on":
            await self.devices.tell(lamp, "off")
            self._noted_off.discard(lamp.id)
            self.node.log.info(TOLD_OFF, message=f"{lamp.id} is on: told it off", device=lamp.id)
        elif state == "off":
            if lamp.id not in self._noted_off:
                self._noted_off.add(lamp.id)
                self.node.log.info(IS_OFF, message=f"{lamp.id} is off", device=lamp.id)
        else:
            raise WireError(f"{message.address} says neither on nor off", message.payload)
