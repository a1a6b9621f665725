"""The table ``[gateways.NAME]`` of a gateway of tags."""

import re
from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import BaseModel, ConfigDict, Field, field_validator

from homebot.gateways.base import GatewaySettings
from homebot.units import Seconds

_PATH = re.compile(r"(usb|tty|com|udp)(:.*)?")
_UID = re.compile(r"(?:[0-9a-f]{2}){4,10}")
_YEAR = 365 * 24 * 3600.0


class TagSettings(BaseModel):
    """The settings of one tag: ``[gateways.NAME.tags.UID]``.

    Attributes:
        area: The room that it is in; it replaces the room on the tag.
        device: The id or the name of the device that it points to; it replaces the pointer on the tag.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: Annotated[str, Field(max_length=100)] = ""
    area: Annotated[str, Field(max_length=100)] = ""
    device: Annotated[str, Field(max_length=500)] = ""


class NfcGatewaySettings(GatewaySettings):
    """The settings of a gateway of tags.

    Attributes:
        devices: The readers as nfcpy calls them: ``usb``, ``usb:072f:2200``, ``tty:USB0:pn532`` or ``udp:HOST:PORT``.
        tags: The settings of single tags, by their numbers in hexadecimal digits.
        max_tags: Tags that may be known at once.
        teaches_place: Whether a tag that points to a device assigns its room, if no other source does.
        stale_after: Seconds after which a tag counts as stale if it is not held to a reader.
    """

    gone: ClassVar[Mapping[str, str]] = {
        "backend": "is gone: nfcpy reads tags at all readers, without pcscd",
        "readers": 'is gone with PC/SC: name the readers in devices, as in devices = ["usb:072f:2200"]',
    }

    devices: Annotated[tuple[str, ...], Field(min_length=1, max_length=8)] = ("usb",)
    tags: Mapping[str, TagSettings] = Field(default_factory=dict)
    max_tags: Annotated[int, Field(ge=1, le=10_000)] = 1000
    teaches_place: bool = True
    stale_after: Seconds = _YEAR

    @field_validator("devices")
    @classmethod
    def _check_devices(cls, devices: tuple[str, ...]) -> tuple[str, ...]:
        for device in devices:
            if not _PATH.fullmatch(device):
                raise ValueError(f"{device!r} is not a reader; write usb, tty:PORT:DRIVER or udp:HOST:PORT")
        return devices

    @field_validator("tags")
    @classmethod
    def _check_tags(cls, tags: Mapping[str, TagSettings]) -> Mapping[str, TagSettings]:
        known: dict[str, TagSettings] = {}
        for given, tag in tags.items():
            uid = re.sub(r"[:\s-]", "", given).casefold()
            if not _UID.fullmatch(uid):
                raise ValueError(f"{given!r} is not the number of a tag; write it like 04a1b2c3d4e5f6")
            if uid in known:
                raise ValueError(f"{given!r} is there twice")
            known[uid] = tag
        return known
