"""Parts of devices that can be used by themselves, with their capabilities."""

from collections.abc import Iterable
from typing import Literal, TypeAlias

from homebot.messages.message import Message

__all__ = ["Capability", "Category", "Part", "size_of_texts", "texts_of"]


Category: TypeAlias = Literal["", "config", "diagnostic"]

_EACH = 32
"""Bytes that a text takes beside its characters, about."""


class Capability(Message):
    """One value of a part that can be read, set, or both.

    Attributes:
        name: From the vocabulary, for example ``on_off``; see :data:`homebot.devices.capabilities.CAPABILITIES`.
        readable: Whether the part reports it; if not, its state is never known (*optimistic*).
        unit: The unit of its values, for example ``°C``; empty if there is none, or it is that of the vocabulary.
        bounds: The smallest and the largest value; empty where unknown.
        options: The texts that it accepts or reports; empty for any.
        echoed: Whether it is declared that a report of it may only repeat a command, before the device obeyed: such a
            report proves nothing.
    """

    name: str
    readable: bool = True
    settable: bool = False
    unit: str = ""
    bounds: tuple[float, ...] = ()
    options: tuple[str, ...] = ()
    echoed: bool = False


class Part(Message):
    """One function of a device: a lamp, one of two relays, a thermometer.

    Attributes:
        id: Unique in its device, and lasting; empty for the only part of a simple device.
        name: The name for people, if the part has one of its own.
        service_type: A device type of the vocabulary, for example ``light``; see
            :data:`homebot.devices.device_types.DEVICE_TYPES`.
        advertised: The type in the words of its announcement, for example ``lights`` or ``cover``.
        tag: The kind within its type, for example ``window`` or ``blind``; empty if it declares none.
        category: ``config`` for a setting, ``diagnostic`` for a self-observation; empty for a main function.
        guessed: Whether the service type was guessed rather than declared.
        capabilities: The values that it reports and the commands that it accepts.
        reads: The addresses on which it reports (MQTT: topic filters).
        writes: The addresses on which it accepts commands (MQTT: topics).
        payloads: A digest of the command payloads in the announcement; empty if they follow from the
            other fields, as in a protocol that leaves no choice.
    """

    id: str
    name: str = ""
    service_type: str
    advertised: str = ""
    tag: str = ""
    category: Category = ""
    guessed: bool = False
    capabilities: tuple[Capability, ...] = ()
    reads: tuple[str, ...] = ()
    writes: tuple[str, ...] = ()
    payloads: str = ""

    def is_below(self, places: Iterable[str]) -> bool:
        """Return whether it has one of the topics *places*, or one below them."""
        return any(f"{one}/".startswith(f"{place}/") for place in places for one in (*self.reads, *self.writes))


def size_of_texts(texts: Iterable[str]) -> int:
    """Return the size of *texts* in bytes, about."""
    known = texts if isinstance(texts, list) else tuple(texts)
    return len("".join(known)) + _EACH * len(known)


def texts_of(part: Part) -> list[str]:
    """Return the topics and options of *part*, which make it long or short."""
    texts = [*part.reads, *part.writes]
    for capability in part.capabilities:
        if capability.options:
            texts += capability.options
    return texts
