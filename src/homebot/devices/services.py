"""The services with which layers ask each other about devices."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from homebot.devices.device import Device, DeviceChange, Freshness
from homebot.devices.gateway_messages import RawMessage
from homebot.devices.query.term_messages import QueryTerm
from homebot.devices.value import Reading
from homebot.messages.builtin_interfaces import Time
from homebot.messages.key_value import KeyValue
from homebot.messages.message import Message, ServiceAnswer, ServiceType, UInt32

MAX_LISTED = 200
"""The limit of devices in one answer of :data:`ListDevices`, about 60 kB of JSON."""

NEVER = Time(sec=2**31 - 1, nanosec=0)


class GetIndexDataRequest(Message):
    """Request for the devices that offer a service.

    Attributes:
        service_type: For example ``lights``; empty for all.
    """

    service_type: str


class IndexEntry(Message):
    """One address of a device, for :class:`SubscribeToTopic`.

    Attributes:
        gateway: The gateway, for example ``mqtt``: its services and topics are below ``/gateway/<name>``.
        topic: The address on which it publishes there.
    """

    gateway: str
    topic: str
    device_id: str


class GetIndexDataResponse(Message):
    """The index entries of the thesis's discovery layer: pairs of gateway and topic.

    Attributes:
        entries: The pairs, sorted by device; one for each gateway of a device.
        topics: The topic of each device's first entry, for programs that use only one gateway.
        device_ids: The same devices' ids, in the same order.
    """

    entries: tuple[IndexEntry, ...]
    topics: tuple[str, ...]
    device_ids: tuple[str, ...]


class FindDevicesRequest(Message):
    """Request for all devices.

    Attributes:
        service_type: For example ``lights``; empty for all. Canonical and advertised words find the same devices; see
            :func:`homebot.devices.device_types.wanted_types`.
        query: The query that they match, as terms; empty for all. External programs may send it as text. The call fails
        if it is not understood. Unlike :class:`QueryDevicesRequest` it does not rank.
        ids: Only the devices with these ids; empty for all.
        is_checked: Whether the call fails for a name in the query that nothing in the house has, as with
        :class:`QueryDevicesRequest`; by default it does for external programs.
    """

    service_type: str = ""
    query: tuple[QueryTerm, ...] = ()
    ids: tuple[str, ...] = ()
    is_checked: bool = False


class FindDevicesResponse(Message):
    """The devices, sorted by id; near a robot, nearest first.

    Attributes:
        sequence: The last change that is included; see :class:`homebot.devices.DeviceChange`.
    """

    devices: tuple[Device, ...]
    sequence: int


class QueryDevicesRequest(Message):
    """Request for the devices that match a query.

    Attributes:
        query: The query, as terms; empty for all. External programs may send it as text, for example
            ``light and dimmable in kitchen``; see :mod:`homebot.words.queries`.
        offset: The number of best matches to skip.
        limit: The largest number of matches; 0 for all.
        is_spelled: Whether a typo or a beginning matches nothing, as in a command.
    """

    query: tuple[QueryTerm, ...] = ()
    offset: UInt32 = 0
    limit: UInt32 = 0
    is_spelled: bool = False


class Found(Message):
    """One device that fits a query.

    Attributes:
        score: How well it fits; only comparable within one answer.
        reasons: Why it fits, and the reasons for its rank, in words, most important first.
    """

    device: Device
    score: float
    reasons: tuple[str, ...]


class QueryDevicesResponse(ServiceAnswer):
    """The devices that fit, best first, equally good ones by id. A query with a misspelt type, room or word fails.

    Attributes:
        total: Number of matches, before the limit.
        sequence: The last change that is included; see :class:`homebot.devices.DeviceChange`.
        is_mistake: Whether it failed because of a mistake in the query, so that repeating it does not help.
        pose_age: Near a robot: seconds since its pose was received; the message states the position.
        left_out: Near a robot: the ids of some devices that fit otherwise but were left out, with the reason.
        query: A query in words as it was read: words that are exactly a name mean what is called so.
    """

    results: tuple[Found, ...] = ()
    total: UInt32 = 0
    sequence: int = 0
    is_mistake: bool = False
    pose_age: float = 0.0
    left_out: tuple[KeyValue, ...] = ()
    query: tuple[QueryTerm, ...] = ()


class ListDevicesRequest(Message):
    """Request for the devices that match a query, in short form, for screens and agents.

    Attributes:
        query: The query that they match, as terms; empty for all. External programs may send it as text.
        ids: Only the devices with these ids; empty for all.
        offset: The number of devices to skip.
        limit: The largest number of devices, at most 200; 0 for 200.
        is_spelled: Whether a typo or a beginning matches nothing, as in a command.
        issuer: The client that asks, set by the door, as its *scope* and its *rights*.
    """

    query: tuple[QueryTerm, ...] = ()
    ids: tuple[str, ...] = ()
    offset: UInt32 = 0
    limit: UInt32 = 0
    is_spelled: bool = False
    issuer: str = ""
    scope: Annotated[tuple[str, ...], Field(max_length=100)] = ()
    rights: tuple[str, ...] = ()


class ListedReading(Reading):
    """One value of one part, with its age.

    Attributes:
        since: The time of the first report of this value; 0 if it may be older, as after a start.
    """

    since: Time


class ListedDevice(Message):
    """A device in short form: about 300 bytes of JSON.

    Attributes:
        type: Its main type of the vocabulary, for example ``light``.
        freshness: As for :class:`homebot.devices.Device`.
        is_reachable: False if it reports that it cannot be reached.
        waits: Whether its commands wait for the owner's approval.
        states: The latest value of each capability that people use.
        position: Its x and y on the plan of the home, in metres; empty if unknown.
        settable: The names of those capabilities that can be set.
        tags: The words with which the owner tagged it.
        asks_first: The names of those capabilities of which setting may let in, flood or burn, so that a screen asks
            before it does; see :mod:`homebot.devices.always_ask`.
        codes: The characters of the codes that settings need, by the names of these: ``digits`` or ``text``.
        kind: Its kind of opening: ``door``, ``window``, ``garage_door``, ``gate``, or a cover such as ``blind``.
        may_act: Whether the client that asks may set all that can be set of one of its parts, perhaps with a question.
        units: The units of values whose capability has no unit of its own, by part and capability: ``p measurement``.
    """

    id: str
    name: str
    type: str
    room: str
    freshness: Freshness
    is_reachable: bool
    waits: bool
    states: tuple[ListedReading, ...]
    position: tuple[float, ...] = ()
    settable: tuple[str, ...] = ()
    tags: tuple[str, ...] = ()
    asks_first: tuple[str, ...] = ()
    codes: tuple[KeyValue, ...] = ()
    kind: str = ""
    may_act: bool = False
    units: tuple[KeyValue, ...] = ()


class ListDevicesResponse(ServiceAnswer):
    """The devices, by id; near a robot, nearest first. A query with a misspelt type, room or word fails.

    Without devices, the message says why there are none.

    Attributes:
        total: Number of matches, before the limit.
        sequence: The last change that is included; see :class:`homebot.devices.DeviceChange`.
    """

    devices: tuple[ListedDevice, ...] = ()
    total: UInt32 = 0
    sequence: int = 0


class GetChangesRequest(Message):
    """Request for recent changes.

    Attributes:
        since: Number of the last change that the client has.
    """

    since: int


class GetChangesResponse(Message):
    """The changes after that one, oldest first.

    Attributes:
        changes: The changes that are still remembered.
        complete: Whether these are all changes; otherwise some are forgotten, and a new snapshot is needed.
        sequence: Number of the latest change.
    """

    changes: tuple[DeviceChange, ...]
    complete: bool
    sequence: int


class ForgetDeviceRequest(Message):
    """Request to remove a device from the index."""

    device: str


class AnnouncedOn(Message):
    """The address on which a device was announced.

    Attributes:
        topic: The address (MQTT: the topic, on which the broker may retain the announcement).
    """

    gateway: str
    topic: str


class ForgetDeviceResponse(ServiceAnswer):
    """The result of forgetting a device, which returns when it sends a message or is announced again.

    Attributes:
        announced_on: The known addresses on which it was announced.
    """

    announced_on: tuple[AnnouncedOn, ...] = ()


class SplitDeviceRequest(Message):
    """Request to split a device that is in fact several; the directory remembers it across restarts.

    Attributes:
        gateway: The gateway of the announcement that belongs to another device; empty to make a device of each
        announcement with different identifiers.
    """

    device: str
    gateway: str = ""
    key: str = ""


class SplitDeviceResponse(ServiceAnswer):
    """The result of splitting a device.

    Attributes:
        devices: Their ids, that of the original device first.
    """

    devices: tuple[str, ...] = ()


class MergeDevicesRequest(Message):
    """Request to merge several devices that are in fact one; the directory remembers it across restarts.

    From then on all endpoints of the device get its commands.

    Attributes:
        devices: Their ids; a single one to confirm an endpoint that only claims to be it (:attr:`Endpoint.claimed`).
    """

    devices: tuple[str, ...]


class MergeDevicesResponse(ServiceAnswer):
    """The result of merging devices."""

    device: str = ""


class SubscribeToTopicRequest(Message):
    """Request for the raw messages of an address.

    Attributes:
        topic: The address in the gateway's terms, for example the MQTT topic ``home425/lights/roomlights405/out``.
        listener: Full name of the requesting node, for delivery to its inbox; empty for a topic of the device's own.
        since: Messages from this time until this call are in the response if the gateway still has them. The device's
            retained state at the broker is always included.
        undeclared: Whether no device need publish there; only for a *listener*.
    """

    topic: str
    listener: str = ""
    since: Time = NEVER
    undeclared: bool = False


class SubscribeToTopicResponse(ServiceAnswer):
    """The topic on which the messages will be published.

    Attributes:
        data_topic: The graph topic that carries them from now on, as :class:`homebot.devices.RawMessage`.
        missed: The earlier messages, oldest first; at most 10.
    """

    data_topic: str
    missed: tuple[RawMessage, ...] = ()


IndexTable: TypeAlias = Literal["devices", "tombstones", "owner"]


class IndexRow(Message):
    """A row of the index file.

    Attributes:
        table: Its table: ``devices``, ``tombstones`` for removed devices, or ``owner`` for decisions of the owner.
        id: The id of the device, or the subject of the owner's record.
        record: The record, as the text of a JSON object.
    """

    table: IndexTable
    id: str
    record: str


class ExportIndexRequest(Message):
    """Request for all current rows of the index file, even if there is no file."""


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
