"""The services by which layers ask each other about devices."""

from typing import Literal, TypeAlias

from homebot.devices.device import Device, DeviceChange, Freshness
from homebot.devices.gateway_messages import RawMessage
from homebot.devices.query.term_messages import QueryTerm
from homebot.devices.value import Reading
from homebot.messages.builtin_interfaces import Time
from homebot.messages.key_value import KeyValue
from homebot.messages.message import Message, ServiceAnswer, ServiceType, UInt32

__all__ = [
    "MOST_LISTED",
    "AnnouncedOn",
    "ExportIndex",
    "FindDevices",
    "ForgetDevice",
    "Found",
    "GetChanges",
    "GetIndexData",
    "IndexEntry",
    "IndexRow",
    "IndexTable",
    "ListDevices",
    "ListedDevice",
    "QueryDevices",
    "SubscribeToTopic",
]


MOST_LISTED = 200
"""Devices in one answer of :data:`ListDevices`, which is then about 30 kB of JSON."""

NEVER = Time(sec=2**31 - 1, nanosec=0)


class GetIndexDataRequest(Message):
    """A question for the devices that offer a service.

    Attributes:
        service_type: For example ``lights``; empty for all.
    """

    service_type: str


class IndexEntry(Message):
    """One address of a device, as :class:`SubscribeToTopic` takes it.

    Attributes:
        gateway: Through which gateway, for example ``mqtt``: its services and topics are below ``/gateway/<name>``.
        topic: The address on which it publishes there.
    """

    gateway: str
    topic: str
    device_id: str


class GetIndexDataResponse(Message):
    """The index entries, as the thesis's discovery layer gave them: pairs of gateway and topic.

    Attributes:
        entries: The pairs, sorted by device; of a device with several gateways, each once.
        topics: The topic of each device's first entry, for programs that know one gateway.
        device_ids: The same devices' ids, in the same order.
    """

    entries: tuple[IndexEntry, ...]
    topics: tuple[str, ...]
    device_ids: tuple[str, ...]


class FindDevicesRequest(Message):
    """A question for all devices.

    Attributes:
        service_type: For example ``lights``; empty for all. Canonical and advertised words find the same devices, see
            :func:`homebot.devices.device_types.wanted_types`.
        query: The query that they match, as terms; empty for all. Programs outside may send it as text. One that is
            not understood fails the call. Unlike :class:`QueryDevicesRequest` it ranks nothing.
        ids: Only the devices with these ids; empty for all.
        is_checked: Whether the call fails for a name in the query that nothing in the house has, as of
            :class:`QueryDevicesRequest`; by default it does for programs outside.
    """

    service_type: str = ""
    query: tuple[QueryTerm, ...] = ()
    ids: tuple[str, ...] = ()
    is_checked: bool = False


class FindDevicesResponse(Message):
    """The devices, sorted by id; near a robot the nearest first.

    Attributes:
        sequence: The last change that is in there; see :class:`homebot.devices.DeviceChange`.
    """

    devices: tuple[Device, ...]
    sequence: int


class QueryDevicesRequest(Message):
    """A question for the devices that match a query.

    Attributes:
        query: The query, as terms; empty for all. Programs outside may send it as text, for example
            ``light and dimmable in kitchen``; see :mod:`homebot.devices.query`.
        offset: How many of the best to leave out.
        limit: How many to give; 0 for as many as there are.
    """

    query: tuple[QueryTerm, ...] = ()
    offset: UInt32 = 0
    limit: UInt32 = 0


class Found(Message):
    """One device that fits a query.

    Attributes:
        score: How well it fits; only to be compared within one answer.
        reasons: Why it fits and why it stands where it stands, in words, the weightiest first.
    """

    device: Device
    score: float
    reasons: tuple[str, ...]


class QueryDevicesResponse(ServiceAnswer):
    """The devices that fit, best first; equally good ones by id. A query with a misspelt type, room or word fails.

    Attributes:
        total: Number of matches, before the limit.
        sequence: The last change that is included; see :class:`homebot.devices.DeviceChange`.
        is_mistake: Whether it failed for a mistake in the query, so that asking again does not help.
        pose_age: Of what is near a robot: seconds since its pose was received; the message says where that was.
        left_out: Likewise: the ids of some devices that fit otherwise and are not results, with the reason.
    """

    results: tuple[Found, ...] = ()
    total: UInt32 = 0
    sequence: int = 0
    is_mistake: bool = False
    pose_age: float = 0.0
    left_out: tuple[KeyValue, ...] = ()


class ListDevicesRequest(Message):
    """A question for the devices that match a query, in short, for screens and agents.

    Attributes:
        query: The query that they match, as terms; empty for all. Programs outside may send it as text.
        ids: Only the devices with these ids; empty for all.
        offset: How many to leave out.
        limit: How many to give; at most 200, and 0 for as many.
    """

    query: tuple[QueryTerm, ...] = ()
    ids: tuple[str, ...] = ()
    offset: UInt32 = 0
    limit: UInt32 = 0


class ListedDevice(Message):
    """A device in short: about 150 bytes of JSON.

    Attributes:
        type: Its main type of the vocabulary, for example ``light``.
        freshness: As of :class:`homebot.devices.Device`.
        is_reachable: False if it reports that it cannot be reached.
        waits: Whether its commands wait for the owner's approval.
        states: The latest value of each capability that people use.
        position: Its x and y on the plan of the home, in metres; empty if they are not known.
    """

    id: str
    name: str
    type: str
    room: str
    freshness: Freshness
    is_reachable: bool
    waits: bool
    states: tuple[Reading, ...]
    position: tuple[float, ...] = ()


class ListDevicesResponse(ServiceAnswer):
    """The devices, by id; near a robot the nearest first. A query with a misspelt type, room or word fails.

    Attributes:
        total: Number of matches, before the limit.
        sequence: The last change that is included; see :class:`homebot.devices.DeviceChange`.
    """

    devices: tuple[ListedDevice, ...] = ()
    total: UInt32 = 0
    sequence: int = 0


class GetChangesRequest(Message):
    """A question for the changes since a moment.

    Attributes:
        since: Number of the last change that the client has.
    """

    since: int


class GetChangesResponse(Message):
    """The changes after that one, oldest first.

    Attributes:
        changes: Those that are still remembered.
        complete: Whether that is all; otherwise some are forgotten, and only a new snapshot is complete.
        sequence: Number of the last change there was.
    """

    changes: tuple[DeviceChange, ...]
    complete: bool
    sequence: int


class ForgetDeviceRequest(Message):
    """Take a device out of the index."""

    device: str


class AnnouncedOn(Message):
    """The place at which a device was announced.

    Attributes:
        topic: Where (MQTT: the topic, on which the broker may keep the announcement).
    """

    gateway: str
    topic: str


class ForgetDeviceResponse(ServiceAnswer):
    """The result of forgetting a device, which comes back when it sends a message or is announced again.

    Attributes:
        announced_on: Where it was announced, as far as is known.
    """

    announced_on: tuple[AnnouncedOn, ...] = ()


class SplitDeviceRequest(Message):
    """Make several devices of one, because it is not one; the directory remembers that over a restart.

    Attributes:
        gateway: The gateway of the announcement that is not about it; empty to make one device of each announcement
            that differs in its identifiers.
    """

    device: str
    gateway: str = ""
    key: str = ""


class SplitDeviceResponse(ServiceAnswer):
    """The result of splitting a device.

    Attributes:
        devices: Their ids, that of the one before first.
    """

    devices: tuple[str, ...] = ()


class MergeDevicesRequest(Message):
    """Make several devices one, because they are one; the directory remembers that over a restart.

    All endpoints of the device may have its commands from now on.

    Attributes:
        devices: Their ids; one alone where an endpoint of it only claims to be it (:attr:`Endpoint.claimed`).
    """

    devices: tuple[str, ...]


class MergeDevicesResponse(ServiceAnswer):
    """The result of merging devices."""

    device: str = ""


class SubscribeToTopicRequest(Message):
    """Give me the raw messages of an address.

    Attributes:
        topic: The address in the gateway's terms, for example the MQTT topic ``home425/lights/roomlights405/out``.
        listener: Full name of the node that asks, for delivery into its inbox; empty for a topic of the device's own.
        since: Messages of this time or later, but before this call, are in the response as far as the gateway still
            has them. The device's retained state at the broker is always included.
    """

    topic: str
    listener: str = ""
    since: Time = NEVER


class SubscribeToTopicResponse(ServiceAnswer):
    """The topic on which the messages will come.

    Attributes:
        data_topic: The graph topic that carries them from now on, as :class:`homebot.devices.RawMessage`.
        missed: The messages before, oldest first; at most 10.
    """

    data_topic: str
    missed: tuple[RawMessage, ...] = ()


IndexTable: TypeAlias = Literal["devices", "tombstones", "owner"]


class IndexRow(Message):
    """A row of the index file.

    Attributes:
        table: Its table: ``devices``, ``tombstones`` for devices that went, or ``owner`` for decisions of the owner.
        id: The id of the device, or the subject of the owner's record.
        record: The record, as the text of a JSON object.
    """

    table: IndexTable
    id: str
    record: str


class ExportIndexRequest(Message):
    """A request for all rows that the index file would have now, whether there is one or not."""


class ExportIndexResponse(Message):
    """The rows of the index."""

    rows: tuple[IndexRow, ...]


GetIndexData = ServiceType("homebot/srv/GetIndexData", GetIndexDataRequest, GetIndexDataResponse)
FindDevices = ServiceType("homebot/srv/FindDevices", FindDevicesRequest, FindDevicesResponse)
QueryDevices = ServiceType("homebot/srv/QueryDevices", QueryDevicesRequest, QueryDevicesResponse)
ForgetDevice = ServiceType("homebot/srv/ForgetDevice", ForgetDeviceRequest, ForgetDeviceResponse)
ListDevices = ServiceType("homebot/srv/ListDevices", ListDevicesRequest, ListDevicesResponse)
GetChanges = ServiceType("homebot/srv/GetChanges", GetChangesRequest, GetChangesResponse)
SplitDevice = ServiceType("homebot/srv/SplitDevice", SplitDeviceRequest, SplitDeviceResponse)
MergeDevices = ServiceType("homebot/srv/MergeDevices", MergeDevicesRequest, MergeDevicesResponse)
SubscribeToTopic = ServiceType("homebot/srv/SubscribeToTopic", SubscribeToTopicRequest, SubscribeToTopicResponse)
ExportIndex = ServiceType("homebot/srv/ExportIndex", ExportIndexRequest, ExportIndexResponse)
