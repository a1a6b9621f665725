"""Encrypted packets of BTHome v2; the one file that imports ``cryptography`` for them. Pure.

Source: https://bthome.io/encryption. AES-CCM with the bind key of 16 bytes and a check of 4. The nonce is the address
of the device, the UUID 0xFCD2 as it is sent, the flags byte and a counter of 4 bytes. The counter and the check are the
last eight bytes of a packet.

The counter goes up with each packet and protects against replays of recorded packets.
It is compared as a serial number (RFC 1982), so that it may wrap around after 2**32 packets. A lower one is accepted
only where the device has begun to count again, as many do with a new battery; see :class:`BindKey`.
"""

from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.ciphers.aead import AESCCM

from homebot.errors import WireError
from homebot.integrations.bthome.formats.packet import BTHomeFrame
from homebot.support.bounded_map import BoundedMap

_UUID = b"\xd2\xfc"
_CHECK = 4
_COUNTER = 4
_HALF = 2 ** (8 * _COUNTER - 1)
_TRAILER = _COUNTER + _CHECK

RESTARTS_BELOW = 100
"""A counter that begins again is below this, as in ``bthome-ble``."""

RESTARTS_AFTER = 30.0
"""Seconds of silence before a counter may begin again: to change a battery takes a moment."""

MAX_REMEMBERED = 1000
"""Packets that are remembered of each key, and as many with counters below 100; the oldest are forgotten first."""


class BindKey:
    """The key of one device, and the counter of the last packet that it opened.

    The first packet may have any counter. After that, the counter has to go up. It may begin again below 100 if nothing
    was opened for 30 seconds. A packet that was opened before is never opened again: the last thousand are remembered,
    and a thousand with counters below 100. Packets recorded before homebot was started are unknown to it, and are
    opened if their counters fit.

    Args:
        key: The 16 bytes.
        address: The six bytes of the device's address, in the order in which people write it.
    """

    def __init__(self, key: bytes, address: bytes) -> None:
        self._cipher = AESCCM(key, tag_length=_CHECK)
        self._address = address
        self._counter: int | None = None
        self._last = b""
        self._opened_at = float("-inf")
        self._low: BoundedMap[bytes, None] = BoundedMap(MAX_REMEMBERED)
        self._recent: BoundedMap[bytes, None] = BoundedMap(MAX_REMEMBERED)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._address.hex(':')})"

    def open(self, frame: BTHomeFrame, now: float) -> bytes | None:
        """Return the objects in an encrypted packet; None for the last packet again, which devices send several times.

        The time *now* is in seconds of a monotonic clock.

        Raises:
            WireError: It was encrypted with another key, was changed, is too short, or is a replay.
        """
        body = frame.body
        if len(body) <= _TRAILER:
            raise WireError("BTHome: an encrypted packet is too short", body)
        if body == self._last:
            return None
        secret, trailer = body[:-_TRAILER], body[-_TRAILER:]
        counted, check = trailer[:_COUNTER], trailer[_COUNTER:]
        counter = int.from_bytes(counted, "little")
        was_opened = trailer in self._low or trailer in self._recent
        is_newer = self._counter is None or 0 < (counter - self._counter) % (2 * _HALF) < _HALF
        may_restart = counter < RESTARTS_BELOW and now - self._opened_at >= RESTARTS_AFTER
        if was_opened or not (is_newer or may_restart):
            raise WireError(f"BTHome: the counter {counter} does not follow {self._counter}: it may be a replay", body)
        nonce = (frame.address or self._address) + _UUID + bytes([frame.flags]) + counted
        try:
            opened = self._cipher.decrypt(nonce, secret + check, None)
        except InvalidTag as exc:
            raise WireError("BTHome: the bind key does not open it", body) from exc
        self._counter, self._last, self._opened_at = counter, body, now
        remembered = self._low if counter < RESTARTS_BELOW else self._recent
        remembered[trailer] = None
        return opened


def seal(key: bytes, address: bytes, flags: int, counter: int, objects: bytes) -> bytes:
    """Return the service data of an encrypted packet, as a device sends them.

    Args:
        address: The device's address, in the order in which people write it.
        flags: The byte of flags, with bit 0 set.
        counter: How many packets it sent before, modulo 2³².
        objects: The plain text.
    """
    head, counted = bytes([flags]), counter.to_bytes(_COUNTER, "little")
    sealed = AESCCM(key, tag_length=_CHECK).encrypt(address + _UUID + head + counted, objects, None)
    return head + sealed[:-_CHECK] + counted + sealed[-_CHECK:]
