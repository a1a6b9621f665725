"""Home Assistant's MQTT discovery as a convention: configs in, descriptions out. Pure.

Source: Home Assistant core 2025.4 to 2026.11, ``components/mqtt``.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, ClassVar, TypeAlias

from pydantic import BaseModel, ConfigDict, Field

from homebot.conventions.description import (
    AnnouncementEvent,
    DescribedPart,
    DeviceAnnounced,
    DeviceWithdrawn,
    Publication,
)
from homebot.conventions.homeassistant.announcement import Announced, AnnouncedComponent, read_announcement
from homebot.conventions.homeassistant.components import BUILDERS
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.device import DeviceInfo, DeviceReader, read_availability
from homebot.conventions.homeassistant.publisher import HomeAssistantPublisher
from homebot.conventions.homeassistant.topics import DEVICE, ConfigTopic, parse_config_topic
from homebot.conventions.payload import clean_text
from homebot.errors import WireError

__all__ = ["HomeAssistantDiscovery", "HomeAssistantSettings"]

_Prefix = Annotated[str, Field(min_length=1, max_length=200, pattern=r"^[^+#\x00]*[^+#\x00/]$")]


class HomeAssistantSettings(BaseModel):
    """The table of this convention.

    Attributes:
        prefixes: Discovery prefixes; two programs in one house may use different ones.
        announce_please: Whether to publish what Home Assistant publishes at its start, so that devices announce
            themselves anew. A real Home Assistant in the house, and all that listens to it, hears that as well.
        publish: Whether what homebot offers is published below the first prefix, for a Home Assistant to see.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    prefixes: tuple[_Prefix, ...] = ("homeassistant",)
    announce_please: bool = False
    publish: bool = False


class HomeAssistantDiscovery:
    """Understands configs below the discovery prefixes, each by itself.

    Each config message is one :class:`DeviceAnnounced`; those of one device share its identifiers. A later message with
    the same component and ids takes the place of the earlier one, and a component of a whole-device message that is
    missing there later is gone.

    What a part has no field for is a fact of the device: ``hidden PART``, where it is not shown by default, and
    ``group PART``, the ids of those that a group commands together.

    Args:
        settings: Its table.
    """

    Settings: ClassVar[type[BaseModel]] = HomeAssistantSettings
    name: ClassVar[str] = "homeassistant"

    def __init__(self, settings: HomeAssistantSettings) -> None:
        self.rejected = 0
        self._settings = settings
        self._devices = DeviceReader()

    def filters(self) -> tuple[str, ...]:
        """Return the filters of configs: two per component, because one for all loses retained messages."""
        return tuple(
            f"{prefix}/{component}/{levels}/config"
            for prefix in self._settings.prefixes
            for levels in ("+", "+/+")
            for component in (*BUILDERS, DEVICE)
        )

    def reserved(self) -> tuple[str, ...]:
        """Return where Home Assistant says that it is there, on which many devices act."""
        return tuple(f"{prefix}/status" for prefix in self._settings.prefixes)

    def birth_messages(self) -> tuple[Publication, ...]:
        """Return Home Assistant's birth message per prefix, where the settings want it."""
        if not self._settings.announce_please:
            return ()
        return tuple(Publication(f"{prefix}/status", b"online") for prefix in self._settings.prefixes)

    def take(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:  # noqa: ARG002 - a config counts as much when it was kept
        """Take a config and return what it tells of its device."""
        try:
            return self._taken(topic, payload)
        except WireError:
            self.rejected += 1
            raise

    def publisher(self, owner: str, status_topic: str) -> HomeAssistantPublisher | None:
        """Return what publishes the offers of the homebot *owner*; None where the settings do not want it."""
        if not self._settings.publish or not self._settings.prefixes:
            return None
        return HomeAssistantPublisher(self._settings.prefixes[0], owner, status_topic)

    def _taken(self, topic: str, payload: bytes) -> tuple[AnnouncementEvent, ...]:
        where = self._where(topic)
        if where is None or (where.component != DEVICE and where.component not in BUILDERS):
            return ()
        if not payload:
            return (DeviceWithdrawn(where.key, "its config was removed"),)
        announced = read_announcement(where, payload)
        if announced.is_migrating:
            return (DeviceWithdrawn(where.key, "it changes to another form of announcement"),)
        parts = self._parts(where, announced)
        if not parts:
            return (DeviceWithdrawn(where.key, "no component of it is left"),)
        device = self._devices.read(announced.device, announced.origin)
        return (_described(topic, where, announced, device, parts),)

    def _where(self, topic: str) -> ConfigTopic | None:
        for prefix in self._settings.prefixes:
            where = parse_config_topic(prefix, topic)
            if where is not None:
                return where
        return None

    def _parts(self, where: ConfigTopic, announced: Announced) -> _Parts:
        """Build the parts. In a message of a whole device a broken component costs that component alone."""
        parts: _Parts = {}
        broken: WireError | None = None
        for component in announced.components:
            builder = BUILDERS.get(component.platform)
            if builder is None:
                continue
            config = DiscoveryConfig(component.platform, component.discovery_id, component.fields)
            try:
                part = builder(config)
                if where.component == DEVICE:
                    part = replace(part, availability=read_availability(config))
            except WireError as error:
                if where.component != DEVICE:
                    raise
                self.rejected += 1
                broken = error
                continue
            if part.part.id in parts:
                part = replace(part, part=part.part.model_copy(update={"id": component.discovery_id}))
            parts[part.part.id] = part, component
        if broken is not None and not parts:
            self.rejected -= 1
            raise broken
        return parts


_Parts: TypeAlias = dict[str, tuple[DescribedPart, AnnouncedComponent]]
_MAX_MEMBERS = 100


def _described(
    topic: str, where: ConfigTopic, announced: Announced, device: DeviceInfo, parts: _Parts
) -> DeviceAnnounced:
    whole = read_availability(DiscoveryConfig(where.component, where.object_id, announced.common))
    described = tuple([part for part, _ in parts.values()])
    if whole is None and described and all(one.availability == described[0].availability for one in described):
        whole = described[0].availability
    if whole is not None:
        described = tuple([replace(one, availability=None) if one.availability == whole else one for one in described])
    return DeviceAnnounced(
        key=where.key,
        convention=HomeAssistantDiscovery.name,
        identifiers=device.identifiers,
        name=device.name or described[0].part.name or clean_text(where.object_id),
        parts=described,
        topic=topic,
        area=device.area,
        facts={**device.facts, **_facts(parts)},
        availability=whole,
    )


def _facts(parts: _Parts) -> dict[str, str]:
    """Return what is known of parts and has no field there: that one is hidden, and whom a group stands for."""
    facts = {}
    for part_id, (_, component) in parts.items():
        if component.fields.get("enabled_by_default") is False:
            facts[f"hidden {part_id}"] = "by default"
        members = component.fields.get("group")
        if isinstance(members, list) and members:
            named = [clean_text(one) for one in members[:_MAX_MEMBERS] if isinstance(one, str)]
            facts[f"group {part_id}"] = " ".join(named)
    return facts
