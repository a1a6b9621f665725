"""Home Assistant's MQTT discovery as a convention. Pure.

Source: Home Assistant core 2025.4 to 2026.11, ``components/mqtt``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from pydantic import BaseModel

from homebot.conventions.convention import ConventionSettings, LazyConvention, TopicPrefix
from homebot.conventions.description import Publication, Publications

if TYPE_CHECKING:
    from homebot.conventions.homeassistant.publisher import HomeAssistantPublisher
    from homebot.conventions.homeassistant.reader import HomeAssistantReader

__all__ = ["COMPONENTS", "HomeAssistantDiscovery", "HomeAssistantSettings"]

COMPONENTS = (
    *("alarm_control_panel", "binary_sensor", "button", "camera", "climate", "cover", "date", "datetime"),
    *("device_automation", "device_tracker", "event", "fan", "humidifier", "image", "lawn_mower", "light", "lock"),
    *("notify", "number", "scene", "select", "sensor", "siren", "switch", "tag", "text", "time", "update", "vacuum"),
    *("valve", "water_heater", "device"),
)
"""What configs may be of: one of the components that have a builder, or a whole device."""


class HomeAssistantSettings(ConventionSettings):
    """The table of this convention.

    Attributes:
        prefixes: Discovery prefixes; two programs in one house may use different ones.
        announce_please: Whether to publish what Home Assistant publishes at its start, so that devices announce
            themselves anew. A real Home Assistant in the house, and all that subscribes to it, receives that as well.
        publish: Whether what homebot offers is published below the first prefix, for a Home Assistant to see.
    """

    prefixes: tuple[TopicPrefix, ...] = ("homeassistant",)
    announce_please: bool = False
    publish: bool = False


class HomeAssistantDiscovery(LazyConvention[HomeAssistantSettings, "HomeAssistantReader"]):
    """Understands configs below the discovery prefixes, each by itself.

    Each config message is one :class:`DeviceAnnounced`; those of one device share its identifiers. A later message with
    the same component and ids takes the place of the earlier one, and a component of a whole-device message that is
    missing there later is gone.

    What a part has no field for is a fact of the device: ``hidden PART``, where it is not shown by default, and
    ``group PART``, the ids of those that a group commands together.
    """

    Settings: ClassVar[type[BaseModel]] = HomeAssistantSettings
    name: ClassVar[str] = "homeassistant"

    def filters(self) -> tuple[str, ...]:
        """Return the filters of configs: two per component, because one for all loses retained messages."""
        return tuple(
            f"{prefix}/{component}/{levels}/config"
            for prefix in self.settings.prefixes
            for levels in ("+", "+/+")
            for component in COMPONENTS
        )

    def reserved(self) -> tuple[str, ...]:
        """Return where Home Assistant says that it is there, on which many devices act."""
        return tuple(f"{prefix}/status" for prefix in self.settings.prefixes)

    def birth_messages(self) -> Publications:
        """Return Home Assistant's birth message per prefix, where the settings want it."""
        if not self.settings.announce_please:
            return ()
        return tuple(Publication(f"{prefix}/status", b"online") for prefix in self.settings.prefixes)

    def publisher(self, owner: str, status_topic: str) -> HomeAssistantPublisher | None:
        """Return what publishes the offers of the homebot *owner*; None where the settings do not want it."""
        if not self.settings.publish or not self.settings.prefixes:
            return None
        from homebot.conventions.homeassistant.publisher import HomeAssistantPublisher  # noqa: PLC0415 - few want it

        return HomeAssistantPublisher(self.settings.prefixes[0], owner, status_topic)

    def load_reader(self) -> HomeAssistantReader:
        """Return a reader of configs."""
        from homebot.conventions.homeassistant.reader import HomeAssistantReader  # noqa: PLC0415 - see LazyConvention

        return HomeAssistantReader(self.settings.prefixes)
