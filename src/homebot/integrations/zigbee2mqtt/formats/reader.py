"""Reader of Zigbee2MQTT's own messages: the list of devices in, descriptions out. Pure.

Source: zigbee2mqtt.io, Usage > MQTT topics and messages; Zigbee2MQTT 2.14.1.
"""

from collections.abc import Iterator, Mapping
from itertools import islice

from homebot.conventions.description import AnnouncementEvent, DeviceAnnounced, DeviceWithdrawn, GroupsListed, as_group
from homebot.conventions.long_json import parse_list
from homebot.conventions.payload import as_fields, clean_text, parse_object, shown
from homebot.devices.identity import identifiers
from homebot.errors import WireError
from homebot.integrations.zigbee2mqtt.formats.bridge_device import (
    BridgeDevice,
    BridgeSettings,
    ieee_address,
    read_bridge_device,
    read_bridge_settings,
)
from homebot.integrations.zigbee2mqtt.formats.groups import (
    ExposesOfEndpoints,
    GroupMember,
    build_group,
    exposes_of_groups,
)
from homebot.integrations.zigbee2mqtt.formats.parts import build_parts

MAX_BRIDGE_BYTES = 32 * 1024 * 1024
"""Longest list of devices; a device has about 4 kB, some remotes and thermostats have ten times that."""

_MAX_GROUPS_BYTES = 1024 * 1024
"""Longest list of groups; a member has about 60 bytes."""

_MAX_GROUP = 0xFFFF
"""The largest number of a group in Zigbee."""

MAX_DEVICES = 5_000
"""Most devices of one bridge; the largest known networks have some hundreds."""

MAX_PARTS = 50_000
"""Most parts of all devices of one bridge; a usual device has ten. Further devices are rejected."""

_DEFAULT_BASE = "zigbee2mqtt"


class Zigbee2MqttReader:
    """Reader of the messages of the bridges at *bases*; stores the descriptions of the last list of each."""

    def __init__(self, bases: tuple[str, ...]) -> None:
        self.rejected = 0
        self._devices: dict[str, dict[str, DeviceAnnounced]] = {base: {} for base in bases}
        self._settings = {base: BridgeSettings() for base in bases}
        self._without_json: set[str] = set()
        self._endpoints: dict[str, Mapping[str, str]] = {}  # their names by number, by address of the device
        self._exposed: dict[str, ExposesOfEndpoints] = {}  # by address of the device
        self._topics: dict[str, str] = {}
        self._group_lists: dict[str, list[Mapping[str, object]]] = {}
        self._groups: dict[str, dict[str, DeviceAnnounced]] = {base: {} for base in bases}
        self._listless = dict.fromkeys(bases, False)  # bridges without a list yet: whether they sent their settings

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Return the descriptions of the devices in a list. A broken entry affects only its device."""
        return tuple(
            event for event in self.read_message_in_slices(topic, payload, retained=retained) if event is not None
        )

    def read_message_in_slices(
        self,
        topic: str,
        payload: bytes,
        *,
        retained: bool,  # noqa: ARG002 - the bridge's lists are retained
    ) -> Iterator[AnnouncementEvent | None]:
        """Read a message in steps: a list of hundreds of devices needs a second."""
        base, _, last = topic.rpartition("/bridge/")
        if base not in self._devices:
            return
        if last == "devices":
            yield from self._read_devices(base, topic, payload)
        elif last == "groups":
            groups: list[Mapping[str, object]] = []
            for entry in islice(parse_list(payload, _MAX_GROUPS_BYTES) if payload else (), MAX_DEVICES):
                number = as_fields(entry).get("id")
                if type(number) is int and 0 <= number <= _MAX_GROUP:
                    groups.append(as_fields(entry))
                yield None
            self._group_lists[base] = groups
            yield from self._describe_groups(base, topic)
        elif last == "info" and payload:
            if base in self._listless:
                self._listless[base] = True
            info = parse_object(payload, MAX_BRIDGE_BYTES)
            settings = read_bridge_settings(info)
            is_without_json = as_fields(as_fields(info.get("config")).get("advanced")).get("output") == "attribute"
            (self._without_json.add if is_without_json else self._without_json.discard)(base)
            if settings == self._settings[base]:
                return
            self._settings[base] = settings
            changed = {
                ieee: described
                for ieee, announced in self._devices[base].items()
                if (described := self._with_settings(base, ieee, announced)) != announced
            }
            self._devices[base].update(changed)
            yield from changed.values()

    def problems(self) -> tuple[str, ...]:
        """Return the bridges that cannot be used.

        They sent their settings without their list, although both are retained, or publish unsupported states.
        """
        listless = tuple(
            f"{base}/bridge/info came, but {base}/bridge/devices did not: a list that is larger than max_announcement "
            "is dropped silently by the broker"
            for base, has_info in self._listless.items()
            if has_info
        )
        return *listless, *(
            f"{base} publishes each value on a topic of its own, which homebot does not read: set 'advanced.output' of "
            "Zigbee2MQTT to json or attribute_and_json"
            for base in sorted(self._without_json)
        )

    def _read_devices(self, base: str, topic: str, payload: bytes) -> Iterator[AnnouncementEvent | None]:
        before = self._devices[base]
        self._listless.pop(base, None)
        if not payload:
            self._devices[base] = {}
            yield from (
                DeviceWithdrawn(announced.key, "its bridge's list was removed") for announced in before.values()
            )
            return
        entries: list[object] = []
        for entry in parse_list(payload, MAX_BRIDGE_BYTES):
            entries.append(entry)
            if len(entries) > MAX_DEVICES:
                raise WireError(f"{topic}: it lists more than the limit of {MAX_DEVICES} devices")
            yield None
        devices: dict[str, DeviceAnnounced] = {}
        yield from self._describe_all(base, topic, entries, devices)
        self._devices[base] = devices
        listed = {ieee_address(entry) for entry in entries}
        yield from (_withdrawn(announced, ieee in listed) for ieee, announced in before.items() if ieee not in devices)
        yield from devices.values()
        yield from self._describe_groups(base, f"{base}/bridge/groups")

    def _describe_all(
        self, base: str, topic: str, entries: list[object], described: dict[str, DeviceAnnounced]
    ) -> Iterator[WireError | None]:
        """Describe the entries into *described*. A device with a broken entry retains its last description."""
        topics: set[str] = set()
        problems: list[WireError] = []
        room = MAX_PARTS
        listed = (as_fields(entry) for entry in entries)
        coordinators = (ieee_address(entry) for entry in listed if entry.get("type") == "Coordinator")
        via = f"zigbee2mqtt_bridge_{next(filter(None, coordinators), base)}"
        for entry in entries:
            yield None
            ieee = ieee_address(entry)
            try:
                device = _read(base, entry, topics, is_known=ieee in described, room=room)
            except WireError as error:
                problems.append(error)
                old = self._devices[base].get(ieee)
                if ieee in described or old is None or _topic_of(old) in topics:
                    continue
                described[ieee] = old
            else:
                if device.is_coordinator or device.is_disabled:
                    continue
                described[ieee] = self._describe(base, topic, device, via)
            topics.add(_topic_of(described[ieee]))
            room -= len(described[ieee].parts)
        if problems and not described:
            raise problems[0]
        self.rejected += len(problems)
        yield from problems

    def _describe(self, base: str, topic: str, device: BridgeDevice, via: str) -> DeviceAnnounced:
        self._endpoints[device.ieee], self._topics[device.ieee] = device.endpoint_names, device.topic
        self._exposed[device.ieee] = exposes_of_groups(device)
        described = DeviceAnnounced(
            key=device.ieee if base == _DEFAULT_BASE else f"{base}/{device.ieee}",
            convention="zigbee2mqtt",
            native=True,
            whole_device=True,
            identifiers=identifiers([device.ieee]),
            name=clean_text(device.name),
            parts=build_parts(device),
            topic=topic,
            facts={**device.facts, "via_device": via, "origin": "Zigbee2MQTT"},
            owns=tuple(dict.fromkeys((device.topic, f"{base}/{device.ieee}"))),
        )
        return self._with_settings(base, device.ieee, described)

    def _names_in(self, base: str, group: Mapping[str, object]) -> dict[str, None]:
        return dict.fromkeys(name for member in _members_of(group) for name in self._names_of(base, member))

    def _describe_groups(self, base: str, topic: str) -> Iterator[AnnouncementEvent | None]:
        """List all groups, and describe those of which all members are known, and have a feature in common."""
        groups = self._group_lists.get(base)
        if groups is None:
            return
        yield GroupsListed(topic, {_group_id(base, group): tuple(self._names_in(base, group)) for group in groups})
        before, groups_found = self._groups[base], dict[str, DeviceAnnounced]()
        for entry in groups:
            yield None
            try:
                described = self._describe_group(base, entry)
            except WireError:
                self.rejected += 1
                continue
            if described is not None:
                groups_found[described.key] = described
        self._groups[base] = groups_found
        listed = {_group_key(base, group) for group in groups}
        for key in before.keys() - groups_found.keys():
            why = "its bridge lists no such group of lamps, switches or covers"
            yield DeviceWithdrawn(key, why, is_final=key not in listed)
        yield from groups_found.values()

    def _describe_group(self, base: str, entry: Mapping[str, object]) -> DeviceAnnounced | None:
        members = [self._member(base, member) for member in _members_of(entry)]
        known = [member for member in members if member is not None]
        device, parts = build_group(base, entry, known if len(known) == len(members) else ())
        if not parts:
            return None
        names = tuple(self._names_in(base, entry))
        described = DeviceAnnounced(
            key=_group_key(base, entry),
            convention="zigbee2mqtt",
            native=True,
            whole_device=True,
            identifiers=(_group_id(base, entry),),
            name=clean_text(device.name),
            parts=tuple([as_group(part, names) for part in parts]),
            topic=f"{base}/bridge/groups",
            facts={"origin": "Zigbee2MQTT"},
            owns=(device.topic,),
        )
        return self._with_settings(base, "", described)

    def _member(self, base: str, member: Mapping[str, object]) -> GroupMember | None:
        """Return a member of a group; None if it is not known, or no light, switch or cover."""
        ieee = ieee_address(member)
        endpoint = self._endpoints.get(ieee, {}).get(str(member.get("endpoint")), "")
        exposed = self._exposed.get(ieee, {})
        exposes = exposed.get(endpoint) or exposed.get("")
        if not exposes or ieee not in self._devices[base]:
            return None
        topic = self._topics[ieee]
        return GroupMember(f"{topic}/{endpoint}" if endpoint in exposed and endpoint else topic, exposes)

    def _names_of(self, base: str, member: Mapping[str, object]) -> Iterator[str]:
        """Yield what a group calls a member: its device, or the parts of one of its endpoints."""
        ieee = ieee_address(member)
        device = self._devices[base].get(ieee)
        endpoint = self._endpoints.get(ieee, {}).get(str(member.get("endpoint")))
        parts = () if device is None or not endpoint else device.parts
        ids = [part.part.id for part in parts if part.part.id.endswith(f"_{endpoint}")]
        if device is not None and ids:
            yield from (f"{device.identifiers[0]}#{part_id}" for part_id in ids)
        elif ieee:
            yield from identifiers([ieee])

    def _with_settings(self, base: str, ieee: str, described: DeviceAnnounced) -> DeviceAnnounced:
        """Return *described* with the availability and the room that the bridge's settings give it."""
        settings = self._settings[base]
        return described._replace(
            availability=settings.availability(base, ieee, _topic_of(described)), area=settings.areas.get(ieee, "")
        )


def _members_of(group: Mapping[str, object]) -> list[Mapping[str, object]]:
    listed = group.get("members")
    return [as_fields(entry) for entry in listed[:MAX_DEVICES]] if isinstance(listed, list) else []


def _group_key(base: str, group: Mapping[str, object]) -> str:
    key = f"group/{group['id']}"
    return key if base == _DEFAULT_BASE else f"{base}/{key}"


def _group_id(base: str, group: Mapping[str, object]) -> str:
    """Return the identifier with which the bridge announces a group to Home Assistant."""
    coded = "".join(str(ord(letter)) for letter in base)
    return f"id:zigbee2mqtt_{coded}_{group['id']}"


def _read(base: str, entry: object, topics: set[str], *, is_known: bool, room: int) -> BridgeDevice:
    if not isinstance(entry, dict) or not ieee_address(entry):
        fields = as_fields(entry)
        named = f"{shown(fields['friendly_name'])}: " if "friendly_name" in fields else ""
        raise WireError(f"{named}ieee_address is {shown(fields.get('ieee_address', entry))}, not 0x and 16 digits")
    device = read_bridge_device(base, entry)
    if is_known or device.topic in topics:
        raise WireError(f"{device.ieee} or its friendly_name {shown(device.name)} occurs twice")
    if room <= 0:
        raise WireError(f"{device.ieee}: the devices before it already have {MAX_PARTS} parts, the limit")
    return device


def _topic_of(described: DeviceAnnounced) -> str:
    """Return the topic on which a device publishes."""
    return described.owns[0]


def _withdrawn(announced: DeviceAnnounced, is_listed: bool) -> DeviceWithdrawn:  # noqa: FBT001 - only called above
    if is_listed:
        return DeviceWithdrawn(announced.key, "it was disabled, or its name was taken")
    return DeviceWithdrawn(announced.key, "it left its bridge", is_final=True)
