"""Shelly's own MQTT dialects, of both generations, as one convention. Pure.

Source: Shelly Gen1 API; Shelly Gen2+ API; iobroker.shelly 12.0.
"""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import BaseModel, ConfigDict, Field

from homebot.conventions.description import AnnouncementEvent, Publication
from homebot.conventions.shelly.gen1 import BIRTH_MESSAGES, FILTERS, Gen1
from homebot.conventions.shelly.gen2 import Gen2
from homebot.errors import WireError

__all__ = ["Shelly", "ShellySettings"]

_Client = Annotated[str, Field(min_length=1, max_length=60, pattern=r"^[A-Za-z0-9_-]+$")]
_Prefix = Annotated[str, Field(min_length=1, max_length=200, pattern=r"^[^#\x00$]*[^#\x00$/]$")]


class ShellySettings(BaseModel):
    """The table of this convention.

    Attributes:
        client: As whom devices of the second generation are asked; another homebot at the same broker needs another.
        prefixes: Filters of topic prefixes of several levels that devices of the second generation were given, for
            example ``home/shellies/+``.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    client: _Client = "homebot"
    prefixes: tuple[_Prefix, ...] = ()


class Shelly:
    """Understands what Shelly's devices say of themselves. Keeps what they said, bounded.

    Args:
        settings: Its table.
    """

    Settings: ClassVar[type[BaseModel]] = ShellySettings
    name: ClassVar[str] = "shelly"

    def __init__(self, settings: ShellySettings) -> None:
        self.rejected = 0
        self._gen1 = Gen1()
        self._gen2 = Gen2(settings.client, ("shellies/+", *settings.prefixes))

    @property
    def dropped(self) -> int:
        """Number of devices or answers that were forgotten or not taken for want of room."""
        return self._gen1.dropped + self._gen2.dropped

    def filters(self) -> tuple[str, ...]:
        """Return the filters of answers, signs of life, announcements, and what parts are known by."""
        return tuple(dict.fromkeys((*self._gen2.filters, *FILTERS)))

    def birth_messages(self) -> tuple[Publication, ...]:
        """Return what makes the first generation announce itself; the second is asked one by one."""
        return BIRTH_MESSAGES

    def take(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Take a message, and return what it tells of devices or makes one ask them."""
        try:
            if self._is_first(topic):
                return self._gen1.take(topic, payload)
            return self._gen2.take(topic, payload, retained=retained)
        except WireError:
            self.rejected += 1
            raise

    def _is_first(self, topic: str) -> bool:
        """Return whether *topic* is the first generation's; a prefix of the second may lie among its topics."""
        if not topic.startswith("shellies/") or topic.endswith("/events/rpc"):
            return False
        return not (topic.endswith("/online") and self._gen2.knows(topic.removesuffix("/online")))
