"""Home Assistant's MQTT discovery as a convention. Pure.

Source: Home Assistant core 2025.4 to 2026.11, ``components/mqtt``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal

from pydantic import BaseModel

from homebot.conventions.convention import ConventionSettings, LazyConvention, TopicPrefix
from homebot.conventions.description import Publication, Publications
from homebot.integrations.homeassistant.formats.components import COMPONENTS

if TYPE_CHECKING:
    from homebot.integrations.homeassistant.formats.publisher import HomeAssistantPublisher
    from homebot.integrations.homeassistant.formats.reader import HomeAssistantReader


class HomeAssistantSettings(ConventionSettings):
    """The table of this convention.

    Attributes:
        prefixes: Discovery prefixes; two programs in one house may use different ones.
        announce_please: Whether to publish Home Assistant's birth message, so that devices announce themselves again.
            A real Home Assistant and all other subscribers receive it as well.
        temperature_unit: The unit of climate devices that announce none. For Home Assistant it is its own.
        publish: Whether exposed devices are published below the first prefix, for a Home Assistant to discover.
    """

    prefixes: tuple[TopicPrefix, ...] = ("homeassistant",)
    announce_please: bool = False
    temperature_unit: Literal["C", "F"] = "C"
    publish: bool = False


class HomeAssistantDiscovery(LazyConvention[HomeAssistantSettings, "HomeAssistantReader"]):
    """Discovery of devices from configs below the discovery prefixes.

    Each config is one :class:`DeviceAnnounced`; those of one device share its identifiers. A later config replaces the
    one with the same component and ids; a component that is missing in the later config of a whole device is removed.

    A part that is not shown by default is a fact of the device: ``hidden PART``.
    """

    Settings: ClassVar[type[BaseModel]] = HomeAssistantSettings
    name: ClassVar[str] = "homeassistant"
    has_codes: ClassVar[Literal[True]] = True

    def filters(self) -> tuple[str, ...]:
        """Return the filters of configs: two per component, because one for all loses retained messages."""
        return tuple(
            f"{prefix}/{component}/{levels}/config"
            for prefix in self.settings.prefixes
            for levels in ("+", "+/+")
            for component in COMPONENTS
        )

    def reserved(self) -> tuple[str, ...]:
        """Return the status topic of Home Assistant, to which many devices react."""
        return tuple(f"{prefix}/status" for prefix in self.settings.prefixes)

    def birth_messages(self) -> Publications:
        """Return Home Assistant's birth message per prefix, if it is enabled."""
        if not self.settings.announce_please:
            return ()
        return tuple(Publication(f"{prefix}/status", b"online") for prefix in self.settings.prefixes)

    def publisher(self, owner: str, status_topic: str) -> HomeAssistantPublisher | None:
        """Return the publisher of the homebot *owner*; None if it is disabled."""
        if not self.settings.publish or not self.settings.prefixes:
            return None
        from homebot.integrations.homeassistant.formats.publisher import HomeAssistantPublisher  # noqa: PLC0415 - few want it

        return HomeAssistantPublisher(self.settings.prefixes[0], owner, status_topic)

    def load_reader(self) -> HomeAssistantReader:
        """Return a reader of configs."""
        from homebot.integrations.homeassistant.formats.reader import HomeAssistantReader  # noqa: PLC0415 - see LazyConvention

        return HomeAssistantReader(self.settings.prefixes, is_fahrenheit=self.settings.temperature_unit == "F")
