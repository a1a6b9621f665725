"""Setup codes of Matter and HomeKit: the facts in them that are not secret. Pure.

Matter core specification 1.4, section 5.1.3 (QR code: ``MT:`` and base 38) and table 38 (its bits); HomeKit: the
``X-HM://`` URI of the HomeKit Accessory Protocol specification (R2), section 4.2.2.1 (setup payload) and 6.4 (``sh``).
"""

import base64
import hashlib
from dataclasses import dataclass
from typing import Final

from homebot.errors import WireError

__all__ = [
    "HomekitCode",
    "MatterCode",
    "check_matter_setup_code",
    "read_homekit_code",
    "read_homekit_digits",
    "read_matter_code",
]

_BASE38: Final = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ-."
_BASE36: Final = _BASE38[:36]
_CHARACTERS: Final = {1: 2, 2: 4, 3: 5}
"""Number of characters by number of bytes, in each group."""

_PAYLOAD: Final = 11
"""Bytes of the part that every Matter code has."""

_HOMEKIT: Final = "X-HM://"
_HOMEKIT_DIGITS: Final = 9
_SETUP_ID: Final = 4


@dataclass(frozen=True, slots=True)
class MatterCode:
    """The facts in a Matter QR code, without its passcode.

    Attributes:
        discriminator: The number by which the device announces itself while it can be commissioned.
    """

    vendor: int
    product: int
    discriminator: int


@dataclass(frozen=True, slots=True)
class HomekitCode:
    """The facts in a HomeKit QR code, without its setup code.

    Attributes:
        category: The number of the accessory category.
        setup_id: Four characters that identify the accessory; empty for none.
    """

    category: int
    setup_id: str

    def is_of(self, device_id: str, setup_hash: str) -> bool:
        """Return whether it is the code of the device that announces *device_id* (``id``) and *setup_hash* (``sh``)."""
        spelled = hashlib.sha512(f"{self.setup_id}{device_id.upper()}".encode()).digest()[:4]
        return bool(self.setup_id) and base64.b64encode(spelled).decode() == setup_hash


def read_matter_code(text: str) -> MatterCode:
    """Return the facts in the Matter QR code *text*; of several joined by ``*``, those of the first.

    Raises:
        WireError: It is not a Matter QR code; the message does not show it.
    """
    code = text.removeprefix("MT:").partition("*")[0]
    payload = _base38(code)
    if len(payload) < _PAYLOAD:
        raise WireError(f"a Matter code has {len(payload)} bytes instead of {_PAYLOAD}")
    bits = int.from_bytes(payload[:_PAYLOAD], "little")
    if bits & 0b111:
        raise WireError(f"a Matter code has version {bits & 0b111}; only version 0 is known")
    return MatterCode(bits >> 3 & 0xFFFF, bits >> 19 & 0xFFFF, bits >> 45 & 0xFFF)


def check_matter_setup_code(text: str) -> None:
    """Check that *text* is a Matter setup code: the text of a QR code, or the digits that are printed below it.

    Raises:
        WireError: It is neither; the message does not show it.

    Source: Matter core specification 1.4, 5.1.3 (QR code), 5.1.4 (manual pairing code: 11 or 21 digits).
    """
    if text.startswith("MT:"):
        read_matter_code(text)
    elif len(digits := text.replace("-", "").replace(" ", "")) not in {11, 21} or not (
        digits.isascii() and digits.isdecimal()
    ):
        raise WireError("a Matter setup code is a QR code that begins with MT:, or 11 or 21 digits")


def read_homekit_code(text: str) -> HomekitCode:
    """Return the facts in the HomeKit QR code *text*.

    Raises:
        WireError: It is not a HomeKit QR code; the message does not show it.
    """
    code = text.upper().removeprefix(_HOMEKIT)
    digits, setup_id = code[:_HOMEKIT_DIGITS], code[_HOMEKIT_DIGITS:]
    whole = (*digits, *setup_id)
    if len(digits) < _HOMEKIT_DIGITS or len(setup_id) not in {0, _SETUP_ID} or any(one not in _BASE36 for one in whole):
        raise WireError("a HomeKit code must have 9 digits of base 36, and then a setup ID of 4 or nothing")
    return HomekitCode(int(digits, 36) >> 31 & 0xFF, setup_id)


def read_homekit_digits(text: str) -> str:
    """Return the setup code in *text*, which is a HomeKit QR code or eight digits, as ``123-45-678``.

    Raises:
        WireError: It is neither; the message does not show it.
    """
    digits = text.replace("-", "").replace(" ", "")
    if text.upper().startswith(_HOMEKIT):
        read_homekit_code(text)
        digits = f"{int(text.upper().removeprefix(_HOMEKIT)[:_HOMEKIT_DIGITS], 36) & 0x7FFFFFF:08}"
    if len(digits) != 8 or not (digits.isascii() and digits.isdecimal()):
        raise WireError("a HomeKit code is a QR code that begins with X-HM://, or 8 digits such as 123-45-678")
    return f"{digits[:3]}-{digits[3:5]}-{digits[5:]}"


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
