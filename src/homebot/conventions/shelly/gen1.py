"""Shelly's first generation: who announces itself, and what is heard below ``shellies/``. Pure.

A device's model and mode say what it consists of; what it is heard to publish besides is added. It announces itself
on two topics at once, of which one counts where both say the same. One that does not announce itself is known once it
says that it is online and has published something known.

Source: Shelly Gen1 API, MQTT; iobroker.shelly 12.0.
"""

from __future__ import annotations

from homebot.conventions.bounded_dict import BoundedDict
from homebot.conventions.description import AnnouncementEvent, DeviceWithdrawn
from homebot.conventions.payload import clean_text, parse_object, shown
from homebot.conventions.shelly.gen1_device import Gen1Device
from homebot.conventions.shelly.gen1_models import find_model
from homebot.conventions.shelly.gen1_parts import is_known_topic
from homebot.conventions.shelly.gen1_topics import Gen1Topics
from homebot.errors import WireError

__all__ = ["Gen1"]

_MAX_DEVICES = 5000
_LONGEST_NAME = 100
_NO_NAMES = frozenset({"announce", "command"})
_LEVELS = 3


class Gen1:
    """Knows the devices of the first generation in one broker.

    There is room for 5,000: of more, the one that was named first and never described is forgotten.
    """

    def __init__(self) -> None:
        self._devices: BoundedDict[Gen1Device] = BoundedDict(_MAX_DEVICES)
        self._names: dict[str, str] = {}

    @property
    def dropped(self) -> int:
        """Number of devices that were forgotten or not taken for want of room."""
        return self._devices.dropped

    def take(self, topic: str, payload: bytes) -> tuple[AnnouncementEvent, ...]:
        """Take a message below ``shellies/``.

        Raises:
            WireError: An announcement breaks the rules.
        """
        levels = topic.split("/", 2)
        if topic == "shellies/announce":
            return self._announced(topic, "", payload)
        if len(levels) < _LEVELS or levels[1] in _NO_NAMES or not 0 < len(levels[1]) <= _LONGEST_NAME:
            return ()
        _, name, suffix = levels
        if suffix == "announce":
            return self._announced(topic, name, payload) if payload else ()
        if suffix == "online":
            return self._online(topic, name, payload)
        return self._take_state(topic, name, suffix) if payload and is_known_topic(suffix) else ()

    def _announced(self, topic: str, name: str, payload: bytes) -> tuple[AnnouncementEvent, ...]:
        announcement = parse_object(payload)
        device_id, mac = announcement.get("id"), announcement.get("mac", "")
        if not isinstance(device_id, str) or not 0 < len(device_id) <= _LONGEST_NAME or set(device_id) & set("+#/\0"):
            raise WireError(f"an announcement has the id {shown(device_id)}")
        if not isinstance(mac, str):
            raise WireError(f"an announcement has the mac {shown(mac)}")
        mac = clean_text(mac, 20)
        if not name and mac and mac in self._names:
            name = self._names[mac]
        device = self._device(name or device_id)
        if device is None:
            return ()
        gone = self._renamed(mac, device.topics.name)
        is_news = device.announce(device_id, mac, announcement)
        if not device.is_announced:
            device.is_announced, device.topic = True, topic
        elif not gone and topic != device.topic and not is_news:
            return ()
        return gone + self._described(device, topic)

    def _online(self, topic: str, name: str, payload: bytes) -> tuple[AnnouncementEvent, ...]:
        if payload == b"false" or not payload:
            return ()
        device = self._device(name)
        if device is None or device.is_online:
            return ()
        device.is_online = True
        return () if device.is_announced else self._described(device, topic)

    def _take_state(self, topic: str, name: str, suffix: str) -> tuple[AnnouncementEvent, ...]:
        device = self._device(name)
        if device is None or suffix in device.suffixes:
            return ()
        known = device.known()
        device.suffixes.add(suffix)
        is_news = device.known() != known or not device.topic
        return self._described(device, topic) if is_news else ()

    def _device(self, name: str) -> Gen1Device | None:
        device = self._devices.get(name)
        if device is None:
            device = Gen1Device(Gen1Topics(name), find_model("", name))
            if not self._devices.add(name, device):
                return None
        return device

    def _renamed(self, mac: str, name: str) -> tuple[AnnouncementEvent, ...]:
        if not mac:
            return ()
        before = self._names.get(mac)
        if before is None and len(self._names) >= _MAX_DEVICES:
            return ()
        self._names[mac] = name
        if before is None or before == name or self._devices.remove(before) is None:
            return ()
        return (DeviceWithdrawn(f"shellies/{before}", f"it is called {name} now"),)

    def _described(self, device: Gen1Device, topic: str) -> tuple[AnnouncementEvent, ...]:
        if not (device.is_announced or device.is_online):
            return ()
        described = device.describe(topic)
        if not described.parts:
            return ()
        self._devices.keep(device.topics.name)
        device.topic = described.topic
        return (described,)
