"""W3C Thing Descriptions on MQTT topics as a convention. Pure.

``homebot import`` puts a description, retained, on ``homebot/things/NAME/td``; descriptions of other programs
there are read as well. The empty payload takes it back.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from pydantic import BaseModel

from homebot.conventions.convention import ConventionSettings, LazyConvention, TopicPrefix

if TYPE_CHECKING:
    from homebot.integrations.things.formats.mqtt.reader import ThingReader


class ThingSettings(ConventionSettings):
    """The table of this convention.

    Attributes:
        prefixes: Descriptions are looked for on ``PREFIX/NAME/td``.
    """

    prefixes: tuple[TopicPrefix, ...] = ("homebot/things",)


class ThingDescriptions(LazyConvention[ThingSettings, "ThingReader"]):
    """Understands Thing Descriptions; keeps nothing between messages.

    Forms of other protocols than MQTT, or with payloads that are neither JSON nor text, are passed over:
    such a part is there, and cannot be read or set.
    """

    Settings: ClassVar[type[BaseModel]] = ThingSettings
    name: ClassVar[str] = "thing"

    def filters(self) -> tuple[str, ...]:
        """Return where descriptions are."""
        return tuple(f"{prefix}/+/td" for prefix in self.settings.prefixes)

    def load_reader(self) -> ThingReader:
        """Return a reader of descriptions."""
        from homebot.integrations.things.formats.mqtt.reader import ThingReader  # noqa: PLC0415 - see LazyConvention

        return ThingReader(self.settings.prefixes)
