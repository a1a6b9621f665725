"""Reader of Homie's attributes, of all versions. Pure."""

from homebot.conventions.description import AnnouncementEvent
from homebot.integrations.homie.formats.version4 import Version4
from homebot.integrations.homie.formats.version5 import Version5


class HomieReader:
    """Reader of the attributes of devices of any version, with bounded memory."""

    def __init__(self) -> None:
        self.rejected = 0
        self._version4 = Version4()
        self._version5 = Version5()

    @property
    def dropped(self) -> int:
        """Number of dropped devices and attributes."""
        return self._version4.dropped + self._version5.dropped

    @property
    def ignored(self) -> int:
        """Number of illegal nodes and properties, of devices that were described without them."""
        return self._version4.ignored + self._version5.ignored

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:  # noqa: ARG002 - the broker keeps all attributes
        """Read an attribute and return the description that it completes."""
        domain, _, rest = topic.partition("/")
        device_id, _, attribute = rest.partition("/")
        if device_id != "5":
            return self._version4.read_attribute(domain, device_id, attribute, payload)
        inner_id, _, inner = attribute.partition("/")
        if inner in {"$state", "$description"}:
            return self._version5.read_attribute(domain, inner_id, inner, payload)
        return ()
