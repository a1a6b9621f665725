"""Tasmota's discovery as a convention. Pure.

Source: Tasmota 14.4 firmware, ``xdrv_12_discovery.ino``; hatasmota 0.10.2.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import BaseModel, ConfigDict, Field

from homebot.conventions.lazy_convention import LazyConvention

if TYPE_CHECKING:
    from homebot.conventions.tasmota.reader import TasmotaReader

__all__ = ["TasmotaDiscovery", "TasmotaSettings"]

_Prefix = Annotated[str, Field(min_length=1, max_length=200, pattern=r"^[^+#\x00]*[^+#\x00/]$")]


class TasmotaSettings(BaseModel):
    """The table of this convention.

    Attributes:
        prefix: Where devices announce themselves; it is built into the firmware.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    prefix: _Prefix = "tasmota/discovery"


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
