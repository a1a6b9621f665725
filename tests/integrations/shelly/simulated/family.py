"""The family of simulated Shellys of the second generation that are reached over HTTP."""

from types import MappingProxyType

from homebot.house.family import LoopbackMdns, ServedFamily


class ShellyHttpFamily(ServedFamily):
    """Lamps and motors."""

    kinds = frozenset({"cover", "lamp", "window"})
    device = "tests.integrations.shelly.simulated.web_device:ServedShelly"
    options = MappingProxyType({"announced": True})
    network = LoopbackMdns
