"""HomeKit's accessories on the network, and their codes. Pure.

Source: HomeKit Accessory Protocol Specification R2, 6.4 and table 6-8 (status flags).
"""

from typing import Final

from homebot.conventions.dns_sd import FoundService, name_of
from homebot.conventions.ecosystem import Ecosystem
from homebot.integrations.homekit.formats.setup_code import read_homekit_code

_FLAG_DIGITS: Final = 3
"""Decimal digits of the status flags, which are a byte."""


class Homekit(Ecosystem):
    """Accessories, also over Thread; bridges of other makers are among them."""

    service_types = frozenset({"_hap._tcp.local.", "_hap._udp.local."})
    gateway = "homekit"
    is_shared = True
    code_prefix = "X-HM:"
    read_code = staticmethod(read_homekit_code)

    @classmethod
    def declared(cls, service: FoundService) -> tuple[str, ...]:
        """Return the ``id``, which looks like a hardware address, and is a random number that each reset changes."""
        return (f"homekit {service.properties['id'].upper()} pairing",) if "id" in service.properties else ()

    @classmethod
    def next_step(cls, service: FoundService) -> str:
        """Return how an accessory is paired that is paired with nobody yet."""
        flags = service.properties.get("sf", "")
        is_free = flags.isdecimal() and len(flags) <= _FLAG_DIGITS and bool(int(flags) & 1)
        return f"add [gateways.homekit], then: homebot pair '{name_of(service)}' CODE" if is_free else ""
