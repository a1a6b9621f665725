"""Memory of each topic that a device publishes on."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field

from homebot.conventions.convention import TopicDevice, TopicLayout
from homebot.devices import RawMessage
from homebot.devices.text.decode import TextDecoder, decoder_for
from homebot.errors import WireError
from homebot.gateways.announced.part_texts import missed
from homebot.graph import Publisher

__all__ = ["Channel", "Channels"]

MAX_CHANNELS = 100_000
KEPT = 10
KEPT_PAYLOAD = 4096


@dataclass(slots=True)
class Channel:
    """One topic of one device.

    Attributes:
        device: What the topic says of the device.
        listeners: Who gets its raw messages.
        refresh_at: Reading of the monotonic clock from which on the next message is worth a sighting.
        retained_only: Whether only a message that the broker had kept speaks for the device.
        decoder: Understands its words; None where nobody knows what it is.
        last_payload: The payload that was last looked at for what it tells.
        kept: The last 10 messages of at most 4 KiB and when each came, for a listener that comes a moment later.
    """

    device: TopicDevice
    listeners: list[Publisher[RawMessage]]
    refresh_at: float = 0.0
    retained_only: bool = False
    decoder: TextDecoder | None = None
    last_payload: bytes = b""
    kept: deque[tuple[float, RawMessage]] = field(default_factory=lambda: deque(maxlen=KEPT))

    def keep(self, message: RawMessage, now: float) -> None:
        """Remember *message*, which came at *now* on the monotonic clock, unless it is large."""
        if len(message.payload) <= KEPT_PAYLOAD:
            self.kept.append((now, message))

    def missed_by(self, since: float) -> tuple[RawMessage, ...]:
        """Return the kept messages that a listener wants that was there from *since* on.

        Args:
            since: Reading of the monotonic clock.

        Returns:
            What came then or later, and the broker's own stored state where it is still the device's last word.
        """
        return missed(self.kept, since)


class Channels:
    """The topics in use; at most 100,000.

    Args:
        conventions: Who may know a topic; the first that does is believed.
    """

    def __init__(self, conventions: Iterable[TopicLayout]) -> None:
        self._conventions = tuple(conventions)
        self._channels: dict[str, Channel] = {}
        self._by_key: dict[str, Channel] = {}

    def get(self, topic: str) -> Channel | None:
        """Return the channel of *topic*, when a device has spoken there."""
        return self._channels.get(topic)

    def of(self, key: str) -> Channel | None:
        """Return the channel of the device that the gateway calls *key*, when it has spoken."""
        return self._by_key.get(key)

    def announced(self, topic: str) -> TopicDevice | None:
        """Return the device that speaks on *topic* by one of the conventions, or None.

        Raises:
            WireError: The topic breaks the rules of its convention.
        """
        for convention in self._conventions:
            if (device := convention.announced(topic)) is not None:
                return device
        return None

    def open(self, topic: str, device: TopicDevice, listeners: list[Publisher[RawMessage]]) -> Channel:
        """Remember *topic* as one of *device*.

        Raises:
            WireError: 100,000 topics are in use.
        """
        if len(self._channels) >= MAX_CHANNELS:
            raise WireError(f"topic {topic!r} is one too many: {MAX_CHANNELS} are in use")
        channel = self._channels[topic] = self._by_key[device.key] = Channel(
            device, listeners, decoder=None if device.part is None else decoder_for(device.part.capabilities)
        )
        return channel

    def close(self, topic: str) -> None:
        """Forget *topic*."""
        channel = self._channels.pop(topic, None)
        if channel is not None and self._by_key.get(channel.device.key) is channel:
            del self._by_key[channel.device.key]
