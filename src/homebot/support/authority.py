"""A local certificate authority in a folder, and the certificates that it makes for this computer.

It is made once, and devices that know it trust all its certificates. The only file but one that uses ``cryptography``
for certificates, an extra.
"""

import socket
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Final, NamedTuple

from cryptography import x509
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat, load_pem_private_key
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from homebot.errors import UsageError
from homebot.support.addresses import parse_address
from homebot.support.file_access import replace_file

AUTHORITY: Final = "authority.crt"

_AUTHORITY_LASTS: Final = timedelta(days=3650)
_LASTS: Final = timedelta(days=397)
"""Safari and Chromium refuse certificates that are valid for more than 398 days."""

_RENEWED: Final = timedelta(days=30)
_EARLIER: Final = timedelta(days=1)
"""A tablet's clock may be behind."""


class _Certificate(NamedTuple):
    certificate: x509.Certificate
    key: ec.EllipticCurvePrivateKey

    def write(self, folder: Path, name: str, issuer: bytes = b"") -> None:
        """Write both as ``NAME.crt``, followed by that of the *issuer*, and ``NAME.key``, for their owner to read."""
        key = self.key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
        for suffix, content in (("key", key), ("crt", self.certificate.public_bytes(Encoding.PEM) + issuer)):
            replace_file(folder / f"{name}.{suffix}", content)


def renew_certificate(folder: Path, name: str, hosts: list[str], now: float) -> tuple[Path, Path]:
    """Return the files of the certificate *name* and its key, which are made, or made anew, where that is due.

    It is due in the last month before their end, and if *hosts* has a name or an address that is not in it. Blocking.

    Args:
        now: The time, in seconds since 1970.

    Raises:
        UsageError: A file in *folder* is not one that homebot made.
        OSError: A file cannot be read or written.
    """
    files, at = (folder / f"{name}.crt", folder / f"{name}.key"), datetime.fromtimestamp(now, UTC)
    wanted = [general_name(host) for host in hosts]
    try:
        if all(file.exists() for file in files):
            known = x509.load_pem_x509_certificate(files[0].read_bytes())
            present = known.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
            if at < known.not_valid_after_utc - _RENEWED and {*wanted} <= {*present}:
                return files
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        authority = _authority(folder, at)
    except (ValueError, x509.ExtensionNotFound) as exc:
        raise UsageError(f"{folder} has a certificate that homebot did not make; remove its files: {exc}") from exc
    made = _make("homebot", authority, at, x509.SubjectAlternativeName(wanted))
    made.write(folder, name, authority.certificate.public_bytes(Encoding.PEM))
    return files


def general_name(host: str) -> x509.GeneralName:
    """Return a name or an address as certificates have it."""
    address = parse_address(host)
    return x509.DNSName(host) if address is None else x509.IPAddress(address)


def _authority(folder: Path, now: datetime) -> _Certificate:
    """Return the authority in *folder*, which is made if there is none."""
    file, key_file = folder / AUTHORITY, (folder / AUTHORITY).with_suffix(".key")
    if file.exists() and key_file.exists():
        key = load_pem_private_key(key_file.read_bytes(), None)
        if not isinstance(key, ec.EllipticCurvePrivateKey):
            raise ValueError(f"{key_file.name} is a key of another kind")
        return _Certificate(x509.load_pem_x509_certificate(file.read_bytes()), key)
    made = _make(f"homebot at {socket.gethostname()}"[:64], None, now, None)
    made.write(folder, file.stem)
    return made


def _make(
    name: str, authority: _Certificate | None, now: datetime, names: x509.SubjectAlternativeName | None
) -> _Certificate:
    """Return a certificate for *names* by the *authority*; without both, an authority (RFC 5280, section 4.2)."""
    key, is_authority = ec.generate_private_key(ec.SECP256R1()), authority is None
    own = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
    issuer, signer = (own, key) if authority is None else (authority.certificate.subject, authority.key)
    usage = x509.KeyUsage(
        digital_signature=not is_authority,
        content_commitment=False,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=False,
        key_cert_sign=is_authority,
        crl_sign=is_authority,
        encipher_only=False,
        decipher_only=False,
    )
    ends = now + (_AUTHORITY_LASTS if is_authority else _LASTS)
    builder = (
        x509.CertificateBuilder(issuer, own, key.public_key(), x509.random_serial_number(), now - _EARLIER, ends)
        .add_extension(x509.BasicConstraints(ca=is_authority, path_length=0 if is_authority else None), critical=True)
        .add_extension(usage, critical=True)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
        .add_extension(x509.AuthorityKeyIdentifier.from_issuer_public_key(signer.public_key()), critical=False)
    )
    if names is not None:
        purpose = x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH])
        builder = builder.add_extension(names, critical=False).add_extension(purpose, critical=False)
    return _Certificate(builder.sign(signer, SHA256()), key)
