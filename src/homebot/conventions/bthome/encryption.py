"""Encrypted packets of BTHome v2; the one file that imports ``cryptography`` for them. Pure.

Source: https://bthome.io/encryption. AES-CCM with the bind key of 16 bytes and a check of 4. The nonce is the address
of the device, the UUID 0xFCD2 as it is sent, the byte of flags and a counter of 4 bytes. The counter and the check are
the last eight bytes of a packet.
"""

from __future__ import annotations

from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.ciphers.aead import AESCCM

from homebot.conventions.bthome.packet import BTHomeFrame
from homebot.errors import WireError

__all__ = ["BindKey", "seal"]

_UUID = b"\xd2\xfc"
_CHECK = 4
_COUNTER = 4
_RESTARTS_BELOW = 100
"""A counter may fall below this, and only then: after 2³² packets, or with a new battery, it begins again."""


class BindKey:
    """The key of one device, and the counter of the last packet that it opened.

    Args:
        key: The 16 bytes.
        address: The six bytes of the device's address, in the order in which people write it.
    """

    def __init__(self, key: bytes, address: bytes) -> None:
        self._cipher = AESCCM(key, tag_length=_CHECK)
        self._address = address
        self._counter = -1

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._address.hex(':')})"

    def open(self, frame: BTHomeFrame) -> bytes:
        """Return the objects in an encrypted packet.

        A packet that was opened before is refused, but for the very last one, which devices send several times.

        Raises:
            WireError: It was encrypted with another key, was changed, is too short, or was sent before.
        """
        body = frame.body
        if len(body) <= _COUNTER + _CHECK:
            raise WireError("BTHome: an encrypted packet is too short", body)
        secret, counted, check = body[:-8], body[-8:-4], body[-4:]
        counter = int.from_bytes(counted, "little")
        if _RESTARTS_BELOW <= counter < self._counter:
            raise WireError(f"BTHome: the counter {counter} is below {self._counter}: it was sent before", body)
        nonce = (frame.address or self._address) + _UUID + bytes([frame.flags]) + counted
        try:
            opened = self._cipher.decrypt(nonce, secret + check, None)
        except InvalidTag as exc:
            raise WireError("BTHome: the bind key does not open it", body) from exc
        self._counter = counter
        return opened


def seal(key: bytes, address: bytes, flags: int, counter: int, objects: bytes) -> bytes:
    """Return the service data of an encrypted packet, as a device sends them.

    Args:
        key: The bind key.
        address: The device's address, in the order in which people write it.
        flags: The byte of flags, with bit 0 set.
        counter: How many packets it sent before, modulo 2³².
        objects: What is to be encrypted.
    """
    head, counted = bytes([flags]), counter.to_bytes(_COUNTER, "little")
    sealed = AESCCM(key, tag_length=_CHECK).encrypt(address + _UUID + head + counted, objects, None)
    return head + sealed[:-_CHECK] + counted + sealed[-_CHECK:]
