"""Reader of what Shelly's devices publish, of both generations. Pure."""

from __future__ import annotations

from homebot.conventions.description import AnnouncementEvent
from homebot.conventions.shelly.gen1 import Gen1
from homebot.conventions.shelly.gen2 import Gen2

__all__ = ["ShellyReader"]


class ShellyReader:
    """Reads the messages of both generations, and keeps what devices reported.

    Args:
        client: As whom devices of the second generation are asked.
    """

    def __init__(self, client: str) -> None:
        self.rejected = 0
        self._gen1 = Gen1()
        self._gen2 = Gen2(client)

    @property
    def dropped(self) -> int:
        """Number of devices or answers that were forgotten or not taken for want of room."""
        return self._gen1.dropped + self._gen2.dropped

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Take a message, and return what it describes of devices or makes one ask them."""
        if self._is_first(topic):
            return self._gen1.take(topic, payload)
        return self._gen2.read_message(topic, payload, retained=retained)

    def _is_first(self, topic: str) -> bool:
        """Return whether *topic* is the first generation's; a prefix of the second may lie among its topics."""
        if not topic.startswith("shellies/") or topic.endswith("/events/rpc"):
            return False
        return not (topic.endswith("/online") and self._gen2.knows(topic.removesuffix("/online")))
