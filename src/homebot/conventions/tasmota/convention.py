"""Tasmota's discovery as a convention. Pure.

Source: Tasmota 14.4 firmware, ``xdrv_12_discovery.ino``; hatasmota 0.10.2.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from pydantic import BaseModel

from homebot.conventions.convention import ConventionSettings, LazyConvention, TopicPrefix

if TYPE_CHECKING:
    from homebot.conventions.tasmota.reader import TasmotaReader

__all__ = ["TasmotaDiscovery", "TasmotaSettings"]


class TasmotaSettings(ConventionSettings):
    """The table of this convention.

    Attributes:
        prefix: Where devices announce themselves; it is built into the firmware.
    """

    prefix: TopicPrefix = "tasmota/discovery"


class TasmotaDiscovery(LazyConvention[TasmotaSettings, "TasmotaReader"]):
    """Understands ``config`` and ``sensors`` of each device, in either order; its key is its hardware address."""

    Settings: ClassVar[type[BaseModel]] = TasmotaSettings
    name: ClassVar[str] = "tasmota"

    def filters(self) -> tuple[str, ...]:
        """Return the filters of both messages."""
        return f"{self.settings.prefix}/+/config", f"{self.settings.prefix}/+/sensors"

    def reserved(self) -> tuple[str, ...]:
        """Return what is below the announcements, and the topics on which all new devices take commands."""
        return f"{self.settings.prefix}/#", "cmnd/tasmotas/#", "tasmotas/cmnd/#"

    def load_reader(self) -> TasmotaReader:
        """Return a reader of both messages."""
        from homebot.conventions.tasmota.reader import TasmotaReader  # noqa: PLC0415 - see LazyConvention

        return TasmotaReader(self.settings.prefix)
