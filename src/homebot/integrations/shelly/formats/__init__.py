"""Shelly's own MQTT dialects, of both generations, as one convention. Pure.

Source: Shelly Gen1 API; Shelly Gen2+ API; iobroker.shelly 12.0.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import BaseModel, Field

from homebot.conventions.convention import ConventionSettings, LazyConvention
from homebot.conventions.description import Publication, Publications

if TYPE_CHECKING:
    from homebot.integrations.shelly.formats.reader import ShellyReader

__all__ = ["Shelly", "ShellySettings"]

_Client = Annotated[str, Field(min_length=1, max_length=60, pattern=r"^[A-Za-z0-9_-]+$")]
_Prefix = Annotated[str, Field(min_length=1, max_length=200, pattern=r"^[^#\x00$]*[^#\x00$/]$")]


class ShellySettings(ConventionSettings):
    """The table of this convention.

    Attributes:
        client: The client id of requests to the second generation; unique for each homebot at a broker.
        prefixes: Filters of custom topic prefixes of the second generation with several levels, for example
            ``home/shellies/+``.
    """

    client: _Client = "homebot"
    prefixes: tuple[_Prefix, ...] = ()


class Shelly(LazyConvention[ShellySettings, "ShellyReader"]):
    """Discovery of Shelly's devices from their own messages, with bounded memory."""

    Settings: ClassVar[type[BaseModel]] = ShellySettings
    name: ClassVar[str] = "shelly"

    def filters(self) -> tuple[str, ...]:
        """Return the filters of answers, signs of life, announcements and the topics of parts."""
        client, prefixes = self.settings.client, ("+", "shellies/+", *self.settings.prefixes)
        second = (
            f"{client}/rpc",
            *(f"{client}/{prefix}/rpc" for prefix in prefixes),
            *(f"{prefix}/{rest}" for prefix in prefixes for rest in ("online", "events/rpc")),
            "+/status/+",
        )
        return tuple(dict.fromkeys((*second, *_FIRST)))

    def birth_messages(self) -> Publications:
        """Return requests of announcements and states of the first generation; the second is asked by id."""
        return Publication("shellies/command", b"announce"), Publication("shellies/command", b"update")

    def load_reader(self) -> ShellyReader:
        """Return a reader of both generations."""
        from homebot.integrations.shelly.formats.reader import ShellyReader  # noqa: PLC0415 - see LazyConvention

        return ShellyReader(self.settings.client)


_FIRST = (
    "shellies/announce",
    "shellies/+/announce",
    "shellies/+/online",
    *(f"shellies/+/{kind}/+" for kind in ("relay", "roller", "light", "color", "white", "input", "input_event")),
    *(f"shellies/+/{kind}/+/status" for kind in ("light", "color", "white")),
    *(f"shellies/+/{kind}/+/power" for kind in ("relay", "roller", "light", "color", "white")),
    *(f"shellies/+/{kind}/+/energy" for kind in ("relay", "roller", "light", "color", "white")),
    "shellies/+/emeter/+/+",
    "shellies/+/valve/+/state",
    *(f"shellies/+/{kind}/+" for kind in ("adc", "ext_temperature", "ext_humidity", "ext_switch", "sensor")),
    *(f"shellies/+/{kind}" for kind in ("temperature", "overtemperature", "overpower", "status")),
)
"""Narrow filters of the topics of parts."""
