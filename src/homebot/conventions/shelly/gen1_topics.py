"""Topics of a Shelly of the first generation. Pure."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Gen1Topics"]


@dataclass(frozen=True, slots=True)
class Gen1Topics:
    """The topics of one device.

    Attributes:
        name: What the device is called there, for example ``shellyplug-s-122881``.
    """

    name: str

    @property
    def topic(self) -> str:
        """The topic that all of its topics are below."""
        return f"shellies/{self.name}"

    def at(self, suffix: str) -> str:
        """Return the topic *suffix* of the device."""
        return f"shellies/{self.name}/{suffix}"
