"""Whom a gateway ignores for a while, and what else it counted."""

from __future__ import annotations

from typing import ClassVar

from homebot.messages.builtin_interfaces import Time
from homebot.messages.fields import UInt32, UInt64
from homebot.messages.message import Message
from homebot.messages.service_type import ServiceType

__all__ = ["Count", "GetHealth", "HealthRequest", "HealthResponse", "Quarantine"]


class Quarantine(Message):
    """Somebody outside broke the rules so often that he is not listened to for a while.

    Attributes:
        gateway: Who ignores him.
        offender: Where he speaks (MQTT: the topic).
        why: The last rule he broke, in words.
        offences: How often he broke one, as far as is remembered.
        since: From when on he is ignored.
        until: Until when; each time twice as long as the time before.
        is_over: Whether he is listened to again.
    """

    key_field: ClassVar[str | None] = "offender"

    gateway: str
    offender: str
    why: str
    offences: UInt32
    since: Time
    until: Time
    is_over: bool = False


class Count(Message):
    """One thing that was counted.

    Attributes:
        name: What.
        count: How often, since the gateway started.
    """

    name: str
    count: UInt64


class HealthRequest(Message):
    """How are you?"""


class HealthResponse(Message):
    """How a gateway is, or the directory.

    Attributes:
        counts: What it took in, refused and dropped.
        quarantined: Whom it ignores now.
        troubles: What is wrong with it now, in words; empty where nothing is.
    """

    counts: tuple[Count, ...]
    quarantined: tuple[Quarantine, ...] = ()
    troubles: tuple[str, ...] = ()


GetHealth = ServiceType("homebot/srv/GetHealth", HealthRequest, HealthResponse)
