"""Reader of Tasmota's announcements: two messages of a device in, one description out. Pure.

Source: Tasmota 14.4 firmware, ``xdrv_12_discovery.ino``; hatasmota 0.10.2.
"""

import re
from typing import NamedTuple

from homebot.conventions.description import (
    AnnouncementEvent,
    Availability,
    DeviceAnnounced,
    DeviceWithdrawn,
    LastWillAvailability,
)
from homebot.conventions.payload import parse_object
from homebot.devices.identity import identifiers, in_pairs
from homebot.errors import WireError
from homebot.integrations.tasmota.formats.config import TasmotaConfig, read_config
from homebot.integrations.tasmota.formats.parts import build_parts
from homebot.integrations.tasmota.formats.sensors import Leaf, read_leaves
from homebot.support.bounded_map import BoundedMap

MAX_DEVICES = 5_000
"""Most devices; the announcement of one more is refused."""

MAX_WAITING = 1_000
"""Most devices with ``sensors`` and without ``config``; the oldest is dropped and counted."""


class _KnownTasmota(NamedTuple):
    config: TasmotaConfig
    leaves: tuple[Leaf, ...]
    device: DeviceAnnounced


class TasmotaReader:
    """Reader of both messages of each device.

    A device is :class:`DeviceAnnounced` with its ``config``, and again with its ``sensors``, which wait for the
    ``config``. An unchanged ``config`` gives the same description, with the same codecs and their last values. At most
    :data:`MAX_DEVICES` are stored, and at most :data:`MAX_WAITING` wait.

    Attributes:
        forgotten: Number of dropped devices without ``config``.
    """

    def __init__(self, prefix: str) -> None:
        self.rejected = 0
        self.forgotten = 0
        self._prefix = prefix
        self._waiting: BoundedMap[str, tuple[Leaf, ...]] = BoundedMap(MAX_WAITING)
        self._known: dict[str, _KnownTasmota] = {}
        self._probes: BoundedMap[str, dict[str, str]] = BoundedMap(MAX_DEVICES)

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:  # noqa: ARG002 - announcements are retained
        """Return the description of a device; nothing before its ``config``."""
        match = _TOPIC.fullmatch(topic.removeprefix(f"{self._prefix}/"))
        if match is None or not topic.startswith(f"{self._prefix}/"):
            return ()
        mac, kind = match.groups()
        if kind == "config":
            known = self._known.get(mac)
            if not payload:
                self._known.pop(mac, None)
                return () if known is None else (DeviceWithdrawn(mac, "its config was removed"),)
            config = read_config(mac, payload)
            if known is not None:
                return (known.device,) if config == known.config else self._announce(mac, config, known.leaves)
            if len(self._known) >= MAX_DEVICES:
                raise WireError(f"{mac} exceeds the limit of {MAX_DEVICES} devices")
            return self._announce(mac, config, self._waiting.pop(mac, ()))
        self._probes[mac] = probes = self._probes.get(mac, {})
        leaves = read_leaves(parse_object(payload), probes) if payload else ()
        known = self._known.get(mac)
        if known is not None:
            return () if leaves == known.leaves else self._announce(mac, known.config, leaves)
        if len(self._waiting) == MAX_WAITING and mac not in self._waiting:
            self.forgotten += 1
        self._waiting[mac] = leaves
        return ()

    def _announce(self, mac: str, config: TasmotaConfig, leaves: tuple[Leaf, ...]) -> tuple[AnnouncementEvent, ...]:
        will = LastWillAvailability(f"{config.telemetry_base}LWT", config.online.encode(), config.offline.encode())
        device = DeviceAnnounced(
            key=mac,
            convention="tasmota",
            native=True,
            whole_device=True,
            identifiers=identifiers([in_pairs(mac)]),
            name=config.name,
            parts=build_parts(config, leaves),
            topic=f"{self._prefix}/{mac}/config",
            facts=config.facts,
            availability=None if config.is_sleeper else Availability((will,)),
            owns=config.own_topics,
        )
        self._known[mac] = _KnownTasmota(config, leaves, device)
        return (device,)


_TOPIC = re.compile("([0-9A-F]{12})/(config|sensors)")
