"""Devices with Tasmota firmware, as they announce themselves."""

from homebot.conventions.tasmota.convention import TasmotaDiscovery, TasmotaSettings

__all__ = ["TasmotaDiscovery", "TasmotaSettings"]
