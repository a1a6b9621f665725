"""Reader of the messages of Shelly's devices, of both generations. Pure."""

from homebot.conventions.description import AnnouncementEvent
from homebot.integrations.shelly.formats.gen1 import Gen1
from homebot.integrations.shelly.formats.gen2 import Gen2


class ShellyReader:
    """Reader of both generations; *client* is the client id of requests to the second one."""

    def __init__(self, client: str) -> None:
        self.rejected = 0
        self._gen1 = Gen1()
        self._gen2 = Gen2(client)

    @property
    def dropped(self) -> int:
        """Number of dropped devices and answers."""
        return self._gen1.dropped + self._gen2.dropped

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Return the descriptions and requests that follow from a message."""
        is_second = (
            not topic.startswith("shellies/")
            or topic.endswith("/events/rpc")
            # a prefix of the second generation may be among the topics of the first
            or (topic.endswith("/online") and self._gen2.knows(topic.removesuffix("/online")))
        )
        if is_second:
            return self._gen2.read_message(topic, payload, retained=retained)
        return self._gen1.read_message(topic, payload)
