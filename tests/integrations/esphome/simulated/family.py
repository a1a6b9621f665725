"""The family of simulated ESPHome devices."""

from types import MappingProxyType

from homebot.house.family import ALL_KINDS, LoopbackMdns, ServedFamily


class EsphomeFamily(ServedFamily):
    """Devices with ESPHome's native API."""

    kinds = ALL_KINDS
    device = "tests.integrations.esphome.simulated.device:EsphomeServedDevice"
    options = MappingProxyType({"announced": True})
    network = LoopbackMdns
