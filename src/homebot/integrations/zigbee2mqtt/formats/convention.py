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
    from homebot.integrations.zigbee2mqtt.formats.reader import Zigbee2MqttReader


class Zigbee2MqttSettings(ConventionSettings):
    """The table of this convention.

    Attributes:
        bases: Base topics; a house with two bridges has two.
    """

    bases: tuple[TopicPrefix, ...] = ("zigbee2mqtt",)


class Zigbee2Mqtt(LazyConvention[Zigbee2MqttSettings, "Zigbee2MqttReader"]):
    """Discovery of Zigbee devices from ``bridge/devices``, and of their availability from ``bridge/info``.

    ``bridge/groups`` lists the groups. One of lamps, switches or covers is a device whose part has its members; others
    are known only if the bridge announces them to Home Assistant.

    The list is one message of at most 5,000 devices. Each device is one :class:`DeviceAnnounced`; a device that is
    missing in a later list is :class:`DeviceWithdrawn`. The key is the device's address, after the base if that is not
    ``zigbee2mqtt``, so a renamed device keeps its key and gets new topics. The coordinator and disabled devices are
    not described.
    """

    Settings: ClassVar[type[BaseModel]] = Zigbee2MqttSettings
    name: ClassVar[str] = "zigbee2mqtt"

    def filters(self) -> tuple[str, ...]:
        """Return the topics of the settings, then of the lists, each of which depends on the one before."""
        topics = ("info", "devices", "groups")
        return tuple(f"{base}/bridge/{topic}" for base in self.settings.bases for topic in topics)

    def reserved(self) -> tuple[str, ...]:
        """Return the bridges' own topics."""
        return tuple(f"{base}/bridge/#" for base in self.settings.bases)

    def problems(self) -> tuple[str, ...]:
        """Return the bridges with a missing list, or with an unsupported form of states."""
        return self.reader.problems() if self.is_loaded else ()

    def read_message_in_slices(
        self, topic: str, payload: bytes, *, retained: bool
    ) -> Iterator[AnnouncementEvent | None]:
        """Read a message in steps: a list of hundreds of devices needs a second."""
        try:
            yield from self.reader.read_message_in_slices(topic, payload, retained=retained)
        except WireError:
            self.reader.rejected += 1
            raise

    def load_reader(self) -> Zigbee2MqttReader:
        """Return a reader of the bridges' messages."""
        from homebot.integrations.zigbee2mqtt.formats.reader import Zigbee2MqttReader  # noqa: PLC0415 - see LazyConvention

        return Zigbee2MqttReader(self.settings.bases)
