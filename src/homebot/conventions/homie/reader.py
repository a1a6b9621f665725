"""Reader of Homie's attributes, of all versions. Pure."""

from __future__ import annotations

from homebot.conventions.description import AnnouncementEvent
from homebot.conventions.homie.version4 import Version4
from homebot.conventions.homie.version5 import Version5

__all__ = ["HomieReader"]


class HomieReader:
    """Reads the attributes of devices of any version, and keeps what they reported."""

    def __init__(self) -> None:
        self.rejected = 0
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

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:  # noqa: ARG002 - the broker keeps all attributes
        """Take an attribute and return what it describes of its device."""
        domain, _, rest = topic.partition("/")
        device_id, _, attribute = rest.partition("/")
        if device_id != "5":
            return self._version4.take(domain, device_id, attribute, payload)
        inner_id, _, inner = attribute.partition("/")
        if inner in {"$state", "$description"}:
            return self._version5.take(domain, inner_id, inner, payload)
        return ()
