"""Messages that were sent with a code, and are not mirrored when the broker sends them back. Pure."""

from __future__ import annotations

from dataclasses import replace
from hashlib import blake2b
from secrets import token_bytes

from homebot.conventions.bounded_dict import BoundedDict
from homebot.conventions.description import Publication

__all__ = ["SentSecrets"]

MAX_TOPICS = 1_000
"""Topics of which the last secret is known; then the oldest is forgotten."""


class SentSecrets:
    """The last message with a code on each topic, as a keyed hash; the code itself is not kept."""

    def __init__(self) -> None:
        self._key = token_bytes(32)
        self._sent: BoundedDict[bytes] = BoundedDict(MAX_TOPICS)

    def keep(self, publication: Publication) -> Publication:
        """Note *publication*, and return it as it may be sent: no broker shall keep a code."""
        self._sent.add(publication.topic, self._hash(publication.payload))
        return replace(publication, retain=False)

    def is_one(self, topic: str, payload: bytes) -> bool:
        """Tell whether a message is one that we sent with a code."""
        sent = self._sent.get(topic)
        return sent is not None and sent == self._hash(payload)

    def _hash(self, payload: bytes) -> bytes:
        return blake2b(payload, key=self._key, digest_size=32).digest()
