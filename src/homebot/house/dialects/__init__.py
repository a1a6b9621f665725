"""The families of devices that there are in houses, as they speak over MQTT, by their names there. Pure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import TYPE_CHECKING, final

if TYPE_CHECKING:
    from homebot.house.dialect import Dialect

__all__ = ["DIALECTS"]

_CLASSES: Mapping[str, tuple[str, str, Mapping[str, object]]] = {
    "thesis": ("thesis", "ThesisDialect", {}),
    "homeassistant": ("homeassistant", "HomeAssistantDialect", {}),
    "homeassistant_device": ("homeassistant", "HomeAssistantDialect", {"whole_devices": True}),
    "zigbee2mqtt": ("zigbee2mqtt", "Zigbee2MqttDialect", {}),
    "tasmota": ("tasmota", "TasmotaDialect", {}),
    "shelly": ("shelly", "ShellyDialect", {}),
    "shelly_rpc": ("shelly_rpc", "ShellyRpcDialect", {}),
    "homie": ("homie", "HomieDialect", {}),
}
"""Module, class and arguments by name; a house has one or two families, and starts sooner without the others."""


@final
class _Dialects(Mapping[str, "Dialect"]):
    """Dialects by name, each imported on first use."""

    def __init__(self) -> None:
        self._made: dict[str, Dialect] = {}

    def __getitem__(self, name: str) -> Dialect:
        if name not in self._made:
            module, kind, options = _CLASSES[name]
            dialect: Dialect = getattr(import_module(f"{__name__}.{module}"), kind)(**options)
            self._made[name] = dialect
        return self._made[name]

    def __contains__(self, name: object) -> bool:
        return name in _CLASSES

    def __iter__(self) -> Iterator[str]:
        return iter(_CLASSES)

    def __len__(self) -> int:
        return len(_CLASSES)


DIALECTS: Mapping[str, Dialect] = _Dialects()
"""Every dialect."""
