"""Health of gateways, the directory and the runtime: problems, counters, failures, quarantine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, ClassVar, Self

from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message, ServiceType, UInt32, UInt64
from homebot.support.counters import Severity

if TYPE_CHECKING:
    from _typeshed import DataclassInstance


class Quarantine(Message):
    """A source with so many rule violations that its messages are read at a limited rate.

    Attributes:
        offender: The source (MQTT: the topic, or ``PREFIX/#`` for all topics of a prefix without an announced device).
        why: The last violated rule, as text.
        offences: Number of violations since the last quiet period.
        until: When it ends, unless there are further violations.
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
    """A named counter.

    Attributes:
        count: Number since the gateway started.
        severity: What it means if it is above 0.
    """

    name: str
    count: UInt64
    severity: Severity = Severity.NORMAL

    @classmethod
    def each(cls, counts: Mapping[str, int], severity: Severity = Severity.NORMAL) -> tuple[Self, ...]:
        """Return a counter for each name in *counts*."""
        return tuple(cls(name=name, count=count, severity=severity) for name, count in counts.items())

    @classmethod
    def of(cls, counters: DataclassInstance) -> tuple[Self, ...]:
        """Return a counter for each field of *counters*, with its severity (:mod:`homebot.support.counters`)."""
        declared = {field.name: field.metadata.get("severity", Severity.NORMAL) for field in fields(counters)}
        return tuple(cls(name=name, count=getattr(counters, name), severity=how) for name, how in declared.items())


class PartFailure(Message):
    """The known failures of one part of the program since it started.

    Attributes:
        part: The part: a component's name, or a node's.
        what: The failure, in words: "crashed", "the handler of /topic failed".
        outcome: The consequence, in words; empty if it simply continues.
    """

    part: str
    what: str
    count: UInt64
    last: Time
    why: str
    outcome: str = ""


class HealthRequest(Message):
    """Request for the health of a component."""


class HealthResponse(Message):
    """The health of a gateway, the directory, or the runtime.

    Attributes:
        troubles: Its present problems, in words; empty if there are none.
        notes: Its limits in the present setup, in words; these are not problems.
        home: The name of the home; of the runtime alone, as the next.
        build: The build of the page; a page of another one reloads.
    """

    counts: tuple[Count, ...]
    quarantined: tuple[Quarantine, ...] = ()
    troubles: tuple[str, ...] = ()
    failures: tuple[PartFailure, ...] = ()
    notes: tuple[str, ...] = ()
    home: str = ""
    build: str = ""


GetHealth = ServiceType("homebot/srv/GetHealth", HealthRequest, HealthResponse)
