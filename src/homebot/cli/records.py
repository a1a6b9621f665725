"""Records of homebot's answers: the fields of its messages, as JSON has them.

To import the messages, and to check thousands of devices once more, takes longer than all else that a command does.
"""

from __future__ import annotations

from typing import TypedDict

__all__ = [
    "CapabilityRecord",
    "DeviceChangeRecord",
    "DevicePartRecord",
    "DeviceRecord",
    "EntityRecord",
    "FactRecord",
    "ForgetResponseRecord",
    "GatewayStateRecord",
    "HealthRecord",
    "KeyValueRecord",
    "MergeResponseRecord",
    "PartFailureRecord",
    "QuarantineRecord",
    "QueryResponseRecord",
    "ReadTagRecord",
    "RouteRecord",
    "ScanCodeRecord",
    "SplitResponseRecord",
    "StateRecord",
    "TimeRecord",
    "ValueRecord",
    "WriteTagRecord",
]


class TimeRecord(TypedDict):
    """:class:`homebot.messages.Time`."""

    sec: int
    nanosec: int


class ValueRecord(TypedDict):
    """:class:`homebot.devices.value.Value`."""

    type: int
    flag: bool
    number: float
    text: str
    numbers: list[float]


class StateRecord(TypedDict):
    """:class:`homebot.devices.State`."""

    part: str
    capability: str
    value: ValueRecord
    since: TimeRecord
    told_at: TimeRecord
    live: bool
    is_first: bool


class CapabilityRecord(TypedDict):
    """:class:`homebot.devices.part.Capability`."""

    name: str
    readable: bool
    settable: bool
    unit: str
    bounds: list[float]
    options: list[str]


class PartRecord(TypedDict):
    """:class:`homebot.devices.part.Part`."""

    id: str
    name: str
    service_type: str
    advertised: str
    tag: str
    category: str
    guessed: bool
    capabilities: list[CapabilityRecord]
    reads: list[str]
    writes: list[str]


class RouteRecord(TypedDict):
    """:class:`homebot.devices.Route`."""

    gateway: str
    key: str
    part: str
    convention: str
    takes: list[str]


class DevicePartRecord(TypedDict):
    """:class:`homebot.devices.DevicePart`."""

    id: str
    part: PartRecord
    routes: list[RouteRecord]


class EndpointRecord(TypedDict):
    """:class:`homebot.devices.Endpoint`."""

    gateway: str
    key: str
    address: str
    command_address: str
    freshness: str
    last_seen: TimeRecord
    reachable: str
    claimed: bool


class KeyValueRecord(TypedDict):
    """:class:`homebot.devices.KeyValue`."""

    key: str
    value: str


class FactRecord(TypedDict):
    """:class:`homebot.devices.Fact`."""

    name: str
    value: str
    gateway: str
    convention: str
    key: str
    said_at: TimeRecord


class ReachabilityRecord(TypedDict):
    """:class:`homebot.devices.Reachability`."""

    state: str
    since: TimeRecord
    why: str


class DeviceRecord(TypedDict):
    """:class:`homebot.devices.Device`."""

    id: str
    name: str
    service_type: str
    endpoints: list[EndpointRecord]
    metadata: list[KeyValueRecord]
    first_seen: TimeRecord
    last_seen: TimeRecord
    expires: TimeRecord
    freshness: str
    service_types: list[str]
    area: str
    outer_areas: list[str]
    tags: list[str]
    names: list[str]
    identifiers: list[str]
    parts: list[DevicePartRecord]
    facts: list[FactRecord]
    reachable: ReachabilityRecord
    states: list[StateRecord]
    events: list[StateRecord]
    offline_parts: list[str]
    evidence: list[str]
    conflicts: list[str]


class DeviceChangeRecord(TypedDict):
    """:class:`homebot.devices.DeviceChange`."""

    kind: str
    device: DeviceRecord
    sequence: int
    why: str
    other: str


class FoundRecord(TypedDict):
    """:class:`homebot.devices.Found`."""

    device: DeviceRecord
    score: float
    reasons: list[str]


class QueryResponseRecord(TypedDict):
    """:class:`homebot.devices.services.QueryDevicesResponse`."""

    success: bool
    message: str
    results: list[FoundRecord]
    total: int
    sequence: int


class AnnouncedOnRecord(TypedDict):
    """:class:`homebot.devices.services.AnnouncedOn`."""

    gateway: str
    topic: str


class ForgetResponseRecord(TypedDict):
    """:class:`homebot.devices.services.ForgetDeviceResponse`."""

    success: bool
    message: str
    announced_on: list[AnnouncedOnRecord]


class SplitResponseRecord(TypedDict):
    """:class:`homebot.devices.services.SplitDeviceResponse`."""

    success: bool
    message: str
    devices: list[str]


class MergeResponseRecord(TypedDict):
    """:class:`homebot.devices.services.MergeDevicesResponse`."""

    success: bool
    message: str
    device: str


class EntityRecord(TypedDict):
    """One node, or one end of a topic or service: ``homebot/msg/EndpointDetails``."""

    kind: str
    node: str
    name: str
    type: str
    reliability: str
    durability: str
    history: str
    depth: int
    lifespan: float
    deadline: float
    liveliness: str
    liveliness_lease_duration: float


class GatewayStateRecord(TypedDict):
    """:class:`homebot.devices.GatewayState`."""

    state: str
    reason: str
    acts: bool


class CountRecord(TypedDict):
    """:class:`homebot.devices.health.Count`."""

    name: str
    count: int


class QuarantineRecord(TypedDict):
    """:class:`homebot.devices.health.Quarantine`."""

    gateway: str
    offender: str
    why: str
    offences: int
    since: TimeRecord
    until: TimeRecord
    is_over: bool


class PartFailureRecord(TypedDict):
    """:class:`homebot.devices.health.PartFailure`."""

    part: str
    what: str
    count: int
    last: TimeRecord
    why: str
    outcome: str


class HealthRecord(TypedDict):
    """:class:`homebot.devices.health.HealthResponse`."""

    counts: list[CountRecord]
    quarantined: list[QuarantineRecord]
    troubles: list[str]
    failures: list[PartFailureRecord]
    notes: list[str]


class ScanCodeRecord(TypedDict):
    """:class:`homebot.devices.tags.ScanCodeResponse`."""

    success: bool
    message: str
    device: str
    area: str


class ReadTagRecord(TypedDict):
    """:class:`homebot.devices.tags.ReadTagResponse`."""

    success: bool
    message: str
    problem: str
    tag: str
    reader: str
    tag_type: str
    device: str
    area: str


class WriteTagRecord(TypedDict):
    """:class:`homebot.devices.tags.WriteTagResponse`."""

    success: bool
    message: str
    problem: str
    tag: str
    device: str
