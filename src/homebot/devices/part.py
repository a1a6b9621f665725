"""What a device consists of: the parts that can be used by themselves, and what each can do."""

from __future__ import annotations

from typing import Literal, TypeAlias

from homebot.messages.message import Message

__all__ = ["Capability", "Category", "Part"]

Category: TypeAlias = Literal["", "config", "diagnostic"]


class Capability(Message):
    """One thing that a part can be asked or told.

    Attributes:
        name: From the vocabulary, for example ``on_off``; see :data:`homebot.devices.capabilities.CAPABILITIES`.
        readable: Whether the part reports it; one that does not is *optimistic*: nobody knows its state.
        settable: Whether it can be told.
        unit: Of its values, for example ``°C``; empty where there is none, or as the vocabulary says.
        bounds: Smallest and largest value; empty where none is known.
        options: The texts it takes or says; empty where any.
    """

    name: str
    readable: bool = True
    settable: bool = False
    unit: str = ""
    bounds: tuple[float, ...] = ()
    options: tuple[str, ...] = ()


class Part(Message):
    """Something a device offers: a lamp, one of two relays, a thermometer.

    Attributes:
        id: Unique in its device, and lasting; empty for the only part of a simple device.
        name: What people call it, where it has a name beside its device's.
        service_type: A device type of the vocabulary, for example ``light``; see
            :data:`homebot.devices.device_types.DEVICE_TYPES`.
        advertised: What the device itself called that, for example ``lights`` or ``cover``.
        tag: What kind it is of its type, for example ``window`` or ``blind``; empty where nothing was said.
        category: ``config`` for a setting, ``diagnostic`` for a self-observation; empty for what the device is for.
        guessed: Whether the service type was guessed rather than declared.
        capabilities: What it can do.
        reads: Where it speaks (MQTT: topic filters).
        writes: Where it listens (MQTT: topics).
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
