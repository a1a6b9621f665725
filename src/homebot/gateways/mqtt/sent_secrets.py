"""Messages that were sent with a code, and are not mirrored when the broker sends them back. Pure."""

from __future__ import annotations

from hashlib import blake2b
from secrets import token_bytes

from homebot.conventions.description import Publication

__all__ = ["SentSecrets"]

MAX_TOPICS = 1_000
"""Topics of which the last secret is known; then the oldest is forgotten."""


class SentSecrets:
    """The last message with a code on each topic, as a keyed hash; the code itself is not kept."""

    def __init__(self) -> None:
        self.sent: dict[str, bytes] = {}
        self._key = token_bytes(32)

    def keep(self, publication: Publication) -> Publication:
        """Note *publication*, and return it as it may be sent: no broker shall keep a code."""
        self.sent.pop(publication.topic, None)
        while len(self.sent) >= MAX_TOPICS:
            del self.sent[next(iter(self.sent))]
        self.sent[publication.topic] = self._hash(publication.payload)
        return publication._replace(retain=False)

    def is_one(self, topic: str, payload: bytes) -> bool:
        """Return whether a message is one that we sent with a code."""
        sent = self.sent.get(topic)
        return sent is not None and sent == self._hash(payload)

    def _hash(self, payload: bytes) -> bytes:
        return blake2b(payload, key=self._key, digest_size=32).digest()
