"""HomeKit's accessories on the network, and their codes. Pure.

Source: HomeKit Accessory Protocol Specification R2, 4.2.2.1 (setup payload: ``X-HM://``), 6.4 (``sh``) and table 6-8
(status flags).
"""

import base64
import hashlib
from collections.abc import Mapping
from functools import partial
from string import ascii_uppercase, digits
from typing import Final

from homebot.conventions.dns_sd import FoundService, name_of
from homebot.conventions.ecosystem import Ecosystem, SetupCode
from homebot.devices.names import OWN_MODEL
from homebot.errors import WireError

_BASE36: Final = digits + ascii_uppercase
_URI: Final = "X-HM://"
_DIGITS: Final = 9
_SETUP_ID: Final = 4


def read_homekit_code(text: str) -> SetupCode:
    """Return the facts in the HomeKit QR code *text*: the category of the accessory, and its setup ID, if it has one.

    Raises:
        WireError: It is not a HomeKit QR code; the message does not show it.
    """
    code = text.upper().removeprefix(_URI)
    number, setup_id = code[:_DIGITS], code[_DIGITS:]
    whole = (*number, *setup_id)
    if len(number) < _DIGITS or len(setup_id) not in {0, _SETUP_ID} or any(sign not in _BASE36 for sign in whole):
        raise WireError("a HomeKit code must have 9 digits of base 36, and then a setup ID of 4 or nothing")
    facts = {"category": str(int(number, 36) >> 31 & 0xFF), "setup_id": setup_id}
    return SetupCode("homekit", "HomeKit device", facts, partial(_fits, setup_id))


def read_homekit_digits(text: str) -> str:
    """Return the setup code in *text*, which is a HomeKit QR code or eight digits, as ``123-45-678``.

    Raises:
        WireError: It is neither; the message does not show it.
    """
    digits = text.replace("-", "").replace(" ", "")
    if text.upper().startswith(_URI):
        read_homekit_code(text)
        digits = f"{int(text.upper().removeprefix(_URI)[:_DIGITS], 36) & 0x7FFFFFF:08}"
    if len(digits) != 8 or not (digits.isascii() and digits.isdecimal()):
        raise WireError("a HomeKit code is a QR code that begins with X-HM://, or 8 digits such as 123-45-678")
    return f"{digits[:3]}-{digits[3:5]}-{digits[5:]}"


def _fits(setup_id: str, facts: Mapping[str, str]) -> bool:
    """Return whether *facts* are of the device with *setup_id*, as DNS-SD announces them (``id`` and ``sh``)."""
    device, setup_hash = (facts.get(name, "") for name in ("txt_id", "txt_sh"))
    spelled = hashlib.sha512(f"{setup_id}{device.upper()}".encode()).digest()[:4]
    return bool(setup_id) and base64.b64encode(spelled).decode() == setup_hash


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
    def is_own(cls, service: FoundService) -> bool:
        """Return whether it is a bridge of homebot."""
        return service.properties.get("md") == OWN_MODEL

    @classmethod
    def next_step(cls, service: FoundService) -> str:
        """Return how an accessory is paired that is paired with nobody yet."""
        flags = service.properties.get("sf", "")
        is_free = flags.isdecimal() and len(flags) <= _FLAG_DIGITS and bool(int(flags) & 1)
        return f"add [gateways.homekit], then: homebot pair '{name_of(service)}' CODE" if is_free else ""
