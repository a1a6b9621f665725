"""A light service on raw messages that nothing a lamp says ends: the load of tests of floods, days and texts."""

from __future__ import annotations

from pydantic import BaseModel

from homebot import App, Capability, Device, DevicePart, Light, Node, Part, RawMessage
from homebot.devices import PlainValue, decode_text, read_text_address
from homebot.errors import HomebotError, LinkError, RefusedError, ServiceError, WireError
from homebot.log import LogLimit, more_like_this

THESIS_LIGHT_SERVICE = "tests.thesis_light_service:ThesisLightService"
"""The class as a configuration names it."""

TURNED_OFF = "light_service.turned_off"
IS_OFF = "light_service.is_off"
NOT_UNDERSTOOD = "light_service.not_understood"
NO_MESSAGES = "light_service.no_messages"
NOT_TURNED_OFF = "light_service.not_turned_off"

SERVICE_TYPE = "lights"

BURST = 50
"""Lines of one kind in ten seconds, over all lamps."""

BURST_OF_LAMP = 5
"""Lines of one kind about one lamp in ten seconds."""


_ANY_LAMP = Part(
    id="",
    service_type="light",
    capabilities=tuple(Capability(name=name) for name in ("on_off", "level", "color_temperature")),
)
"""Of which nothing is known but that it is one."""


class ThesisLightService(App):
    """Follows every lamp, those that appear later too, and turns off each that reports that it is on.

    A report is judged by its value: ``0.6`` is on as well. One that tells its brightness apart from whether it
    is on is on where it says that.
    """

    def __init__(self, node: Node, settings: BaseModel) -> None:
        super().__init__(node, settings)
        self._noted_off: set[str] = set()
        self._handles: dict[str, tuple[Light, ...]] = {}
        self._texts: dict[tuple[str, str], PlainValue] = {}
        self._lines = LogLimit(node.graph.clock, burst=BURST)
        self._lines_of_lamp = LogLimit(node.graph.clock, burst=BURST_OF_LAMP)
        self._problems = LogLimit(node.graph.clock)

    async def run(self) -> None:
        """Subscribe to each lamp from when it appears."""
        async for change in self.devices.follow(SERVICE_TYPE):
            if change.kind == "removed":
                self._noted_off.discard(change.device.id)
                self._handles.pop(change.device.id, None)
                self._texts = {name: value for name, value in self._texts.items() if name[0] != change.device.id}
            else:
                self._handles[change.device.id] = self.devices.handles(change.device, Light, change.sequence)
                await self._listen(change.device)

    async def _listen(self, lamp: Device) -> None:
        async def answer(message: RawMessage) -> None:
            try:
                await self._answer(lamp, message)
            except WireError as exc:
                self._log_problem(NOT_UNDERSTOOD, lamp, exc)
            except (RefusedError, LinkError) as exc:
                self._log_problem(NOT_TURNED_OFF, lamp, exc)

        try:
            await self.devices.listen(lamp, answer)
        except (RefusedError, ServiceError) as exc:
            self._log_problem(NO_MESSAGES, lamp, exc)

    async def _answer(self, lamp: Device, message: RawMessage) -> None:
        """Answer ``on`` with ``off``; note ``off``.

        Raises:
            WireError: The lamp reported something else.
            RefusedError, LinkError: The command cannot be sent.
        """
        is_on = self._is_on(lamp, message)
        if is_on:
            self._noted_off.discard(lamp.id)
            others = await self.devices.tell(lamp, "off")
            self._log(TURNED_OFF, lamp, f"is on: turned it off{', but not ' + ', '.join(others) if others else ''}")
        elif is_on is not None and lamp.id not in self._noted_off:
            self._noted_off.add(lamp.id)
            self._log(IS_OFF, lamp, "is off")

    def _is_on(self, lamp: Device, message: RawMessage) -> bool | None:
        """Return whether *lamp* is on by *message*; None where it is about something else.

        Raises:
            WireError: It is no report of a lamp.
        """
        part = _sending_part(lamp, message)
        values = decode_text(message.text(), _ANY_LAMP if part is None else part.part)
        if not values:
            raise WireError(f"{message.address} reported neither on nor off", message.payload)
        level, on = values.get("level"), values.get("on_off")
        if part is not None and read_text_address(message.address) is not None:
            if level is None and on is not None:
                self._texts[lamp.id, part.id] = on
            elif level is not None:
                on = self._last_value(lamp.id, part.id, on)
        if isinstance(on, bool):
            return on
        return level > 0 if isinstance(level, float) else None

    def _last_value(self, lamp: str, part: str, otherwise: PlainValue) -> PlainValue:
        """Return whether a lamp that announces itself is on, even where it now reports its brightness.

        Its words come before the directory has heard of them, and of those from before the last one alone.
        """
        known = (one.on for one in self._handles.get(lamp, ()) if one.part_id == part)
        known_values = (self._texts.get((lamp, part)), *known)
        return next((value for value in known_values if value is not None), otherwise)

    def _log(self, event: str, lamp: Device, text: str) -> None:
        if self._lines_of_lamp.allows(f"{event} {lamp.id}") is not None and self._lines.allows(event) is not None:
            self.node.log.info(event, message=f"{lamp.id} {text}", device=lamp.id)

    def _log_problem(self, event: str, lamp: Device, problem: HomebotError) -> None:
        held_back = self._problems.allows(f"{event} {lamp.id}")
        if held_back is not None and self._lines.allows(event) is not None:
            self.node.log.warning(
                event, message=f"{lamp.id}: {problem}{more_like_this(held_back)}", device=lamp.id, held_back=held_back
            )


def _sending_part(device: Device, message: RawMessage) -> DevicePart | None:
    """Return the part of *device* that sent *message*; None if unknown."""
    place = read_text_address(message.address)
    for part in device.parts:
        for route in part.routes:
            is_it = route.key == message.key if place is None else (route.key, route.part) == place
            if is_it and route.gateway == message.gateway:
                return part
    return None
