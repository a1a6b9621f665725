"""Tasmota's discovery as a convention. Pure.

Source: Tasmota 14.4 firmware, ``xdrv_12_discovery.ino``; hatasmota 0.10.2.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from pydantic import BaseModel

from homebot.conventions.convention import ConventionSettings, LazyConvention, TopicPrefix

if TYPE_CHECKING:
    from homebot.integrations.tasmota.formats.reader import TasmotaReader

__all__ = ["TasmotaDiscovery", "TasmotaSettings"]


class TasmotaSettings(ConventionSettings):
    """The table of this convention.

    Attributes:
        prefix: The topic prefix of announcements; it is built into the firmware.
    """

    prefix: TopicPrefix = "tasmota/discovery"


class TasmotaDiscovery(LazyConvention[TasmotaSettings, "TasmotaReader"]):
    """Discovery of devices from ``config`` and ``sensors``, in any order; the key is the hardware address."""

    Settings: ClassVar[type[BaseModel]] = TasmotaSettings
    name: ClassVar[str] = "tasmota"

    def filters(self) -> tuple[str, ...]:
        """Return the filters of both messages."""
        return f"{self.settings.prefix}/+/config", f"{self.settings.prefix}/+/sensors"

    def reserved(self) -> tuple[str, ...]:
        """Return the announcements, and the command topics of all new devices."""
        return f"{self.settings.prefix}/#", "cmnd/tasmotas/#", "tasmotas/cmnd/#"

    def load_reader(self) -> TasmotaReader:
        """Return a reader of both messages."""
        from homebot.integrations.tasmota.formats.reader import TasmotaReader  # noqa: PLC0415 - see LazyConvention

        return TasmotaReader(self.settings.prefix)
