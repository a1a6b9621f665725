"""The layout of the thesis: ``HOME/SERVICE_TYPE/DEVICE_ID/CHANNEL``; a device speaks on ``out``, listens on ``in``.

Subscribed to is only what devices say, so that a command of ours never comes back as if a device had spoken, whatever
the MQTT version. Topics of the home with too few or too many levels are subscribed to as well, to be able to say so.
"""

from __future__ import annotations

from homebot.conventions.convention import TopicDevice
from homebot.conventions.thesis_parts import thesis_part
from homebot.devices import KeyValue
from homebot.errors import WireError

__all__ = ["ThesisLayout"]

LEVELS = ("SERVICE_TYPE", "DEVICE_ID", "CHANNEL")


class ThesisLayout:
    """Reads the thesis's topics of one home, or of every home on the broker.

    Args:
        root: The home: the first level or levels. Empty for every home; a device's key then begins with its home, and
            topics of another shape are not looked at, because they may be anybody's.
    """

    def __init__(self, root: str) -> None:
        self._root = root

    def filters(self) -> tuple[str, ...]:
        """Return the filters for what devices say, and for topics of the home that break the layout."""
        if not self._root:
            return ("+/+/+/out",)
        root = self._root
        return (f"{root}/+/+/out", root, f"{root}/+", f"{root}/+/+", f"{root}/+/+/+/+/#")

    def announced(self, topic: str) -> TopicDevice | None:
        """Return the device that speaks on *topic*; None for another home, or a channel that is not ``out``.

        Raises:
            WireError: The topic has too few or too many levels, or an empty one.
        """
        home, levels = self._split(topic)
        if home is None:
            return None
        if len(levels) != len(LEVELS):
            shape = "/".join((self._root or "HOME", *LEVELS))
            raise WireError(f"topic {topic!r} has {len(levels)} levels below the home, not {len(LEVELS)}: {shape}")
        for level, what in zip(levels, LEVELS, strict=True):
            if not level:
                raise WireError(f"topic {topic!r} has an empty level where {what} belongs")
        service_type, device_id, channel = levels
        if channel != "out":
            return None
        base = f"{home}/{service_type}/{device_id}"
        return TopicDevice(
            key=f"{service_type}/{device_id}" if self._root else base,
            name=device_id,
            service_type=service_type,
            address=topic,
            command_address=f"{base}/in",
            metadata=(KeyValue(key="home", value=home),),
            part=thesis_part(service_type, topic, f"{base}/in"),
        )

    def _split(self, topic: str) -> tuple[str | None, list[str]]:
        if not self._root:
            home, _, rest = topic.partition("/")
            return home, rest.split("/")
        if topic == self._root:
            return self._root, []
        if topic.startswith(f"{self._root}/"):
            return self._root, topic[len(self._root) + 1 :].split("/")
        return None, []
