"""Making of the router's certificate, which is its own authority: others trust it by its file."""

from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Final

from cryptography import x509
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
from cryptography.x509.oid import NameOID

from homebot.errors import UsageError
from homebot.support.authority import general_name

_THIS_COMPUTER: Final = ("localhost", "127.0.0.1", "::1")
_VALID: Final = timedelta(days=3650)
_EARLIER: Final = timedelta(days=1)
"""A robot's clock may be behind."""


def make_certificate(cert_file: Path, key_file: Path, names: Sequence[str], now: float) -> None:
    """Write a certificate for the host with *names*, for ten years, and its key, which only its owner can read.

    Args:
        names: Names and addresses by which others reach the host.
        now: The time, in seconds since 1970.

    Raises:
        UsageError: One of the files is there, or cannot be written.
    """
    key, start = ec.generate_private_key(ec.SECP256R1()), datetime.fromtimestamp(now, UTC) - _EARLIER
    own = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "homebot router")])
    alternatives = [general_name(name) for name in dict.fromkeys((*names, *_THIS_COMPUTER))]
    certificate = (
        x509.CertificateBuilder(own, own, key.public_key(), x509.random_serial_number(), start, start + _VALID)
        .add_extension(x509.SubjectAlternativeName(alternatives), critical=False)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .sign(key, SHA256())
    )
    private = key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
    if cert_file.exists():
        raise UsageError(f"{cert_file} is there; remove it and {key_file} first, if others may trust it no longer")
    try:
        key_file.touch(0o600, exist_ok=False)
        key_file.write_bytes(private)
        cert_file.write_bytes(certificate.public_bytes(Encoding.PEM))
    except OSError as exc:
        raise UsageError(f"{exc.filename} cannot be written: {exc.strerror}") from exc
