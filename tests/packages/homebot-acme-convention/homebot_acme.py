"""Lamps of Acme, which announce themselves on MQTT.

A lamp publishes who it is, retained, on ``acme/SERIAL/info``: ``{"name": "Desk", "dimmable": true}``; an empty payload
takes that back. It reports ``on``, ``off`` or, where it is dimmable, ``on 40`` (percent) on ``acme/SERIAL/state``, when
it changes or when something is published on ``acme/SERIAL/get``. It takes commands of the same form on
``acme/SERIAL/set``.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Annotated, ClassVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from homebot.conventions.command_values import require_bool, require_number
from homebot.conventions.description import (
    AnnouncementEvent,
    DescribedPart,
    DeviceAnnounced,
    DeviceWithdrawn,
    Publication,
)
from homebot.conventions.part_builder import BytesPart
from homebot.conventions.payload import NO_READINGS, Readings
from homebot.devices.identity import identifiers
from homebot.devices.value import PlainValue
from homebot.errors import WireError

__all__ = ["Acme", "AcmeSettings"]


class AcmeSettings(BaseModel):
    """The table ``[gateways.mqtt.acme]``.

    Attributes:
        prefix: First level of the topics.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    prefix: Annotated[str, Field(pattern=r"^[^+#/\x00]+$")] = "acme"


class Acme:
    """The convention: reads announcements, and keeps nothing of them."""

    Settings: ClassVar[type[BaseModel]] = AcmeSettings
    name: ClassVar[str] = "acme"

    def __init__(self, settings: AcmeSettings) -> None:
        self.rejected = 0
        self._prefix = settings.prefix

    def filters(self) -> tuple[str, ...]:
        """Return the filter of all announcements."""
        return (f"{self._prefix}/+/info",)

    def birth_messages(self) -> tuple[Publication, ...]:
        """Return nothing: announcements are retained."""
        return ()

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Return the lamp that *payload* announces, or that it is gone.

        Raises:
            WireError: The payload is not the JSON that the maker documents.
        """
        del retained  # it says the same at any time
        serial = topic.split("/")[1]
        if not payload:
            return (DeviceWithdrawn(serial, "its info was removed"),)
        try:
            info = _Info.model_validate_json(payload)
        except ValidationError as error:
            self.rejected += 1
            first = error.errors()[0]
            raise WireError(f"{topic}: {'.'.join(map(str, first['loc']))} {first['msg']}", payload) from error
        lamp = DeviceAnnounced(
            key=serial,
            convention=self.name,
            native=True,
            identifiers=identifiers([f"acme-{serial}"]),
            name=info.name,
            parts=(_lamp(f"{self._prefix}/{serial}", info),),
            topic=topic,
            facts={"manufacturer": "Acme"},
        )
        return (lamp,)


class _Info(BaseModel):
    name: Annotated[str, Field(min_length=1, max_length=100)]
    dimmable: bool = False


_STATE = re.compile(rb"(on|off)(?: (\d{1,3}))?")


def _lamp(base: str, info: _Info) -> DescribedPart:
    lamp = _Lamp(f"{base}/set")
    part = BytesPart("light", "light")
    part.read_from(f"{base}/state", lamp.read)
    part.add_command_topics(lamp.topic)
    part.add_state_request(Publication(f"{base}/get", b""))
    part.add_capability("on_off", writer=lamp.switch)
    if info.dimmable:
        part.add_capability("level", writer=lamp.dim)
    return part.build()


@dataclass(frozen=True, slots=True)
class _Lamp:
    """The codec of a lamp.

    Attributes:
        topic: The topic on which it takes commands.
    """

    topic: str

    def read(self, payload: bytes) -> Readings:
        """Return what a report says; nothing where it is not one."""
        match = _STATE.fullmatch(payload)
        if match is None:
            return NO_READINGS
        on, level = match.groups()
        readings: dict[str, PlainValue] = {"on_off": on == b"on"}
        if level is not None and int(level) <= 100:
            readings["level"] = float(level)
        return readings

    def switch(self, value: PlainValue, transition: float) -> tuple[Publication, ...]:
        """Return the command that turns the lamp on or off; it knows no transitions."""
        del transition
        return (Publication(self.topic, b"on" if require_bool("on_off", value) else b"off"),)

    def dim(self, value: PlainValue, transition: float) -> tuple[Publication, ...]:
        """Return the command that sets the brightness in percent; 0 turns the lamp off."""
        del transition
        percent = round(require_number("level", value, 0, 100, "%"))
        return (Publication(self.topic, b"on %d" % percent if percent else b"off"),)
