"""A certificate for 127.0.0.1 and localhost with an authority of its own, made in the standard library alone; pure.

Source: RFC 5280 (certificates), RFC 5480 and RFC 5915 (keys on a curve), ITU-T X.690 (DER).
"""

from __future__ import annotations

import base64
import hashlib
import ipaddress
import secrets
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Self

from homebot.testing.mqtt.p256 import SigningKey

__all__ = ["ServerCertificate"]

_VALID = timedelta(days=30)  # a test run, however long, on a computer with a wrong clock
_NAMES = ("localhost",)
_ADDRESSES = ("127.0.0.1", "::1")
_AUTHORITY = "homebot tests"

_SEQUENCE, _SET, _BOOLEAN, _INTEGER, _BITS, _OCTETS, _OID, _UTF8, _TIME = 0x30, 0x31, 1, 2, 3, 4, 6, 12, 24


@dataclass(frozen=True, slots=True)
class ServerCertificate:
    """What a server shows and what its clients trust, in PEM form.

    Attributes:
        authority: The authority's certificate, for clients.
        certificate: The server's certificate.
        key: The server's key; never shown.
    """

    authority: str
    certificate: str
    key: str

    def __repr__(self) -> str:
        return "ServerCertificate(...)"

    @classmethod
    def make(cls, now: datetime) -> Self:
        """New keys and certificates.

        Args:
            now: In UTC; they hold from a day before to thirty days after.
        """
        authority, server = SigningKey.generate(), SigningKey.generate()
        names = b"".join(_der(0x82, name.encode()) for name in _NAMES)
        addresses = b"".join(_der(0x87, ipaddress.ip_address(each).packed) for each in _ADDRESSES)
        of_authority = [
            _extension("551d13", _der(_SEQUENCE, _der(_BOOLEAN, b"\xff")), critical=True),  # basicConstraints: CA
            _extension("551d0f", _der(_BITS, b"\2\4"), critical=True),  # keyUsage: keyCertSign
            _extension("551d0e", _der(_OCTETS, _key_id(authority))),
        ]
        of_server = [
            _extension("551d13", _der(_SEQUENCE), critical=True),
            _extension("551d0f", _der(_BITS, b"\7\x80"), critical=True),  # keyUsage: digitalSignature
            _extension("551d25", _der(_SEQUENCE, _der(_OID, bytes.fromhex("2b06010505070301")))),  # serverAuth
            _extension("551d11", _der(_SEQUENCE, names, addresses)),
            _extension("551d0e", _der(_OCTETS, _key_id(server))),
            _extension("551d23", _der(_SEQUENCE, _der(0x80, _key_id(authority)))),
        ]
        return cls(
            _pem("CERTIFICATE", _certificate(_AUTHORITY, authority, authority, of_authority, now)),
            _pem("CERTIFICATE", _certificate("localhost", server, authority, of_server, now)),
            _pem("EC PRIVATE KEY", _private_key(server)),
        )


def _certificate(name: str, key: SigningKey, issuer: SigningKey, extensions: list[bytes], now: datetime) -> bytes:
    algorithm = _der(_SEQUENCE, _der(_OID, bytes.fromhex("2a8648ce3d040302")))  # ecdsa-with-SHA256
    content = _der(
        _SEQUENCE,
        _der(0xA0, _integer(2)),  # version 3
        _integer(1 + secrets.randbits(120)),
        algorithm,
        _name(_AUTHORITY),
        _der(_SEQUENCE, _time(now - timedelta(days=1)), _time(now + _VALID)),
        _name(name),
        _der(_SEQUENCE, _der(_SEQUENCE, _EC_KEY, _P256), _der(_BITS, b"\0", key.public)),
        _der(0xA3, _der(_SEQUENCE, *extensions)),
    )
    signature = _der(_SEQUENCE, *map(_integer, issuer.sign(content)))
    return _der(_SEQUENCE, content, algorithm, _der(_BITS, b"\0", signature))


def _private_key(key: SigningKey) -> bytes:
    public = _der(0xA1, _der(_BITS, b"\0", key.public))
    return _der(_SEQUENCE, _integer(1), _der(_OCTETS, key.secret), _der(0xA0, _P256), public)


def _extension(oid: str, value: bytes, *, critical: bool = False) -> bytes:
    mark = _der(_BOOLEAN, b"\xff") if critical else b""
    return _der(_SEQUENCE, _der(_OID, bytes.fromhex(oid)), mark, _der(_OCTETS, value))


def _name(common: str) -> bytes:
    return _der(_SEQUENCE, _der(_SET, _der(_SEQUENCE, _der(_OID, b"\x55\4\3"), _der(_UTF8, common.encode()))))


def _key_id(key: SigningKey) -> bytes:
    return hashlib.sha256(key.public).digest()[:20]  # RFC 7093, section 2


def _time(moment: datetime) -> bytes:
    """As UTCTime, which RFC 5280 wants until 2049."""
    if moment.year < 2050:
        return _der(0x17, f"{moment:%y%m%d%H%M%SZ}".encode())
    return _der(_TIME, f"{moment:%Y%m%d%H%M%SZ}".encode())


def _integer(value: int) -> bytes:
    return _der(_INTEGER, value.to_bytes(value.bit_length() // 8 + 1, "big"))


def _der(tag: int, *parts: bytes) -> bytes:
    body = b"".join(parts)
    size = len(body)
    if size < 0x80:
        return bytes((tag, size)) + body
    length = size.to_bytes((size.bit_length() + 7) // 8, "big")
    return bytes((tag, 0x80 | len(length))) + length + body


def _pem(what: str, data: bytes) -> str:
    text = base64.b64encode(data).decode()
    lines = [text[start : start + 64] for start in range(0, len(text), 64)]
    return "\n".join([f"-----BEGIN {what}-----", *lines, f"-----END {what}-----", ""])


_EC_KEY = _der(_OID, bytes.fromhex("2a8648ce3d0201"))
_P256 = _der(_OID, bytes.fromhex("2a8648ce3d030107"))
