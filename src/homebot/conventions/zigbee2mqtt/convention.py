"""Zigbee2MQTT's own messages as a convention. Pure.

Source: zigbee2mqtt.io, Usage > MQTT topics and messages; Zigbee2MQTT 2.14.1.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, ClassVar

from pydantic import BaseModel

from homebot.conventions.convention import ConventionSettings, LazyConvention, TopicPrefix
from homebot.conventions.description import AnnouncementEvent
from homebot.errors import WireError

if TYPE_CHECKING:
    from homebot.conventions.zigbee2mqtt.reader import Zigbee2MqttReader

__all__ = ["Zigbee2Mqtt", "Zigbee2MqttSettings"]


class Zigbee2MqttSettings(ConventionSettings):
    """The table of this convention.

    Attributes:
        bases: Base topics; a house with two bridges has two.
    """

    bases: tuple[TopicPrefix, ...] = ("zigbee2mqtt",)


class Zigbee2Mqtt(LazyConvention[Zigbee2MqttSettings, "Zigbee2MqttReader"]):
    """Understands ``bridge/devices`` and, for availability alone, ``bridge/info`` of each bridge.

    The list is one message. Each of its devices is one :class:`DeviceAnnounced`, and one that is missing from a later
    list is :class:`DeviceWithdrawn`. The key is the device's address, with the base before it where that is not
    ``zigbee2mqtt``; so a device that is renamed keeps its key and gets new topics. The coordinator, which is the
    bridge's own radio, and devices that the user disabled are not described. Groups are not either: they are no
    devices, and their lamps are already there, each by itself.

    It keeps the descriptions of the last list per bridge, at most 5,000 devices; a longer list is refused.
    """

    Settings: ClassVar[type[BaseModel]] = Zigbee2MqttSettings
    name: ClassVar[str] = "zigbee2mqtt"

    def filters(self) -> tuple[str, ...]:
        """Return the topics of the lists, after those of what says how to read them."""
        return tuple(f"{base}/bridge/{topic}" for base in self.settings.bases for topic in ("info", "devices"))

    def reserved(self) -> tuple[str, ...]:
        """Return what the bridges themselves take and publish."""
        return tuple(f"{base}/bridge/#" for base in self.settings.bases)

    def problems(self) -> tuple[str, ...]:
        """Return which bridges do not say which devices they have, or publish states in a form that is not read."""
        return self.reader.problems() if self.is_loaded else ()

    def read_message_in_slices(
        self, topic: str, payload: bytes, *, retained: bool
    ) -> Iterator[AnnouncementEvent | None]:
        """Do what :meth:`read_message` does, in steps: the list of a house of hundreds takes a second."""
        try:
            yield from self.reader.read_message_in_slices(topic, payload, retained=retained)
        except WireError:
            self.reader.rejected += 1
            raise

    def load_reader(self) -> Zigbee2MqttReader:
        """Return a reader of what bridges publish."""
        from homebot.conventions.zigbee2mqtt.reader import Zigbee2MqttReader  # noqa: PLC0415 - see LazyConvention

        return Zigbee2MqttReader(self.settings.bases)
