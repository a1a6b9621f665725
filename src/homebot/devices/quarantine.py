"""Whom a gateway ignores for a while, and what else it counted."""

from __future__ import annotations

from typing import ClassVar

from homebot.messages.builtin_interfaces import Time
from homebot.messages.fields import UInt32, UInt64
from homebot.messages.message import Message
from homebot.messages.service_type import ServiceType

__all__ = ["Count", "GetHealth", "HealthRequest", "HealthResponse", "PartFailure", "Quarantine"]


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


class PartFailure(Message):
    """What went wrong in one part of the program, as far as is known since it started.

    Attributes:
        part: The part: a component's name, or a node's.
        what: What happened to it, in words: "crashed", "the handler of /topic failed".
        count: How often.
        last: When it happened last.
        why: The last error, in words.
        outcome: What came of it, in words; empty where it simply goes on.
    """

    part: str
    what: str
    count: UInt64
    last: Time
    why: str
    outcome: str = ""


class HealthRequest(Message):
    """How are you?"""


class HealthResponse(Message):
    """How a gateway is, the directory, or the runtime.

    Attributes:
        counts: What it took in, refused and dropped.
        quarantined: Whom it ignores now.
        troubles: What is wrong with it now, in words; empty where nothing is.
        failures: What failed in it.
    """

    counts: tuple[Count, ...]
    quarantined: tuple[Quarantine, ...] = ()
    troubles: tuple[str, ...] = ()
    failures: tuple[PartFailure, ...] = ()


GetHealth = ServiceType("homebot/srv/GetHealth", HealthRequest, HealthResponse)
