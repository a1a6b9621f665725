"""The families of devices that there are in houses, as they speak over MQTT, by their names there. Pure."""

# ruff: noqa: PLC0415 - a house has devices of one or two families, and starts sooner without the others

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, final

if TYPE_CHECKING:
    from homebot.house.dialect import Dialect

__all__ = ["DIALECTS"]


@final
class _Dialects(Mapping[str, "Dialect"]):
    """Dialects by name, each made when it is first asked for.

    Args:
        makers: Import and make the dialect of each name.
    """

    def __init__(self, makers: Mapping[str, Callable[[], Dialect]]) -> None:
        self._makers = makers
        self._made: dict[str, Dialect] = {}

    def __getitem__(self, name: str) -> Dialect:
        if name not in self._made:
            self._made[name] = self._makers[name]()
        return self._made[name]

    def __contains__(self, name: object) -> bool:
        return name in self._makers

    def __iter__(self) -> Iterator[str]:
        return iter(self._makers)

    def __len__(self) -> int:
        return len(self._makers)


def _thesis() -> Dialect:
    from homebot.house.dialects.thesis import ThesisDialect

    return ThesisDialect()


def _homeassistant() -> Dialect:
    from homebot.house.dialects.homeassistant import HomeAssistantDialect

    return HomeAssistantDialect()


def _homeassistant_device() -> Dialect:
    from homebot.house.dialects.homeassistant import HomeAssistantDialect

    return HomeAssistantDialect(whole_devices=True)


def _zigbee2mqtt() -> Dialect:
    from homebot.house.dialects.zigbee2mqtt import Zigbee2MqttDialect

    return Zigbee2MqttDialect()


def _tasmota() -> Dialect:
    from homebot.house.dialects.tasmota import TasmotaDialect

    return TasmotaDialect()


def _shelly() -> Dialect:
    from homebot.house.dialects.shelly import ShellyDialect

    return ShellyDialect()


def _shelly_rpc() -> Dialect:
    from homebot.house.dialects.shelly_rpc import ShellyRpcDialect

    return ShellyRpcDialect()


def _homie() -> Dialect:
    from homebot.house.dialects.homie import HomieDialect

    return HomieDialect()


DIALECTS: Mapping[str, Dialect] = _Dialects(
    {
        "thesis": _thesis,
        "homeassistant": _homeassistant,
        "homeassistant_device": _homeassistant_device,
        "zigbee2mqtt": _zigbee2mqtt,
        "tasmota": _tasmota,
        "shelly": _shelly,
        "shelly_rpc": _shelly_rpc,
        "homie": _homie,
    }
)
"""Every dialect."""
