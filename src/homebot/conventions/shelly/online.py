"""The topic on which a Shelly, or its last will, says whether it is there. Pure."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["OnlineTopic"]

_PAYLOADS = {b"true": True, b"false": False}


@dataclass(frozen=True, slots=True)
class OnlineTopic:
    """See :class:`homebot.conventions.description.AvailabilitySource`.

    Attributes:
        topic: The topic.
    """

    topic: str

    def read(self, payload: bytes) -> bool | None:
        """Return whether the device is there, or None when *payload* says neither."""
        return _PAYLOADS.get(payload)
