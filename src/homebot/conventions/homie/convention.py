"""The Homie convention, versions 3, 4 and 5. Pure.

Source: Homie convention 5 (homieiot/convention, develop of October 2024), 4.0.0 and 3.0.1.
"""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import BaseModel, ConfigDict, Field

from homebot.conventions.description import AnnouncementEvent, Publication
from homebot.conventions.homie import version4, version5
from homebot.conventions.homie.version4 import Version4
from homebot.conventions.homie.version5 import Version5
from homebot.errors import WireError

__all__ = ["Homie", "HomieSettings"]

_Domain = Annotated[str, Field(min_length=1, max_length=100, pattern=r"^(?:\+|[^+#\x00/$]+)$")]


class HomieSettings(BaseModel):
    """The table of this convention.

    Attributes:
        domains: The first level of the topics; ``+`` for any, as the convention tells who looks for devices.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    domains: tuple[_Domain, ...] = ("homie",)


class Homie:
    """Understands what devices say of themselves; keeps it, bounded. Alerts and logs are passed over.

    Args:
        settings: Its table.
    """

    Settings: ClassVar[type[BaseModel]] = HomieSettings
    name: ClassVar[str] = "homie"

    def __init__(self, settings: HomieSettings) -> None:
        self.rejected = 0
        self._domains = settings.domains
        self._version4 = Version4()
        self._version5 = Version5()

    @property
    def dropped(self) -> int:
        """Number of devices or attributes that were forgotten or not taken for want of room."""
        return self._version4.dropped + self._version5.dropped

    @property
    def ignored(self) -> int:
        """Number of illegal nodes and properties, of devices that were described without them."""
        return self._version4.ignored + self._version5.ignored

    def filters(self) -> tuple[str, ...]:
        """Return the filters of attributes; the states come last."""
        return tuple(
            one.replace("{domain}", domain)
            for domain in self._domains
            for one in (*version5.FILTERS, *version4.FILTERS)
        )

    def birth_messages(self) -> tuple[Publication, ...]:
        """Return nothing: everything is retained."""
        return ()

    def take(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:  # noqa: ARG002 - the broker keeps all attributes
        """Take an attribute and return what it tells of its device."""
        try:
            return self._taken(topic, payload)
        except WireError:
            self.rejected += 1
            raise

    def _taken(self, topic: str, payload: bytes) -> tuple[AnnouncementEvent, ...]:
        domain, _, rest = topic.partition("/")
        device_id, _, attribute = rest.partition("/")
        if device_id != "5":
            return self._version4.take(domain, device_id, attribute, payload)
        inner_id, _, inner = attribute.partition("/")
        if inner in {"$state", "$description"}:
            return self._version5.take(domain, inner_id, inner, payload)
        return ()
