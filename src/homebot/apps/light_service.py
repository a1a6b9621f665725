"""The light service of the thesis: it answers a lamp's ``on`` with ``off``."""

from __future__ import annotations

from pydantic import BaseModel

from homebot.apps.base import App
from homebot.devices import Device, RawMessage
from homebot.errors import HomebotError, LinkError, RefusedError, ServiceError, WireError
from homebot.graph import Node
from homebot.log import LogLimit

__all__ = ["LightService"]

TOLD_OFF = "light_service.told_off"
IS_OFF = "light_service.is_off"
NOT_UNDERSTOOD = "light_service.not_understood"
NO_MESSAGES = "light_service.no_messages"
NOT_TOLD = "light_service.not_told"

SERVICE_TYPE = "lights"

BURST = 50
"""Lines of one kind in ten seconds, over all lamps."""

BURST_OF_LAMP = 5
"""Lines of one kind about one lamp in ten seconds."""


class LightService(App):
    """Follows every lamp, those that appear later too, and switches off whichever says that it is on."""

    def __init__(self, node: Node, settings: BaseModel) -> None:
        super().__init__(node, settings)
        self._noted_off: set[str] = set()
        self._lines = LogLimit(node.graph.clock, burst=BURST)
        self._lines_of_lamp = LogLimit(node.graph.clock, burst=BURST_OF_LAMP)
        self._problems = LogLimit(node.graph.clock)

    async def run(self) -> None:
        """Listen to each lamp from when it appears."""
        async for change in self.devices.follow(SERVICE_TYPE):
            if change.kind == "removed":
                self._noted_off.discard(change.device.id)
            else:
                await self._listen(change.device)

    async def _listen(self, lamp: Device) -> None:
        async def answer(message: RawMessage) -> None:
            try:
                await self._answer(lamp, message)
            except WireError as exc:
                self._complain(NOT_UNDERSTOOD, lamp, exc)
            except (RefusedError, LinkError) as exc:
                self._complain(NOT_TOLD, lamp, exc)

        try:
            await self.devices.listen(lamp, answer)
        except (RefusedError, ServiceError) as exc:
            self._complain(NO_MESSAGES, lamp, exc)

    async def _answer(self, lamp: Device, message: RawMessage) -> None:
        """Answer ``on`` with ``off``; note ``off``.

        Raises:
            WireError: The lamp said something else.
            RefusedError, LinkError: It cannot be told.
        """
        state = message.text()
        if state == "on":
            self._noted_off.discard(lamp.id)
            await self.devices.tell(lamp, "off")
            self._say(TOLD_OFF, lamp, "is on: told it off")
        elif state == "off":
            if lamp.id not in self._noted_off:
                self._noted_off.add(lamp.id)
                self._say(IS_OFF, lamp, "is off")
        else:
            raise WireError(f"{message.address} says neither on nor off", message.payload)

    def _say(self, event: str, lamp: Device, words: str) -> None:
        if self._lines_of_lamp.allows(f"{event} {lamp.id}") is not None and self._lines.allows(event) is not None:
            self.node.log.info(event, message=f"{lamp.id} {words}", device=lamp.id)

    def _complain(self, event: str, lamp: Device, problem: HomebotError) -> None:
        held_back = self._problems.allows(f"{event} {lamp.id}")
        if held_back is not None and self._lines.allows(event) is not None:
            more = f" (and {held_back} more like this)" if held_back else ""
            self.node.log.warning(event, message=f"{lamp.id}: {problem}{more}", device=lamp.id, held_back=held_back)
