"""Proof that a controller knows the setup code: the accessory's side of SRP (RFC 5054, HAP 5.6.3 to 5.6.6). Pure.

HAP-python's own leaves out zeros in front of numbers, so that it refuses one right code in a hundred.
"""

import secrets
from hashlib import sha512
from typing import Final

_NAME: Final = b"Pair-Setup"
_SIZE: Final = 384
"""Bytes of a number of the group."""

_GENERATOR: Final = 5
_PRIME: Final = int(
    "FFFFFFFFFFFFFFFFC90FDAA22168C234C4C6628B80DC1CD129024E088A67CC74020BBEA63B139B22514A08798E3404DDEF9519B3CD3A431B"
    "302B0A6DF25F14374FE1356D6D51C245E485B576625E7EC6F44C42E9A637ED6B0BFF5CB6F406B7EDEE386BFB5A899FA5AE9F24117C4B1FE6"
    "49286651ECE45B3DC2007CB8A163BF0598DA48361C55D39A69163FA8FD24CF5F83655D23DCA3AD961C62F356208552BB9ED529077096966D"
    "670C354E4ABC9804F1746C08CA18217C32905E462E36CE3BE39E772C180E86039B2783A2EC07A28FB5C55DF06F4C52C9DE2BCBF695581718"
    "3995497CEA956AE515D2261898FA051015728E5A8AAAC42DAD33170D04507A33A85521ABDF1CBA64ECFB850458DBEF0A8AEA71575D060C7D"
    "B3970F85A6E1E4C7ABF5AE8CDB0933D71E8C94E04A25619DCEE3D2261AD2EE6BF12FFA06D98A0864D87602733EC86A64521F2B18177B200C"
    "BBE117577A615D6C770988C0BAD946E208E24FA074E5AB3143DB5BFCE0FD108E4B82D120A93AD2CAFFFFFFFFFFFFFFFF",
    16,
)
"""The group of 3,072 bits (RFC 5054, appendix A)."""


def _digest(*parts: bytes) -> bytes:
    return sha512(b"".join(parts)).digest()


def _number(*parts: bytes) -> int:
    return int.from_bytes(_digest(*parts))


def _full(number: int) -> bytes:
    return number.to_bytes(_SIZE)


_MULTIPLIER: Final = _number(_full(_PRIME), _full(_GENERATOR))
_GROUP: Final = bytes(a ^ b for a, b in zip(_digest(_full(_PRIME)), _digest(bytes([_GENERATOR])), strict=True))


class SetupCodeCheck:
    """One try of a setup code; HAP-python calls its methods, in this order.

    Attributes:
        is_used: Whether a controller has given its key.
    """

    def __init__(self, code: bytes) -> None:
        self.is_used = self._is_proven = False
        self._salt = secrets.token_bytes(16)
        self._verifier = pow(_GENERATOR, _number(self._salt, _digest(_NAME, b":", code)), _PRIME)
        self._public = 0
        while self._public.bit_length() <= 8 * (_SIZE - 1):  # HAP-python would leave out a byte of 0 in front
            self._secret = secrets.randbits(512)
            self._public = (_MULTIPLIER * self._verifier + pow(_GENERATOR, self._secret, _PRIME)) % _PRIME
        self._key = self._expected = self._answer = b""

    def get_challenge(self) -> tuple[bytes, int]:
        """Return the salt, and the accessory's public key."""
        return self._salt, self._public

    def set_A(self, public: bytes) -> None:  # noqa: N802 - HAP-python's name
        """Take the controller's public key.

        Raises:
            ValueError: It is none: with it the key of the session would be known to all (RFC 5054, 2.5.4).
        """
        self.is_used = True
        theirs = int.from_bytes(public)
        if len(public) > _SIZE or theirs % _PRIME == 0:
            raise ValueError("no public key")
        scramble = _number(_full(theirs), _full(self._public))
        shared = pow(theirs * pow(self._verifier, scramble, _PRIME), self._secret, _PRIME)
        self._key = _digest(_full(shared))
        self._expected = _digest(_GROUP, _digest(_NAME), self._salt, public, _full(self._public), self._key)
        self._answer = _digest(public, self._expected, self._key)

    def verify(self, proof: bytes) -> bytes | None:
        """Return the accessory's proof; None if the controller does not know the code."""
        self._is_proven = bool(self._expected) and secrets.compare_digest(self._expected, proof)
        return self._answer if self._is_proven else None

    def get_session_key(self) -> int:
        """Return the key of the session; a random one before the proof."""
        return int.from_bytes(self._key if self._is_proven else secrets.token_bytes(64))
