"""Health of gateways, the directory and the runtime: problems, counters, failures, quarantine."""

from collections.abc import Mapping
from typing import ClassVar, Self

from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message, ServiceType, UInt32, UInt64

__all__ = ["Count", "GetHealth", "HealthRequest", "HealthResponse", "PartFailure", "Quarantine"]


class Quarantine(Message):
    """So much that came from outside broke the rules that what comes there is read a little at a time.

    Attributes:
        gateway: Which gateway reads it.
        offender: Where that came (MQTT: the topic, or ``PREFIX/#`` for all topics of a prefix on which no device stands
            announced).
        why: The last rule that was broken, in words.
        offences: How often one was, since all was quiet.
        since: From when on.
        until: Until when, if nothing more comes.
        is_over: Whether everything is read again.
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

    @classmethod
    def each(cls, counts: Mapping[str, int]) -> tuple[Self, ...]:
        """Return one for each of *counts*, which are by name."""
        return tuple(cls(name=name, count=count) for name, count in counts.items())


class PartFailure(Message):
    """The failures of one part of the program, as far as is known since it started.

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
    """A question for the health of a component."""


class HealthResponse(Message):
    """The health of a gateway, the directory, or the runtime.

    Attributes:
        counts: What it took in, refused and dropped.
        quarantined: The peers in quarantine now.
        troubles: What is wrong with it now, in words; empty where nothing is.
        failures: What failed in it.
        notes: What it cannot do the way it is set up, in words; nothing is wrong.
        home: Of the runtime: the name of the home.
    """

    counts: tuple[Count, ...]
    quarantined: tuple[Quarantine, ...] = ()
    troubles: tuple[str, ...] = ()
    failures: tuple[PartFailure, ...] = ()
    notes: tuple[str, ...] = ()
    home: str = ""


GetHealth = ServiceType("homebot/srv/GetHealth", HealthRequest, HealthResponse)
