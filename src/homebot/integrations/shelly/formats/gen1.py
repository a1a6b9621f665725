"""Devices of Shelly's first generation: their announcements and descriptions. Pure.

The parts of a device follow from its model and mode, and from its other published topics. It announces itself on two
topics at once; equal announcements count once. A device without announcement is described after it reported that it is
online and published a known topic.

Source: Shelly Gen1 API, MQTT; iobroker.shelly 12.0.
"""

import re
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field

from homebot.conventions.bounded_dict import BoundedDict
from homebot.conventions.description import (
    AnnouncementEvent,
    Availability,
    DeviceAnnounced,
    DeviceWithdrawn,
    LastWillAvailability,
)
from homebot.conventions.payload import clean_text, parse_object, shown, text_of
from homebot.devices.identity import identifiers, in_pairs
from homebot.errors import WireError
from homebot.integrations.shelly.formats.gen1_parts import (
    NO_VALVE,
    Gen1Model,
    Presses,
    build_parts,
    find_model,
    is_known_topic,
)


@dataclass(slots=True)
class _Gen1Device:
    """The messages of one device so far.

    Attributes:
        model: Its model by name or announcement.
        suffixes: Its published topics, below its own.
        mode: Its mode, if the model has several.
        announced: The facts of its last announcement.
        described_by: The topic of its first description.
        presses: Filters of its inputs, at most 16.
    """

    name: str
    model: Gen1Model
    suffixes: set[str] = field(default_factory=set)
    mac: str = ""
    mode: str = ""
    announced: dict[str, str] = field(default_factory=dict)
    is_announced: bool = False
    is_online: bool = False
    described_by: str = ""
    presses: defaultdict[int, Presses] = field(default_factory=lambda: defaultdict(Presses))

    @property
    def topic(self) -> str:
        return f"shellies/{self.name}"

    def announce(self, device_id: str, mac: str, announcement: Mapping[str, object]) -> bool:
        """Record an announcement; return whether it differs from the last one."""
        before = self.mac, self.mode, self.announced
        mode = announcement.get("mode")
        self.mac, self.mode = mac, mode if isinstance(mode, str) else ""
        self.announced = {
            "model": text_of(announcement.get("model"), 40),
            "sw_version": text_of(announcement.get("fw_ver")),
            "ip_address": text_of(announcement.get("ip")),
        }
        self.model = find_model(self.announced["model"], device_id)
        return (self.mac, self.mode, self.announced) != before

    def known(self) -> frozenset[str]:
        """Return its published topics: those of its model and mode, and those seen."""
        model = self.model
        mode = model.modes.get(self.mode)
        if mode is None:
            return model.topics | self.suffixes
        others = {kind for topics in model.modes.values() for kind in map(_kind, topics)}
        wrong = others - set(map(_kind, mode)) - {"input", "input_event"}
        return model.topics | mode | {suffix for suffix in self.suffixes if _kind(suffix) not in wrong}

    def describe(self, topic: str) -> DeviceAnnounced:
        """Return its description, perhaps without parts; *topic* is that of its last message."""
        own_id = self.name if _HARDWARE_ID.fullmatch(self.name) else ""
        model = {"manufacturer": "Shelly", "model": self.model.name}
        facts = {name: fact for name, fact in {**self.announced, "mode": clean_text(self.mode, 20)}.items() if fact}
        will = LastWillAvailability(f"{self.topic}/online", b"true", b"false")
        # Another program may have each channel as a device of its own. Source: Home Assistant core 2026.1,
        # components/shelly/utils.py: get_block_device_info
        blocks = sorted({_BLOCKS[match[1]] + match[2] for match in map(_BLOCK.match, self.known()) if match})
        channels = [f"shelly:{self.mac.upper()}-{block}" for block in blocks] if self.mac and len(blocks) > 1 else []
        return DeviceAnnounced(
            key=self.topic,
            convention="shelly",
            native=True,
            whole_device=True,
            identifiers=identifiers((in_pairs(self.mac), own_id, *channels)),
            name=clean_text(self.name),
            parts=build_parts(self.topic, self.model, self.known(), self.presses),
            topic=self.described_by or topic,
            facts={name: fact for name, fact in {**model, **facts}.items() if fact},
            availability=None if self.model.sleeps else Availability((will,)),
            owns=(self.topic,),
            implies_alive=True,
        )


_HARDWARE_ID = re.compile(r"shelly[a-z0-9-]*-(?:[0-9a-f]{6}|[0-9a-f]{12})", re.IGNORECASE)
_BLOCKS = {"relay": "relay_", "emeter": "emeter_", **dict.fromkeys(("light", "white", "color"), "light_")}
"""Topics of channels, with the names of their blocks in CoIoT."""

_BLOCK = re.compile(rf"({'|'.join(_BLOCKS)})/([0-9])(?:/|$)")


def _kind(suffix: str) -> str:
    return suffix.partition("/")[0]


_MAX_DEVICES = 5000
_MAX_NAME_CHARACTERS = 100
_DEVICE_ID = re.compile(r"[^+#/\0]{1,100}")
_NO_NAMES = frozenset({"announce", "command"})
_LEVELS = 3


class Gen1:
    """Registry of the devices of the first generation; of more than 5,000 the oldest undescribed one is dropped."""

    def __init__(self) -> None:
        self._devices: BoundedDict[_Gen1Device] = BoundedDict(_MAX_DEVICES)
        self._names: dict[str, str] = {}

    @property
    def dropped(self) -> int:
        """Number of dropped devices."""
        return self._devices.dropped

    def read_message(self, topic: str, payload: bytes) -> tuple[AnnouncementEvent, ...]:
        """Read a message below ``shellies/``.

        Raises:
            WireError: An announcement breaks the rules.
        """
        levels = topic.split("/", 2)
        if topic == "shellies/announce":
            return self._announced(topic, "", payload)
        if len(levels) < _LEVELS or levels[1] in _NO_NAMES or not 0 < len(levels[1]) <= _MAX_NAME_CHARACTERS:
            return ()
        _, name, suffix = levels
        if suffix == "announce":
            return self._announced(topic, name, payload) if payload else ()
        if suffix == "online":
            if payload == b"false" or not payload:
                return ()
            device = self._device(name)
            if device is None or device.is_online:
                return ()
            device.is_online = True
            return () if device.is_announced else self._described(device, topic)
        if payload in {b"", NO_VALVE} or not is_known_topic(suffix):
            return ()
        return self._on_state(topic, name, suffix)

    def _on_state(self, topic: str, name: str, suffix: str) -> tuple[AnnouncementEvent, ...]:
        device = self._device(name)
        if device is None or suffix in device.suffixes:
            return ()
        known = device.known()
        device.suffixes.add(suffix)
        is_news = device.known() != known or not device.described_by
        return self._described(device, topic) if is_news else ()

    def _announced(self, topic: str, name: str, payload: bytes) -> tuple[AnnouncementEvent, ...]:
        announcement = parse_object(payload)
        device_id, mac = _ids(announcement)
        if not name and mac:
            name = self._names.get(mac, "")
        device = self._device(name or device_id)
        if device is None:
            return ()
        gone: tuple[AnnouncementEvent, ...] = ()
        before = self._names.get(mac)
        if mac and (before is not None or len(self._names) < _MAX_DEVICES):
            self._names[mac] = device.name
            if before not in {None, device.name} and self._devices.remove(before) is not None:
                gone = (DeviceWithdrawn(f"shellies/{before}", f"it has been renamed {device.name}"),)
        is_news = device.announce(device_id, mac, announcement)
        if not device.is_announced:
            device.is_announced, device.described_by = True, topic
        elif not gone and topic != device.described_by and not is_news:
            return ()
        return gone + self._described(device, topic)

    def _device(self, name: str) -> _Gen1Device | None:
        return self._devices.find(name, lambda: _Gen1Device(name, find_model("", name)))

    def _described(self, device: _Gen1Device, topic: str) -> tuple[AnnouncementEvent, ...]:
        if not (device.is_announced or device.is_online):
            return ()
        described = device.describe(topic)
        if not described.parts:
            return ()
        self._devices.pin(device.name)
        device.described_by = described.topic
        return (described,)


def _ids(announcement: Mapping[str, object]) -> tuple[str, str]:
    device_id, mac = announcement.get("id"), announcement.get("mac", "")
    if not isinstance(device_id, str) or not _DEVICE_ID.fullmatch(device_id):
        raise WireError(f"an announcement has the invalid id {shown(device_id)}")
    if not isinstance(mac, str):
        raise WireError(f"an announcement has the invalid mac {shown(mac)}")
    return device_id, clean_text(mac, 20)
