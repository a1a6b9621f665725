"""Signatures on the curve P-256 in plain Python, as the certificates of tests need them; pure.

Neither fast nor safe against who watches its timing: for keys that live as long as a test run.

Source: FIPS 186-5 section 6 (ECDSA); SEC 2 version 2.0, section 2.4.2 (secp256r1).
"""

from __future__ import annotations

import hashlib
import secrets
from typing import Final, Self, TypeAlias, final

__all__ = ["SigningKey"]

_P: Final = 2**256 - 2**224 + 2**192 + 2**96 - 1
_A: Final = -3
_ORDER: Final = 0xFFFFFFFF00000000FFFFFFFFFFFFFFFFBCE6FAADA7179E84F3B9CAC2FC632551

_Point: TypeAlias = tuple[int, int] | None  # None is the point at infinity

_BASE: Final[_Point] = (
    0x6B17D1F2E12C4247F8BCE6E563A440F277037D812DEB33A0F4A13945D898C296,
    0x4FE342E2FE1A7F9B8EE7EB4A7C0F9E162BCE33576B315ECECBB6406837BF51F5,
)


@final
class SigningKey:
    """A private key.

    Args:
        secret: 1 to the order of the curve, exclusive.

    Attributes:
        secret: As given, 32 bytes.
        public: The point, uncompressed, 65 bytes.
    """

    def __init__(self, secret: int) -> None:
        self.secret = secret.to_bytes(32, "big")
        self.public = b"\4" + b"".join(each.to_bytes(32, "big") for each in _times(secret, _BASE) or ())
        self._secret = secret

    @classmethod
    def generate(cls) -> Self:
        """A new key."""
        return cls(1 + secrets.randbelow(_ORDER - 1))

    def sign(self, data: bytes) -> tuple[int, int]:
        """The ECDSA signature of *data* with SHA-256: r and s."""
        digest = int.from_bytes(hashlib.sha256(data).digest(), "big")
        while True:
            nonce = 1 + secrets.randbelow(_ORDER - 1)
            point = _times(nonce, _BASE)
            r = 0 if point is None else point[0] % _ORDER
            s = pow(nonce, -1, _ORDER) * (digest + r * self._secret) % _ORDER
            if r and s:
                return r, s


def _times(factor: int, point: _Point) -> _Point:
    product: _Point = None
    while factor:
        if factor & 1:
            product = _sum(product, point)
        point = _sum(point, point)
        factor >>= 1
    return product


def _sum(one: _Point, other: _Point) -> _Point:
    if one is None or other is None:
        return one or other
    (x, y), (u, v) = one, other
    if x == u and (y + v) % _P == 0:
        return None
    slope = (3 * x * x + _A) * pow(2 * y, -1, _P) if one == other else (v - y) * pow(u - x, -1, _P)
    w = (slope * slope - x - u) % _P
    return w, (slope * (x - w) - y) % _P
