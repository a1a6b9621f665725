"""Hue bridges on the network. Pure."""

from homebot.conventions.dns_sd import FoundService, name_of
from homebot.conventions.ecosystem import Ecosystem


class Hue(Ecosystem):
    """Bridges."""

    service_types = frozenset({"_hue._tcp.local."})
    gateway = "hue"

    @classmethod
    def next_step(cls, service: FoundService) -> str:
        """Return how a bridge is paired."""
        return f"add [gateways.hue], then: homebot pair '{name_of(service)}'"
