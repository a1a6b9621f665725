"""The topic layout of the thesis: ``HOME/SERVICE_TYPE/DEVICE_ID/CHANNEL``, with the channels ``out`` and ``in``. Pure.

Only what devices publish is subscribed to, so that a command of ours never comes back as if a device had sent it,
whatever the MQTT version. Topics of the home with too few or too many levels are subscribed to as well, so that
they can be reported.
"""

from __future__ import annotations

from typing import ClassVar

from pydantic import BaseModel, ConfigDict

from homebot.conventions.description import (
    AnnouncementEvent,
    DescribedPart,
    DeviceAnnounced,
    DeviceWithdrawn,
    Publications,
    TextEndpoint,
)
from homebot.conventions.text_codec import TextCodec
from homebot.conventions.thesis.parts import thesis_part
from homebot.errors import WireError

__all__ = ["Thesis", "ThesisSettings"]

LEVELS = ("SERVICE_TYPE", "DEVICE_ID", "CHANNEL")


class ThesisSettings(BaseModel):
    """The table of this convention.

    Attributes:
        root: The home: the first level or levels. Empty for every home; a device's key then begins with its home, and
            topics of another shape are not looked at, because they may be anybody's.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    root: str = ""


class Thesis:
    """Understands the devices of one home, or of every home on the broker, by their topics alone."""

    Settings: ClassVar[type[BaseModel]] = ThesisSettings
    name: ClassVar[str] = "thesis"

    def __init__(self, settings: ThesisSettings) -> None:
        self.rejected = 0
        self._root = settings.root

    def filters(self) -> tuple[str, ...]:
        """Return the filters for what devices publish, and for topics of the home that break the layout."""
        if not self._root:
            return ("+/+/+/out",)
        root = self._root
        return (f"{root}/+/+/out", root, f"{root}/+", f"{root}/+/+", f"{root}/+/+/+/+/#")

    def birth_messages(self) -> Publications:
        """Return nothing: no device of the layout announces itself when asked."""
        return ()

    def take(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Return the device that publishes on *topic*; an empty payload takes it out of the house.

        Raises:
            WireError: The topic has too few or too many levels, or an empty one.
        """
        del retained
        try:
            device = self.announced(topic)
        except WireError:
            self.rejected += 1
            raise
        if device is None:
            return ()
        if payload:
            return (device,)
        return (DeviceWithdrawn(device.key, "its retained message was deleted", is_final=True, device=device),)

    def announced(self, topic: str) -> DeviceAnnounced | None:
        """Return the device that publishes on *topic*; None for another home, or a channel that is not ``out``.

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
        endpoint = TextEndpoint(service_type, topic, f"{base}/in")
        part = thesis_part(service_type, topic, endpoint.command_address)
        return DeviceAnnounced(
            key=f"{service_type}/{device_id}" if self._root else base,
            convention=self.name,
            native=True,
            identifiers=(),
            name=device_id,
            parts=(DescribedPart(part, TextCodec(part)),),
            topic=topic,
            facts={"home": home},
            owns=(base,),
            text=endpoint,
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
