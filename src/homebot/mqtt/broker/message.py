"""A message in the broker, encoded once for all receivers of the same bytes."""

from collections.abc import Callable
from dataclasses import replace
from math import ceil
from typing import Final, final

from homebot.mqtt.packets import NO_PROPERTIES, PacketType, Properties, ProtocolVersion
from homebot.mqtt.packets.properties import encode_properties
from homebot.mqtt.packets.publish import encode_publish_parts

_PAIR = 160  # bytes of a user property in addition to its text
BULKY: Final = 8 * 1024
"""Bytes from which copies of a message are not made all at once, nor kept encoded while it waits, as that would take
twice its counted memory."""

ENTRY: Final = 200
"""Estimated bytes of a place in a queue."""

_OVERHEAD = 600  # estimated bytes of a message beside topic, payload and properties
_MAX_ENCODED = 7  # after the first: two versions at three QoS, and some for subscription identifiers
_NOTHING = (b"", b"")


@final
class BrokerMessage:
    """One published message; its public attributes do not change.

    Attributes:
        properties: Properties for subscribers: no topic alias, no subscription identifiers.
        expires_at: When it expires, on the monotonic clock, or None.
        kind: The key of :attr:`encoded`: protocol version, QoS and retain flag, as combined by :meth:`parts`; -1 if
            there is none. Receivers with the same key need no call.
        encoded: First result of :meth:`parts`, for receivers without subscription identifiers.
        order: Its number among the retained messages.
        size: Estimated bytes of topic, payload and properties, for the limits.
    """

    __slots__ = (
        "_more",
        "encoded",
        "expires_at",
        "holders",
        "kind",
        "order",
        "origin",
        "payload",
        "properties",
        "qos",
        "retain",
        "size",
        "topic",
    )

    order: int

    def __init__(
        self,
        topic: str,
        payload: bytes,
        qos: int = 0,
        retain: bool = False,  # noqa: FBT001, FBT002 - made for every message, by position for speed
        properties: Properties = NO_PROPERTIES,
        origin: str = "",
        expires_at: float | None = None,
    ) -> None:
        self.topic = topic
        self.payload = payload
        self.qos = qos
        self.retain = retain
        self.properties = properties
        self.origin = origin
        self.expires_at = expires_at
        self.holders = 0
        size = len(topic) + len(payload)
        self.size = size if properties is NO_PROPERTIES else size + size_of(properties)
        self.kind = -1
        self.encoded = _NOTHING
        self._more: dict[object, tuple[bytes, bytes]] | None = None  # for all other receivers

    def parts(
        self,
        version: ProtocolVersion,
        qos: int,
        retain: bool,  # noqa: FBT001 - as above
        identifiers: tuple[int, ...] = (),
        now: float = 0.0,
    ) -> tuple[bytes, bytes]:
        """Return the PUBLISH packet before and after the packet id; at QoS 0, the whole packet and nothing.

        Bytes with the retain flag are not kept, as replays are rare and retained messages must not exceed their counted
        memory several times.

        Args:
            now: Monotonic time; an expiring message is sent with the remaining interval.
        """
        is_v5 = version is ProtocolVersion.V5
        kind = is_v5 << 3 | qos << 1 | retain
        key: object = kind
        if is_v5 and (identifiers or self.expires_at is not None):
            key = (kind, identifiers, self._left(now))
        elif kind == self.kind:
            return self.encoded
        parts = None if self._more is None else self._more.get(key)
        if parts is None:
            properties = self.properties_for(identifiers, now) if is_v5 else None
            parts = self._encode(qos, retain, properties)
            if not retain:
                self._store(key, parts)
        return parts

    def _encode(self, qos: int, retain: bool, properties: Properties | None) -> tuple[bytes, bytes]:  # noqa: FBT001 - as above
        encoded = b"" if properties is None else encode_properties(properties, PacketType.PUBLISH)
        parts = encode_publish_parts(self.topic, self.payload, qos, retain, encoded)
        return parts if qos else (b"".join(parts), b"")

    def hold(self, count: Callable[[int], None]) -> None:
        """Add places in queues; a message in several queues counts once."""
        count(ENTRY if self.holders else ENTRY + _OVERHEAD + self.size)
        self.holders += 1

    def release(self, count: Callable[[int], None]) -> None:
        """Remove a place in a queue."""
        self.holders -= 1
        count(-ENTRY if self.holders else -ENTRY - _OVERHEAD - self.size)

    def forget_encoded(self) -> None:
        """Free the bytes cached by :meth:`parts`, after the last receiver."""
        self.kind = -1
        self.encoded = _NOTHING
        self._more = None

    def properties_for(self, identifiers: tuple[int, ...], now: float) -> Properties:
        """Return the MQTT 5 properties for one receiver; arguments as for :meth:`parts`."""
        left = self._left(now)
        if not identifiers and left is None:
            return self.properties
        return replace(self.properties, subscription_identifiers=identifiers, message_expiry_interval=left)

    def expired(self, now: float) -> bool:
        """Return whether the message has expired by *now*."""
        return self.expires_at is not None and self.expires_at <= now

    def _store(self, key: object, parts: tuple[bytes, bytes]) -> None:
        if self.size >= BULKY and self.holders:
            return
        if self.kind < 0 and isinstance(key, int):
            self.kind = key
            self.encoded = parts
        elif self._more is None:
            self._more = {key: parts}
        elif len(self._more) < _MAX_ENCODED:
            self._more[key] = parts

    def _left(self, now: float) -> int | None:
        return None if self.expires_at is None else max(ceil(self.expires_at - now), 0)


def size_of(properties: Properties) -> int:
    """Return the estimated bytes of *properties*."""
    texts = (properties.content_type, properties.response_topic, properties.correlation_data)
    pairs = sum(_PAIR + len(name) + len(value) for name, value in properties.user_properties)
    return pairs + sum(len(text) for text in texts if text is not None)
