"""The family of simulated WLED controllers."""

from types import MappingProxyType

from homebot.house.family import LoopbackMdns, ServedFamily


class WledFamily(ServedFamily):
    """Strips of lights."""

    kinds = frozenset({"lamp"})
    device = "tests.integrations.wled.simulated.web_device:ServedWled"
    options = MappingProxyType({"announced": True})
    network = LoopbackMdns
