"""The Homie convention, versions 3, 4 and 5. Pure.

Source: Homie convention 5 (homieiot/convention, develop of October 2024), 4.0.0 and 3.0.1.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import BaseModel, Field

from homebot.conventions.convention import ConventionSettings, LazyConvention
from homebot.integrations.homie.formats.model import DEVICE_ATTRIBUTES, NODE_ATTRIBUTES, PROPERTY_ATTRIBUTES

if TYPE_CHECKING:
    from homebot.integrations.homie.formats.reader import HomieReader

_Domain = Annotated[str, Field(min_length=1, max_length=100, pattern=r"^(?:\+|[^+#\x00/$]+)$")]


class HomieSettings(ConventionSettings):
    """The table of this convention.

    Attributes:
        domains: The first level of the topics; ``+`` for any, as the convention recommends to controllers. ``ebus`` is
            that of electrical panels, such as SPAN.
    """

    domains: tuple[_Domain, ...] = ("homie", "ebus")


class Homie(LazyConvention[HomieSettings, "HomieReader"]):
    """Discovery of devices by their attributes, with bounded memory. Alerts and logs are ignored."""

    Settings: ClassVar[type[BaseModel]] = HomieSettings
    name: ClassVar[str] = "homie"

    def filters(self) -> tuple[str, ...]:
        """Return the filters of attributes; the states come last."""
        return tuple(f"{domain}/{topic}" for domain in self.settings.domains for topic in (*_VERSION_5, *_VERSION_4))

    def problems(self) -> tuple[str, ...]:
        """Return the devices that did not finish announcing themselves."""
        return self.reader.problems() if self.is_loaded else ()

    def load_reader(self) -> HomieReader:
        """Return a reader of all versions."""
        from homebot.integrations.homie.formats.reader import HomieReader  # noqa: PLC0415 - see LazyConvention

        return HomieReader()


_VERSION_4 = (
    *(f"+/+/+/{attribute}" for attribute in PROPERTY_ATTRIBUTES),
    *(f"+/+/{attribute}" for attribute in NODE_ATTRIBUTES),
    *(f"+/{attribute}" for attribute in DEVICE_ATTRIBUTES),
)
"""In the order of the retained messages: the state comes last, after all that it completes."""

_VERSION_5 = ("5/+/$description", "5/+/$state")
"""The document precedes the state that makes it effective."""
