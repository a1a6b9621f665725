"""How a device puts its words on MQTT: a port of pure functions, one for each family of devices.

A word is what a device of :mod:`homebot.house` says or is told, such as ``on`` or ``21.5``. What goes over the
wire is the dialect's own. A device that another speaks for, as a bridge for its lamps, says everything itself here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from homebot.errors import UsageError

__all__ = ["DIALECTS", "Dialect", "Nameplate", "Outgoing", "ThesisDialect"]


@dataclass(frozen=True, slots=True)
class Nameplate:
    """What a device knows of itself.

    Attributes:
        home: First level, or levels, of the topics.
        kind: What it is, as houses are described: ``lamp``.
        device_id: Its name.
        service_type: What it offers.
        room: Where it is.

    Raises:
        UsageError: The name or the service type is empty or cannot be one level of a topic.
    """

    home: str
    kind: str
    device_id: str
    service_type: str
    room: str

    def __post_init__(self) -> None:
        for level in (self.device_id, self.service_type):
            if not level or any(character in level for character in "/+#\0"):
                raise UsageError(f"{level!r} cannot be a level of a topic, as a device's name and service type must")


@dataclass(frozen=True, slots=True)
class Outgoing:
    """A message that a device sends.

    Attributes:
        topic: Where to.
        payload: What.
        retain: Whether the broker keeps it for those who come later.
        qos: How sure it has to be that it comes, 0 to 2.
    """

    topic: str
    payload: bytes
    retain: bool = False
    qos: int = 1


class Dialect(Protocol):
    """A family of devices. No function raises, whatever words and payloads it is given."""

    def filters(self, device: Nameplate) -> tuple[str, ...]:
        """Return the topic filters that *device* subscribes to."""
        ...

    def birth(self, device: Nameplate) -> tuple[Outgoing, ...]:
        """Return what *device* says first on each new link, before its state: announcement, availability."""
        ...

    def will(self, device: Nameplate) -> Outgoing | None:
        """Return what the broker says when *device* vanishes."""
        ...

    def said(self, device: Nameplate, word: str) -> tuple[Outgoing, ...]:
        """Return the messages by which *device* says *word*."""
        ...

    def told(self, device: Nameplate, topic: str, payload: bytes) -> tuple[str, ...]:
        """Return the commands in a message that came in; empty where it holds none."""
        ...


class ThesisDialect:
    """The layout of the thesis: words as they are, on ``HOME/SERVICE_TYPE/DEVICE_ID/out`` and ``…/in``."""

    def filters(self, device: Nameplate) -> tuple[str, ...]:
        """Return its ``in``."""
        return (f"{_base(device)}/in",)

    def birth(self, device: Nameplate) -> tuple[Outgoing, ...]:
        """Return nothing: the layout announces no devices."""
        del device
        return ()

    def will(self, device: Nameplate) -> Outgoing | None:
        """Return None."""
        del device
        return None

    def said(self, device: Nameplate, word: str) -> tuple[Outgoing, ...]:
        """Return the word, on its ``out``; what is no Unicode becomes ``?``."""
        return (Outgoing(f"{_base(device)}/out", word.encode(errors="replace")),)

    def told(self, device: Nameplate, topic: str, payload: bytes) -> tuple[str, ...]:
        """Return the payload as text; what is no UTF-8 becomes U+FFFD."""
        del device, topic
        return (payload.decode(errors="replace"),)


DIALECTS: dict[str, Dialect] = {"thesis": ThesisDialect()}
"""The dialects by the names that houses are described with."""


def _base(device: Nameplate) -> str:
    return f"{device.home}/{device.service_type}/{device.device_id}"
