"""Devices with Tasmota firmware, as they announce themselves."""

from homebot.gateways.mqtt.tasmota.convention import TasmotaDiscovery, TasmotaSettings

__all__ = ["TasmotaDiscovery", "TasmotaSettings"]
