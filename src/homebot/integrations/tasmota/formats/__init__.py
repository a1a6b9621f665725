"""Devices with Tasmota firmware, as they announce themselves."""

from homebot.integrations.tasmota.formats.convention import TasmotaDiscovery, TasmotaSettings

__all__ = ["TasmotaDiscovery", "TasmotaSettings"]
