"""Matter's nodes on the network, and their codes. Pure.

Source: Matter core specification 1.4, 4.3 (discovery), 5.1.3 (QR code: ``MT:`` and base 38) and table 38 (its bits).
"""

from collections.abc import Mapping
from functools import partial
from typing import Final

from homebot.conventions.dns_sd import FoundService
from homebot.conventions.ecosystem import Ecosystem, SetupCode
from homebot.errors import WireError

_BASE38: Final = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ-."
_CHARACTERS: Final = {1: 2, 2: 4, 3: 5}
"""Number of characters by number of bytes, in each group."""

_PAYLOAD: Final = 11
"""Bytes of the part that every Matter code has."""


def read_matter_code(text: str) -> SetupCode:
    """Return the facts in the Matter QR code *text*, in any case; of several joined by ``*``, those of the first.

    Raises:
        WireError: It is not a Matter QR code; the message does not show it.
    """
    vendor, product, _ = numbers = _read(text.upper())
    facts = dict(zip(("vendor_id", "product_id", "discriminator"), map(str, numbers), strict=True))
    return SetupCode("matter", f"Matter device {vendor:#06x}/{product:#06x}", facts, partial(_fits, facts))


def check_matter_setup_code(text: str) -> None:
    """Check that *text* is a Matter setup code: the text of a QR code, or the digits that are printed below it.

    Raises:
        WireError: It is neither; the message does not show it.

    Source: Matter core specification 1.4, 5.1.3 (QR code), 5.1.4 (manual pairing code: 11 or 21 digits).
    """
    if text.startswith("MT:"):
        _read(text)
    elif len(digits := text.replace("-", "").replace(" ", "")) not in {11, 21} or not (
        digits.isascii() and digits.isdecimal()
    ):
        raise WireError("a Matter setup code is a QR code that begins with MT:, or 11 or 21 digits")


def _fits(code: Mapping[str, str], facts: Mapping[str, str]) -> bool:
    """Return whether *facts* have the discriminator, vendor and product, which DNS-SD calls ``D`` and ``VP``."""
    if facts.get("txt_d", facts.get("discriminator")) != code["discriminator"]:
        return False
    vendor, _, product = facts.get("txt_vp", "").partition("+")
    vendor, product = vendor or facts.get("vendor_id", ""), product or facts.get("product_id", "")
    return vendor in {"", code["vendor_id"]} and product in {"", code["product_id"]}


def _read(text: str) -> tuple[int, int, int]:
    """Return vendor, product, and the number by which the device announces itself while it can be commissioned."""
    payload = _base38(text.removeprefix("MT:").partition("*")[0])
    if len(payload) < _PAYLOAD:
        raise WireError(f"a Matter code has {len(payload)} bytes instead of {_PAYLOAD}")
    bits = int.from_bytes(payload[:_PAYLOAD], "little")
    if bits & 0b111:
        raise WireError(f"a Matter code has version {bits & 0b111}; only version 0 is known")
    return bits >> 3 & 0xFFFF, bits >> 19 & 0xFFFF, bits >> 45 & 0xFFF


def _base38(code: str) -> bytes:
    """Decode base 38: groups of five characters for three bytes, the least significant character first."""
    spelled = bytearray()
    for start in range(0, len(code), 5):
        group = code[start : start + 5]
        size = next((size for size, characters in _CHARACTERS.items() if characters == len(group)), 0)
        value = 0
        for character in reversed(group):
            digit = _BASE38.find(character)
            if digit < 0:
                raise WireError(f"a Matter code has the character {character!r}, which base 38 does not have")
            value = value * 38 + digit
        if not size or value >> 8 * size:
            raise WireError("a Matter code has a group of characters that is not base 38")
        spelled += value.to_bytes(size, "little")
    return bytes(spelled)


_NODE = "_matter._tcp.local."


class Matter(Ecosystem):
    """Nodes, those that can be commissioned, and their commissioners."""

    service_types = frozenset({_NODE, "_matterc._udp.local.", "_matterd._udp.local."})
    name_key = "dn"
    code_prefix = "MT:"
    read_code = staticmethod(read_matter_code)

    @classmethod
    def declared(cls, service: FoundService) -> tuple[str, ...] | None:
        """Return the identifier of a node in its fabric, as Home Assistant spells it."""
        is_node = service.service_type == _NODE
        return (f"matter:deviceid_{service.name.upper()}-MatterNodeDevice",) if is_node else None
